// Hashes behind counter-based random numbers: pure functions of whole numbers.
#pragma once
#include <bit>
#include <cstdint>

namespace weft {

// 64 bits to 64 bits, one to one; every input bit reaches every output bit (the finalizer of
// Steele, Lea and Flood's SplitMix, 2014, with the increment taken in so that 0 does not stay 0).
constexpr std::uint64_t mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ x >> 27) * 0x94d049bb133111ebull;
    return x ^ x >> 31;
}

// The largest float below 1, where rounding reached 1.
constexpr float below_one(float x) {
    return x < 1.0f ? x : 0x1.fffffep-1f;
}

// The upper 24 bits as a float in [0, 1).
constexpr float unit_float(std::uint32_t bits) {
    return float(bits >> 8) * 0x1p-24f;
}
constexpr float unit_float(std::uint64_t bits) {
    return float(bits >> 40) * 0x1p-24f;
}

constexpr std::uint32_t reverse_bits(std::uint32_t x) {
    x = x << 16 | x >> 16;
    x = (x & 0x00ff00ffu) << 8 | (x >> 8 & 0x00ff00ffu);
    x = (x & 0x0f0f0f0fu) << 4 | (x >> 4 & 0x0f0f0f0fu);
    x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
    return (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
}

// Owen's nested uniform scrambling: each bit is flipped or not by a hash of the bits above it. In
// reversed order that is any one-to-one function whose bits depend on lower bits only
// (Laine and Karras 2011; these steps and constants are Vegdahl's of 2021).
constexpr std::uint32_t owen_scramble(std::uint32_t x, std::uint32_t key) {
    x = reverse_bits(x);
    x ^= x * 0x3d20adeau;
    x += key;
    x *= (key >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverse_bits(x);
}

// Where i of [0, n) stands in an order of [0, n) that `key` chooses: steps that are one to one on
// the next power of two, again until the result is below n.
constexpr std::uint32_t shuffled(std::uint32_t i, std::uint32_t n, std::uint64_t key) {
    if (n <= 1) return 0;
    const std::uint32_t mask = std::bit_ceil(n) - 1;
    const int half = std::bit_width(mask) / 2 + 1;
    do {
        for (std::uint64_t k = key, round = 0; round < 4; ++round, k >>= 16) {
            i = (i * (std::uint32_t(k >> 3) | 1u) + std::uint32_t(k)) & mask;
            i ^= i >> half;
            i = (i * 0x2c1b3c6du) & mask;
            i ^= i >> 1;
        }
    } while (i >= n);
    return i;
}

}  // namespace weft
