#include "adaptive/near_samples.h"

#include <algorithm>

#include "adaptive/with_axes.h"

namespace weft::adaptive {
namespace {

constexpr size_t vector_width = 16;
constexpr float nowhere = 1e30f;  // squared distance

}  // namespace

void NearSamples::clear() {
    for (auto* values : {&x, &y, &off2, &xx, &xy, &yy, &bx, &by, &rest}) values->clear();
    place.clear();
    size = 0;
}

void NearSamples::pad() {
    size = x.size();
    const size_t padded = (size + vector_width - 1) / vector_width * vector_width;
    for (auto* values : {&x, &y, &xx, &xy, &yy, &bx, &by}) values->resize(padded, 0.0f);
    off2.resize(padded, nowhere);
    rest.resize(padded, nowhere);
}

bool gather(const Metrics& metrics, const Block& block, const float* other, float reach,
            NearSamples& near) {
    const PointTree& tree = *metrics.tree;
    const size_t axes = tree.dimensions(), numbers = metrics.numbers();
    const float reach2 = reach * reach;
    near.clear();
    const auto outside = [](float lo, float hi, float at_lo, float at_hi) {
        return std::max({lo - at_hi, at_lo - hi, 0.0f});
    };
    const auto keep = [&](const float* lo, const float* hi, size_t) {
        const float dx = outside(lo[0], hi[0], block.x0, block.x1),
                    dy = outside(lo[1], hi[1], block.y0, block.y1);
        float d2 = dx * dx + dy * dy;
        for (size_t d = 2; d < axes; ++d) {
            const float off = outside(lo[d], hi[d], other[d], other[d]);
            d2 += off * off;
        }
        return d2 <= reach2;
    };
    tree.visit(keep, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const float x = tree.at(0)[i], y = tree.at(1)[i];
            std::array<float, most_axes> off{};
            float off2 = 0;
            for (size_t d = 2; d < axes; ++d) {
                off[d] = other[d] - tree.at(d)[i];
                off2 += off[d] * off[d];
            }
            const float dx = outside(x, x, block.x0, block.x1),
                        dy = outside(y, y, block.y0, block.y1);
            if (!(dx * dx + dy * dy + off2 <= reach2)) continue;
            const float* m = &metrics.upper[numbers * i];
            float bx = 0, by = 0, rest = 0;
            for (size_t a = 2; a < axes; ++a) {
                bx += m[upper_index(0, a, axes)] * off[a];
                by += m[upper_index(1, a, axes)] * off[a];
                float row = 0.5f * m[upper_index(a, a, axes)] * off[a];
                for (size_t b = a + 1; b < axes; ++b) row += m[upper_index(a, b, axes)] * off[b];
                rest += 2 * row * off[a];
            }
            near.x.push_back(x);
            near.y.push_back(y);
            near.off2.push_back(off2);
            near.xx.push_back(m[0]);
            near.xy.push_back(m[1]);
            near.yy.push_back(m[axes]);
            near.bx.push_back(bx);
            near.by.push_back(by);
            near.rest.push_back(rest);
            near.place.push_back(std::uint32_t(i));
        }
    });
    near.pad();
    return near.size == tree.size();
}

void gather(const Metrics& metrics, const float* lo, const float* hi, NearbySamples& nearby) {
    const Supports& supports = metrics.supports;
    const PointTree& tree = *metrics.tree;
    nearby.axes = tree.dimensions();
    nearby.support2.clear(), nearby.place.clear();
    for (size_t d = 0; d < nearby.axes; ++d) nearby.at[d].clear();
    const auto append = [&](std::span<const float> from, size_t begin, size_t end,
                            std::vector<float>& to) {
        to.insert(to.end(), from.begin() + std::ptrdiff_t(begin),
                  from.begin() + std::ptrdiff_t(end));
    };
    with_axes(nearby.axes, [&](auto axes) {
        tree.visit(
            [&](const float* from, const float* to, size_t node) {
                float d2 = 0;
                for (int d = 0; d < axes.value; ++d) {
                    const float off = std::max(std::max(from[d] - hi[d], lo[d] - to[d]), 0.0f);
                    d2 += off * off;
                }
                // Rounding must not leave out what the kernel would take in.
                return d2 <= supports.of_node[node] * 1.00001f;
            },
            [&](size_t begin, size_t end) {
                for (size_t d = 0; d < nearby.axes; ++d)
                    append(tree.at(d), begin, end, nearby.at[d]);
                append(supports.squared, begin, end, nearby.support2);
                for (size_t i = begin; i < end; ++i) nearby.place.push_back(std::uint32_t(i));
            });
    });
    nearby.size = nearby.place.size();
    for (size_t d = 0; d < nearby.axes; ++d) nearby.at[d].resize(nearby.size + vector_width);
    nearby.support2.resize(nearby.size + vector_width, -1.0f);
}

}  // namespace weft::adaptive
