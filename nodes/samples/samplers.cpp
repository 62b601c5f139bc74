#include "samples/samplers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "samples/random.h"

namespace weft {
namespace {

// ---- stratified -------------------------------------------------------------------------------

// A grid of at least n cells: n's divisors where they are not too unequal, else a little too large.
struct Grid {
    std::uint32_t columns, rows;
};
Grid grid_of(std::uint32_t n) {
    const auto root = std::uint32_t(std::sqrt(double(n)));
    for (std::uint32_t d = root; 2 * d * d >= n && d > 0; --d)
        if (n % d == 0) return {n / d, d};
    const std::uint32_t columns = root * root == n ? root : root + 1;
    return {columns, (n + columns - 1) / columns};
}

// Multi-jittered (Chiu, Shirley and Wang 1994): one point a cell, and a cell's column is divided
// once more by its row, so that each coordinate alone is stratified as finely as there are points.
Disk stratified_pair(Grid grid, std::uint32_t index, std::uint64_t key) {
    const std::uint32_t cell = shuffled(index, grid.columns * grid.rows, mix(key));
    const std::uint32_t column = cell % grid.columns, row = cell / grid.columns;
    const std::uint64_t jitter = mix(key + mix(cell + 1));
    const float x =
        float(shuffled(row, grid.rows, mix(key ^ (column * 2 + 1)))) + unit_float(jitter);
    const float y = float(shuffled(column, grid.columns, mix(key ^ (std::uint64_t(row) << 32)))) +
                    unit_float(jitter << 24);
    return {below_one((float(column) + x / float(grid.rows)) / float(grid.columns)),
            below_one((float(row) + y / float(grid.columns)) / float(grid.rows))};
}

// ---- Sobol' -----------------------------------------------------------------------------------

// Joe and Kuo's new-joe-kuo-6.21201: degree and inner coefficients of the primitive polynomial,
// first direction numbers. Dimension 0 is the van der Corput sequence.
struct Direction {
    int degree;
    std::uint32_t inner;
    std::array<std::uint32_t, 5> first;
};
constexpr std::array<Direction, sampler_dimensions - 1> directions{{{1, 0, {1}},
                                                                    {2, 1, {1, 3}},
                                                                    {3, 1, {1, 3, 1}},
                                                                    {3, 2, {1, 1, 1}},
                                                                    {4, 1, {1, 1, 3, 3}},
                                                                    {4, 4, {1, 3, 5, 13}},
                                                                    {5, 2, {1, 1, 5, 5, 17}},
                                                                    {5, 4, {1, 1, 5, 5, 5}},
                                                                    {5, 7, {1, 1, 7, 11, 19}}}};

// The generator matrix of a dimension, a byte of the index at a time.
struct SobolTable {
    std::uint32_t of_byte[sampler_dimensions][4][256];

    SobolTable() {
        for (int d = 0; d < sampler_dimensions; ++d) {
            std::array<std::uint32_t, 32> column{};
            for (int i = 0; i < 32; ++i) column[i] = 1u << (31 - i);
            if (d > 0) {
                const Direction& from = directions[d - 1];
                for (int i = 0; i < from.degree; ++i) column[i] = from.first[i] << (31 - i);
                for (int i = from.degree; i < 32; ++i) {
                    column[i] = column[i - from.degree] ^ (column[i - from.degree] >> from.degree);
                    for (int k = 1; k < from.degree; ++k)
                        if ((from.inner >> (from.degree - 1 - k)) & 1) column[i] ^= column[i - k];
                }
            }
            for (int byte = 0; byte < 4; ++byte)
                for (int value = 0; value < 256; ++value) {
                    std::uint32_t bits = 0;
                    for (int i = 0; i < 8; ++i)
                        if ((value >> i) & 1) bits ^= column[byte * 8 + i];
                    of_byte[d][byte][value] = bits;
                }
        }
    }
};

std::uint64_t spread_bits(std::uint32_t v) {
    std::uint64_t x = v;
    x = (x | x << 16) & 0x0000ffff0000ffffull;
    x = (x | x << 8) & 0x00ff00ff00ff00ffull;
    x = (x | x << 4) & 0x0f0f0f0f0f0f0f0full;
    x = (x | x << 2) & 0x3333333333333333ull;
    return (x | x << 1) & 0x5555555555555555ull;
}

// Where a pixel's samples start in its sequence, and which sequence it is: pixels are taken in
// blocks so large that an index stays below 2^31, each block with its own scrambling.
struct SobolStart {
    std::uint32_t index;
    std::uint64_t key;
};
SobolStart sobol_start(std::uint64_t seed, int x, int y, int spp) {
    const int sample_bits = std::bit_width(std::uint32_t(std::max(spp - 1, 0)));
    const int pixel_bits = std::clamp((31 - sample_bits) & ~1, 0, 24);
    const std::uint64_t curve = spread_bits(std::uint32_t(x)) | spread_bits(std::uint32_t(y)) << 1;
    const std::uint64_t block = pixel_bits == 0 ? curve : curve >> pixel_bits;
    SobolStart start{0, mix(mix(seed) + block)};
    if (pixel_bits > 0) {
        const std::uint32_t local = std::uint32_t(curve & ((1ull << pixel_bits) - 1));
        const std::uint32_t order =
            owen_scramble(local << (32 - pixel_bits), std::uint32_t(start.key >> 32));
        start.index = (order >> (32 - pixel_bits)) * std::uint32_t(spp);
    }
    return start;
}

const SobolTable sobol_table;  // made as the program starts: 0.1 ms

std::uint32_t sobol_point(int dimension, std::uint32_t n) {
    const auto& bytes = sobol_table.of_byte[dimension];
    return bytes[0][n & 255] ^ bytes[1][n >> 8 & 255] ^ bytes[2][n >> 16 & 255] ^ bytes[3][n >> 24];
}

std::uint64_t pixel_key(std::uint64_t seed, int x, int y) {
    return mix(mix(seed) ^ mix((std::uint64_t(std::uint32_t(y)) << 32 | std::uint32_t(x)) + 1));
}

Disk independent_pair(std::uint64_t key, std::uint32_t index, std::uint32_t dimension) {
    const std::uint64_t bits = mix(key + (std::uint64_t(index) + 1) * 0x9e3779b97f4a7c15ull +
                                   std::uint64_t(dimension) * 0xd1b54a32d192ed03ull);
    return {unit_float(bits), unit_float(bits << 24)};
}

}  // namespace

SampleSequence sample_sequence(Sampler sampler, std::uint64_t seed, int x, int y, int spp) {
    SampleSequence s;
    s.sampler = sampler;
    if (sampler == Sampler::sobol) {
        const SobolStart start = sobol_start(seed, x, y, spp);
        s.start = start.index;
        s.key = start.key;
        return s;
    }
    const Grid grid = grid_of(std::uint32_t(std::max(spp, 1)));
    s.columns = grid.columns;
    s.rows = grid.rows;
    s.key = pixel_key(seed, x, y);
    return s;
}

Disk SampleSequence::operator()(std::uint32_t index, std::uint32_t pair) const {
    if (pair < 32 && (given_pairs >> pair & 1)) return given[pair];
    const std::uint32_t dimension = 2 * pair;
    if (sampler == Sampler::independent) return independent_pair(key, index, dimension);
    if (sampler == Sampler::stratified)
        return stratified_pair({columns, rows}, index, mix(key + std::uint64_t(dimension) + 1));
    const std::uint32_t n = start + index;
    if (dimension + 1 >= std::uint32_t(sampler_dimensions)) {
        const std::uint64_t h = mix(key ^ dimension * 0xd1b54a32d192ed03ull);
        // A bit of the index is flipped or not by those above it: pieces of 2^k stay pieces of 2^k.
        const std::uint32_t shuffled_n =
            owen_scramble(n, std::uint32_t(h * 0x9e3779b97f4a7c15ull >> 32));
        return {unit_float(owen_scramble(reverse_bits(shuffled_n), std::uint32_t(h))),
                unit_float(owen_scramble(sobol_point(1, shuffled_n), std::uint32_t(h >> 32)))};
    }
    const std::uint64_t a = mix(key + std::uint64_t(dimension) + 1),
                        b = mix(key + std::uint64_t(dimension) + 2);
    return {unit_float(owen_scramble(sobol_point(int(dimension), n), std::uint32_t(a))),
            unit_float(owen_scramble(sobol_point(int(dimension) + 1, n), std::uint32_t(b)))};
}

void fill_samples(Sampler sampler, std::uint64_t seed, int x, int y, int spp, int first, int count,
                  int dimensions, float* out, size_t stride) {
    if (sampler == Sampler::sobol) {
        const SobolStart start = sobol_start(seed, x, y, spp);
        for (int d = 0; d < dimensions; ++d) {
            const auto scramble = std::uint32_t(mix(start.key + std::uint64_t(d) + 1));
            for (int i = 0; i < count; ++i) {
                const std::uint32_t n = start.index + std::uint32_t(first + i);
                const std::uint32_t point = sobol_point(d, n);
                out[size_t(d) * stride + size_t(i)] = unit_float(owen_scramble(point, scramble));
            }
        }
        return;
    }
    const std::uint64_t key = pixel_key(seed, x, y);
    const Grid grid = grid_of(std::uint32_t(std::max(spp, 1)));
    for (int i = 0; i < count; ++i) {
        const auto index = std::uint32_t(first + i);
        for (int d = 0; d < dimensions; d += 2) {
            Disk pair;
            if (sampler == Sampler::stratified) {
                pair = stratified_pair(grid, index, mix(key + std::uint64_t(d) + 1));
            } else {
                pair = independent_pair(key, index, std::uint32_t(d));
            }
            out[size_t(d) * stride + size_t(i)] = pair.u;
            if (d + 1 < dimensions) out[size_t(d + 1) * stride + size_t(i)] = pair.v;
        }
    }
}

Disk concentric_disk(float a, float b) {
    const float x = 2 * a - 1, y = 2 * b - 1;
    if (x == 0 && y == 0) return {0, 0};
    // The angle within an octant pair is pi/4 times a ratio in [-1, 1]: two short series do.
    const bool wide = std::fabs(x) > std::fabs(y);
    const float radius = wide ? x : y;
    const float w = 0.78539816f * (wide ? y / x : x / y), w2 = w * w;
    const float s = w * (1 - w2 / 6 * (1 - w2 / 20 * (1 - w2 / 42)));
    const float c = 1 - w2 / 2 * (1 - w2 / 12 * (1 - w2 / 30 * (1 - w2 / 56)));
    return wide ? Disk{radius * c, radius * s} : Disk{radius * s, radius * c};
}

Disk concentric_square(float u, float v) {
    const float r = std::min(std::hypot(u, v), 1.0f);
    if (r == 0) return {0.5f, 0.5f};
    const bool wide = std::fabs(u) > std::fabs(v);
    const float across = std::copysign(r, wide ? u : v);
    const float along = across * std::atan(wide ? v / u : u / v) / 0.78539816f;
    return wide ? Disk{(across + 1) / 2, (along + 1) / 2} : Disk{(along + 1) / 2, (across + 1) / 2};
}

}  // namespace weft
