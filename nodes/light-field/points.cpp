#include "light-field/points.h"

#include <algorithm>
#include <cmath>

namespace weft::light_field {
namespace {

// Columns of a generator matrix from a primitive polynomial and its first directions.
struct Directions {
    std::array<std::uint32_t, 32> column{};
    constexpr Directions(int degree, std::uint32_t polynomial, std::array<std::uint32_t, 4> first) {
        if (degree == 0) {
            for (int i = 0; i < 32; ++i) column[size_t(i)] = 1u << (31 - i);
            return;
        }
        for (int i = 0; i < 32; ++i) {
            if (i < degree) {
                column[size_t(i)] = first[size_t(i)] << (31 - i);
                continue;
            }
            std::uint32_t value = column[size_t(i - degree)] ^ column[size_t(i - degree)] >> degree;
            for (int k = 1; k < degree; ++k)
                if (polynomial >> (degree - 1 - k) & 1) value ^= column[size_t(i - k)];
            column[size_t(i)] = value;
        }
    }
    std::uint32_t operator()(std::uint32_t i) const {
        std::uint32_t bits = 0;
        for (size_t k = 0; i; i >>= 1, ++k)
            if (i & 1) bits ^= column[k];
        return bits;
    }
};
// Degree, inner coefficients of the polynomial, first directions (Joe and Kuo 2008, new-joe-kuo-6).
constexpr Directions sobol[6] = {{0, 0, {}},           {1, 0, {1}},          {2, 1, {1, 3}},
                                 {3, 1, {1, 3, 1}}, {3, 2, {1, 1, 1}}, {4, 1, {1, 1, 3, 3}}};

// Owen's scrambling: each bit is flipped by a hash of those above it (Laine and Karras 2011; Burley 2020).
std::uint32_t scrambled(std::uint32_t bits, std::uint32_t seed) {
    std::uint32_t out = 0, above = 1;
    for (int bit = 31; bit >= 0; --bit) {
        const std::uint32_t here = bits >> bit & 1;
        out |= (here ^ (std::uint32_t(mix(std::uint64_t(above) << 32 | seed)) & 1)) << bit;
        above = above << 1 | here;
        if (bit < 8) {  // finer than any float in [0, 1): the rest at random
            out |= std::uint32_t(mix(std::uint64_t(above) << 32 | seed)) & 0xff;
            break;
        }
    }
    return out;
}

}  // namespace

LensPoint lens_point(std::uint64_t seed, std::uint32_t i, std::uint32_t n, const Lens& lens) {
    const float a = unit_float(scrambled(sobol[0](i), std::uint32_t(mix(seed))));
    const float b = unit_float(scrambled(sobol[1](i), std::uint32_t(mix(seed + 1))));
    const float shift = unit_float(std::uint32_t(mix(seed + 2)));
    const auto uv = on_lens(a, b, lens);
    return {uv[0], uv[1], std::min((float(i) + shift) / float(n), 0x1.fffffep-1f)};
}

std::array<std::uint32_t, 2> pixel_pattern(std::uint32_t i) { return {sobol[2](i), sobol[3](i)}; }

float light_number(std::uint64_t seed, std::uint32_t i, int dimension) {
    return unit_float(scrambled(sobol[4 + dimension](i), std::uint32_t(mix(seed + 3 + std::uint64_t(dimension)))));
}

std::uint64_t pixel_scramble(std::uint64_t seed, int x, int y) {
    return mix(mix(seed ^ 0x5bf0'3635'd1c2'a96eull) ^ (std::uint64_t(std::uint32_t(y)) << 32 | std::uint32_t(x)));
}

}  // namespace weft::light_field
