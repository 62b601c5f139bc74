#include "render/sample_channels.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "graph/error.h"

namespace weft::render {
namespace {

constexpr std::array<ChannelInfo, channel_count> infos{{
    {"xy", 2},
    {"uv", 2},
    {"t", 1},
    {"z", 1},
    {"motion", 3},
    {"z_gradient", 2},
    {"rgb", 3},
    {"alpha", 1},
    {"position", 3},
    {"normal", 3},
    {"geometric_normal", 3},
    {"albedo", 3},
    {"roughness", 1},
    {"emission", 3},
    {"id", 1, true},
    {"direct", 3},
    {"direct_unshadowed", 3},
    {"diffuse", 3},
    {"specular", 3},
    {"light_uv", 2},
    {"light_index", 1, true},
    {"bounce", 3},
    {"position2", 3},
    {"normal2", 3},
    {"albedo2", 3},
    {"shadow_hit", 3},
    {"shadow_normal", 3},
    {"shadow_motion", 3},
    {"light_point", 3},
}};

}  // namespace

const ChannelInfo& info_of(ChannelId channel) {
    return infos[size_t(channel)];
}

std::vector<ChannelId> ChannelSet::list() const {
    std::vector<ChannelId> out;
    for (size_t i = 0; i < channel_count; ++i)
        if (wanted_[i]) out.push_back(ChannelId(i));
    return out;
}

size_t ChannelSet::numbers() const {
    size_t sum = 0;
    for (const ChannelId c : list()) sum += size_t(info_of(c).components);
    return sum;
}

ChannelSet channel_set(std::span<const std::string> names, bool lens, bool motion) {
    ChannelSet set;
    for (const std::string& name : names) {
        bool known = false;
        if (name == "basic") {
            known = true;
            for (const ChannelId c :
                 {ChannelId::xy, ChannelId::z, ChannelId::rgb, ChannelId::alpha})
                set.add(c);
            if (lens) set.add(ChannelId::uv);
            if (motion) set.add(ChannelId::t), set.add(ChannelId::motion);
        }
        for (size_t i = 0; i < channel_count; ++i)
            if (name == "all" || name == infos[i].name) set.add(ChannelId(i)), known = true;
        if (known) continue;
        std::vector<std::string_view> there{"basic", "all"};
        for (const ChannelInfo& info : infos) there.push_back(info.name);
        throw Error(fmt::format("no channel '{}'; there are {}", name, fmt::join(there, ", ")));
    }
    // What every buffer has, and what others are worked out from.
    set.add(ChannelId::xy);
    set.add(ChannelId::rgb);
    if (lens && set.has(ChannelId::z_gradient)) set.add(ChannelId::uv);
    return set;
}

void SampleBatch::reset(const ChannelSet& channels, size_t samples) {
    size = samples;
    for (const ChannelId c : channels.list()) {
        if (info_of(c).whole)
            ids[size_t(c)].assign(samples, 0);
        else
            values[size_t(c)].assign(samples * size_t(info_of(c).components), 0.0f);
    }
}

}  // namespace weft::render
