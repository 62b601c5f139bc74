// The random numbers of a path: pairs from its sample's sequence, one for each decision.
#pragma once
#include "samples/random.h"
#include "samples/samplers.h"

namespace weft::render {

// Pairs of numbers: lens, film, (time, choice of the first light), then for each vertex of the
// path.
enum Pair : std::uint32_t { lens_pair, film_pair, time_pair, vertex_pairs };
// choice: which lobe; at later vertices also which light.
enum VertexPair : std::uint32_t { light_pair, bounce_pair, choice_pair, pairs_a_vertex };
// So deep in a path good patterns no longer help: plain random numbers are cheaper.
inline constexpr int patterned_vertices = 4;
constexpr std::uint32_t pair_of(int depth, VertexPair pair) {
    return vertex_pairs + std::uint32_t(depth) * pairs_a_vertex + pair;
}
inline Disk numbers_of(const SampleSequence& sequence, std::uint32_t index, int depth,
                       VertexPair pair) {
    if (depth < patterned_vertices) return sequence(index, pair_of(depth, pair));
    const std::uint64_t bits =
        mix(sequence.key + index + (std::uint64_t(pair_of(depth, pair)) << 32));
    return {unit_float(bits), unit_float(bits << 24)};
}

// Of what a shadow ray decides by chance, from its path's key.
inline std::uint64_t shadow_key(std::uint64_t path) {
    return mix(path ^ 0x5368'6164'6f77ull);
}

}  // namespace weft::render
