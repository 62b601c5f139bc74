// What the renderer can say of a sample, by the names of docs/formats.md, and a batch of it.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "samples/vec3.h"

namespace weft::render {

enum class ChannelId {
    xy,
    uv,
    t,
    z,
    motion,
    z_gradient,
    rgb,
    alpha,
    position,
    normal,
    geometric_normal,
    albedo,
    roughness,
    emission,
    id,
    direct,
    direct_unshadowed,
    diffuse,
    specular,
    light_uv,
    light_index,
    bounce,
    position2,
    normal2,
    albedo2,
    shadow_hit,
    shadow_normal,
    shadow_motion,
    light_point,
};
inline constexpr size_t channel_count = size_t(ChannelId::light_point) + 1;

struct ChannelInfo {
    std::string_view name;
    int components;
    bool whole = false;  // whole numbers
};
const ChannelInfo& info_of(ChannelId channel);

// Which channels are made.
class ChannelSet {
  public:
    bool has(ChannelId c) const { return wanted_[size_t(c)]; }
    void add(ChannelId c) { wanted_[size_t(c)] = true; }
    std::vector<ChannelId> list() const;  // in the order above
    size_t numbers() const;               // a sample

  private:
    std::array<bool, channel_count> wanted_{};
};

// From names; xy and rgb are always among them. "basic": xy, z, rgb, alpha, with a lens uv, with
// motion t, motion; "all": everything. Throws Error naming one that is none, with those there are.
ChannelSet channel_set(std::span<const std::string> names, bool lens, bool motion);

// Values of a batch's samples, channel by channel; memory is kept from batch to batch.
struct SampleBatch {
    size_t size = 0;
    std::array<std::vector<float>, channel_count> values;  // size x components
    std::array<std::vector<std::uint32_t>, channel_count> ids;

    // Makes room; everything is 0.
    void reset(const ChannelSet& channels, size_t samples);
    float* at(ChannelId c, size_t i) {
        return &values[size_t(c)][i * size_t(info_of(c).components)];
    }
    const float* at(ChannelId c, size_t i) const {
        return &values[size_t(c)][i * size_t(info_of(c).components)];
    }
    void set(ChannelId c, size_t i, Vec3 v) {
        float* to = at(c, i);
        to[0] = v.x, to[1] = v.y, to[2] = v.z;
    }
};

}  // namespace weft::render
