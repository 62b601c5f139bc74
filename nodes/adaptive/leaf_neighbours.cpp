#include "adaptive/leaf_neighbours.h"

#include <algorithm>

namespace weft::adaptive {
namespace {

// work(c) for the cells between `sides` that overlap [from, to].
template <class Work>
void each_over(const std::vector<float>& sides, float from, float to, const Work& work) {
    const auto above = std::upper_bound(sides.begin(), sides.end(), from);
    for (auto c = size_t(above - sides.begin()) - 1; c + 1 < sides.size() && sides[c] < to; ++c)
        work(c);
}

}  // namespace

bool share_a_face(const LeafBox& a, const LeafBox& b, size_t axes) {
    size_t touching = 0;
    for (size_t d = 0; d < axes; ++d) {
        const float from = std::max(a.lo[d], b.lo[d]), to = std::min(a.hi[d], b.hi[d]);
        if (from > to) return false;
        touching += from == to;
    }
    return touching == 1;
}

LeafNeighbours::LeafNeighbours(std::span<const CellSlab> slabs, std::span<const size_t> cells) {
    const auto each_cell = [](const CellSlab& slab, const auto& work) {
        for (size_t j = 0; j + 1 < slab.y.size(); ++j)
            for (size_t i = 0; i + 1 < slab.x.size(); ++i) work(i, j);
    };
    const CellSlab& last = slabs.back();
    of_.resize(last.cell(0, last.y.size() - 1));
    for (const CellSlab& slab : slabs)
        each_cell(slab, [&](size_t i, size_t j) {
            if (i + 2 < slab.x.size()) join(slab.cell(i, j), slab.cell(i + 1, j));
            if (j + 2 < slab.y.size()) join(slab.cell(i, j), slab.cell(i, j + 1));
        });
    size_t stride = 1;
    for (size_t d = 2; d < cells.size(); stride *= cells[d++])
        for (size_t s = 0; s < slabs.size(); ++s) {
            if (s / stride % cells[d] + 1 == cells[d]) continue;
            const CellSlab &here = slabs[s], &next = slabs[s + stride];
            each_cell(here, [&](size_t i, size_t j) {
                each_over(next.y, here.y[j], here.y[j + 1], [&](size_t q) {
                    each_over(next.x, here.x[i], here.x[i + 1],
                              [&](size_t p) { join(here.cell(i, j), next.cell(p, q)); });
                });
            });
        }
}

}  // namespace weft::adaptive
