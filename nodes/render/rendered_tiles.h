// RenderedTiles: a tile's samples as they are rendered, batch after batch, pixels in rows and the
// samples of a pixel in their order.
#pragma once
#include "render/sample_plan.h"
#include "samples/samples.h"

namespace weft {

// What all batches of a render share.
struct RenderedHead {
    Samples samples;  // size, spp, lens, meta; no channels
    render::ChannelSet channels;
    const render::SamplePlan* plan = nullptr;
    std::function<void(Context&)> warn;  // says what the render has to say, once; for sinks to call
};

struct RenderedTiles : Batch {
    const RenderedHead* head = nullptr;
    render::SampleBatch batch;
    std::vector<std::uint32_t> own_pixels;

    void count(Items& items) const { items.add("samples", size()); }
    void describe(FieldVisitor& see) const {
        if (!head) return;
        for (const render::ChannelId c : head->channels.list()) {
            const render::ChannelInfo& info = render::info_of(c);
            if (info.whole)
                see.field(info.name, batch.ids[size_t(c)], info.components);
            else
                see.field(info.name, batch.values[size_t(c)], info.components);
        }
    }
};

WEFT_STREAM_TYPE(RenderedTiles, "RenderedTiles", "samples of a tile as they are rendered")

}  // namespace weft
