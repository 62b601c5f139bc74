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

// Any number of dimensions, two at a time: what a path needs at each of its vertices. Pairs below
// sampler_dimensions / 2 are those of fill_samples. Later ones of sobol are its first two
// dimensions again, in another order: a hash of the pair shuffles a pixel's samples, its
// neighbours' and the blocks they form as Owen's scrambling does, so each pair keeps what sobol
// promises, and pairs are independent of each other ("padding", Burley 2020).
struct Disk {
    float u, v;
};
struct SampleSequence {
    Sampler sampler = Sampler::independent;
    std::uint32_t start = 0;  // sobol: of the pixel in its sequence
    std::uint32_t columns = 1, rows = 1;
    std::uint64_t key = 0;
    // Pairs that somebody else chose: bit i of given_pairs is set where pair i is given[i].
    std::uint32_t given_pairs = 0;
    const Disk* given = nullptr;
    // Pair `pair` of sample `index` of the pixel. Cost: 10 to 30 ns. Threads: pure.
    Disk operator()(std::uint32_t index, std::uint32_t pair) const;
};
SampleSequence sample_sequence(Sampler sampler, std::uint64_t seed, int x, int y, int spp);

// The unit square to the unit disk, areas kept (Shirley and Chiu 1997).
Disk concentric_disk(float a, float b);
// Back to the square; what is outside goes to its border.
Disk concentric_square(float u, float v);

}  // namespace weft
