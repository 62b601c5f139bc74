// Rendered samples as a whole: rows of pixels at a time into a Samples, with what its meta says of
// lens, shutter, lights and camera.
#pragma once
#include "render/sample_plan.h"
#include "samples/samples.h"

namespace weft::render {

// Everything but the samples: size, lens, meta, channels that are empty.
Samples empty_samples(const PathTracer& tracer, const SamplePlan& plan);
// meta.lights: the scene's lights, then its emitting meshes, in the order of `light_index`. Of a mesh
// with at most 4096 triangles where these are, at the shutter's opening and, if it moves, at its
// close.
Json lights_meta(const PathTracer& tracer);

// The channels of a run of samples, in the order of a ChannelSet's list.
struct ChannelArrays {
    std::array<std::vector<float>, channel_count> values;
    std::array<std::vector<std::uint32_t>, channel_count> ids;
    void resize(const ChannelSet& channels, size_t samples);
};

// Renders rows [begin, end) of the picture into `to`, whose first sample is number `offset` of the
// buffer.
void render_rows(const PathTracer& tracer, const SamplePlan& plan, int begin, int end,
                 std::uint64_t offset, RenderWorkers& workers, ChannelArrays& to, Context& ctx);
// Gives the arrays to a buffer that empty_samples() made.
void give_channels(const ChannelSet& channels, ChannelArrays arrays, Samples& to);

// Pixels [begin, end) of a row go together into a worker's hands: what a loop's piece is.
inline constexpr int pixels_in_piece = 64;

}  // namespace weft::render
