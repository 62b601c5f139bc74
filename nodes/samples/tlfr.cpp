#include "samples/tlfr.h"

#include <fmt/format.h>

#include <cmath>

#include "graph/error.h"
#include "runtime/context.h"
#include "samples/channel_choice.h"
#include "samples/check_samples.h"
#include "samples/record_channels.h"

namespace weft {
namespace {

enum : size_t { x, y, z_over_w, w, u, v, t, r, g, b, a, mv_x, mv_y, mv_w, dwdx, dwdy, width };

// Depth and motion, with what stands for infinity restored.
void add_depth_and_motion(const Array<float>& records, Samples& samples) {
    std::vector<float> depth(samples.size()), motion(3 * samples.size());
    for (size_t i = 0; i < samples.size(); ++i) {
        const float* record = records.view().data() + i * width;
        depth[i] = record[w];
        const bool infinite = depth[i] >= record_infinity;
        for (size_t k = 0; k < 3; ++k) motion[3 * i + k] = infinite ? 0 : record[mv_x + k];
    }
    restore_infinite_depth(depth);
    samples.add("z", 1, std::move(depth));
    samples.add("motion", 3, std::move(motion));
}

}  // namespace

Samples read_tlfr(const RecordFiles& files, const RecordHeader& header, const ReadOptions& options,
                  Context& ctx) {
    refuse_unknown_channels(options, files.data.name,
                            {"xy", "uv", "t", "z", "motion", "z_gradient", "rgb"});
    const Array<float> records = read_records(files, header, ctx);
    Samples samples = samples_of_header(header);
    const auto add = [&](std::string name, size_t first, size_t components) {
        const Role role = standard_role(name);
        samples.add(Channel{std::move(name),
                            int(components),
                            role,
                            columns(records, width, first, components, ctx),
                            {}});
    };
    add("xy", x, 2);
    add("uv", u, 2);
    add("t", t, 1);
    add_depth_and_motion(records, samples);
    add("z_gradient", dwdx, 2);
    add("rgb", r, 3);
    drop_idle_channels(samples);
    check_samples(samples, files.data.name, options.tolerate, ctx);
    return samples;
}

void write_tlfr(const Samples& samples, const std::string& path, bool text, Context& ctx) {
    check_record_writable(samples, path, SampleFormat::tlfr,
                          {"xy", "uv", "t", "z", "motion", "z_gradient", "rgb"}, ctx);
    RecordHeader header;
    header.kind = RecordKind::tlfr;
    header.width = samples.width;
    header.height = samples.height;
    header.spp = samples.spp;
    header.text = text;
    if (samples.lens) header.c0 = samples.lens->c0, header.c1 = samples.lens->c1;

    const auto put = [](std::span<float> record, size_t first, std::span<const float> channel,
                        size_t sample, size_t components) {
        for (size_t k = 0; k < components && !channel.empty(); ++k)
            record[first + k] = channel[sample * components + k];
    };
    size_t lost_motion = 0;
    write_records(path, header, ctx, [&](size_t i, std::span<float> record) {
        put(record, x, samples.xy(), i, 2);
        put(record, w, samples.z(), i, 1);
        put(record, u, samples.uv(), i, 2);
        put(record, t, samples.t(), i, 1);
        put(record, r, samples.rgb(), i, 3);
        record[a] = 1;
        put(record, mv_x, samples.motion(), i, 3);
        put(record, dwdx, samples.values("z_gradient"), i, 2);
        if (std::isinf(record[w])) {
            record[w] = record_infinity;
            lost_motion += record[mv_x] != 0 || record[mv_y] != 0 || record[mv_w] != 0;
            record[mv_x] = record[mv_y] = record[mv_w] = 0;
        }
    });
    if (lost_motion > 0)
        ctx.warn(fmt::format(
            "{}: TLFR 1.3 holds no motion of what is infinitely far: that of {} sample{} "
            "is written as 0",
            path, lost_motion, lost_motion == 1 ? "" : "s"));
}

}  // namespace weft
