// Samplers: numbers in [0, 1) from (seed, pixel, sample index, dimension) and nothing else, so that
// any pixel's samples can be made by anybody, in any order, on any thread.
//
//   independent  a hash of the four; no structure
//   stratified   dimensions (0, 1), (2, 3), ... in a jittered grid a pair, the last odd one
//   jittered in
//                a line; pairs are shuffled against each other within the pixel
//   sobol        Owen-scrambled Sobol' points; neighbouring pixels take consecutive pieces of one
//                sequence along a shuffled Z-order curve, so a pixel's samples are stratified and
//                so are those of a 2x2 block, a 4x4 block ...: at one sample a pixel this is what
//                counts
//
// Source: Sobol' 1967 with the direction numbers of Joe and Kuo 2008; scrambling by a hash of the
// higher bits, Laine and Karras 2011, Burley 2020 (constants: Vegdahl 2021); the curve as Ahmed and
// Wonka 2020, there in base 4 with all 24 orders, here the 8 that base 2 gives.
#pragma once
#include <cstdint>
#include <span>

namespace weft {

enum class Sampler { independent, stratified, sobol };

// Numbers a sample that a sampler can give.
inline constexpr int sampler_dimensions = 10;

// Dimensions [0, dimensions) of samples [first, first + count) of pixel (x, y), which has `spp` in
// all. out[d * stride + i] is dimension d of sample first + i. Cost: a few ns a number, no
// allocation.  Threads: pure.
void fill_samples(Sampler sampler, std::uint64_t seed, int x, int y, int spp, int first, int count,
                  int dimensions, float* out, size_t stride);

// The unit square to the unit disk, areas kept (Shirley and Chiu 1997).
struct Disk {
    float u, v;
};
Disk concentric_disk(float a, float b);

}  // namespace weft
