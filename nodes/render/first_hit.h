// What a batch says of the surfaces that its rays met first: depth, motion, features.
#pragma once
#include "render/camera.h"
#include "render/sample_channels.h"
#include "render/shading.h"

namespace weft::render {

// z, motion, z_gradient, alpha and the features of the first hits, hits k = samples k. Returns how
// far in pixels, at most, a sample lies from the straight path that `motion` gives it.
float write_first_hits(const RayScene& rays, const Camera& camera, const ChannelSet& channels,
                       const Rays& hits, const std::vector<Shade>& shades, size_t n,
                       SampleBatch& out);

// position2, normal2, albedo2; sample[k] is what hit k belongs to.
void write_second_hits(const ChannelSet& channels, const Rays& hits,
                       const std::vector<Shade>& shades, std::span<const std::uint32_t> sample,
                       SampleBatch& out);

// shadow_hit, shadow_normal, shadow_motion of sample i: the first thing that its light sees along
// the sample's own shadow ray, which ends at `point`, where ray k of `hits` met something.
void write_shadow_hit(const RayScene& rays, const Rays& hits, size_t k, const SurfacePoint& point,
                      Vec3 start, const LightSample& light, const ChannelSet& channels, Rays& probe,
                      SampleBatch& out, size_t i);

}  // namespace weft::render
