#include "adaptive/point_tree.h"

#include <algorithm>
#include <numeric>

namespace weft::adaptive {

PointTree::PointTree(const std::vector<std::span<const float>>& axes) {
    const size_t dimensions = axes.size(), n = axes.empty() ? 0 : axes[0].size();
    order_.resize(n);
    std::iota(order_.begin(), order_.end(), 0u);
    at_.resize(dimensions);
    if (n == 0) return;
    struct Later {
        std::uint32_t begin, end, parent;
    };
    // Depth first, so that a first child follows its parent.
    std::vector<Later> later{{0, std::uint32_t(n), 0}};
    while (!later.empty()) {
        const Later now = later.back();
        later.pop_back();
        const auto self = std::uint32_t(nodes_.size());
        if (self > 0 && self != now.parent + 1) nodes_[now.parent].second = self;
        nodes_.push_back({now.begin, now.end, 0});
        const size_t bounds = bounds_.size();
        bounds_.resize(bounds + 2 * dimensions);
        size_t widest = 0;
        float width = -1;
        for (size_t d = 0; d < dimensions; ++d) {
            float lo = axes[d][order_[now.begin]], hi = lo;
            for (std::uint32_t i = now.begin + 1; i < now.end; ++i) {
                lo = std::min(lo, axes[d][order_[i]]);
                hi = std::max(hi, axes[d][order_[i]]);
            }
            bounds_[bounds + d] = lo;
            bounds_[bounds + dimensions + d] = hi;
            if (hi - lo > width) width = hi - lo, widest = d;
        }
        if (now.end - now.begin <= bucket) continue;
        const std::uint32_t middle = now.begin + (now.end - now.begin) / 2;
        const std::span<const float> along = axes[widest];
        std::nth_element(order_.begin() + now.begin, order_.begin() + middle,
                         order_.begin() + now.end, [&](std::uint32_t a, std::uint32_t b) {
                             return along[a] != along[b] ? along[a] < along[b] : a < b;
                         });
        later.push_back({middle, now.end, self});
        later.push_back({now.begin, middle, self});
    }
    // Which element of a half stands where is the library's affair; their order here is ours.
    for (const Node& node : nodes_)
        if (node.second == 0) std::sort(order_.begin() + node.begin, order_.begin() + node.end);
    for (size_t d = 0; d < dimensions; ++d) {
        at_[d].reserve(n);
        for (const std::uint32_t i : order_) at_[d].push_back(axes[d][i]);
    }
}

std::vector<float> PointTree::largest(std::span<const float> values) const {
    std::vector<float> all(nodes_.size());
    for (size_t i = nodes_.size(); i-- > 0;) {
        const Node& node = nodes_[i];
        all[i] = node.second > 0
                     ? std::max(all[i + 1], all[node.second])
                     : *std::max_element(values.begin() + node.begin, values.begin() + node.end);
    }
    return all;
}

float PointTree::distance2(const float* point, std::uint32_t node) const {
    const float *lo = &bounds_[2 * dimensions() * node], *hi = lo + dimensions();
    float sum = 0;
    for (size_t d = 0; d < dimensions(); ++d) {
        const float off = std::max({lo[d] - point[d], point[d] - hi[d], 0.0f});
        sum += off * off;
    }
    return sum;
}

void PointTree::nearest(const float* point, size_t count, std::vector<Near>& found) const {
    found.clear();
    if (nodes_.empty() || count == 0) return;
    std::array<Near, 64> later;  // nodes, by their distance
    size_t n = 0;
    later[n++] = {distance2(point, 0), 0};
    while (n > 0) {
        const Near box = later[--n];
        if (found.size() == count && box.distance2 > found.back().distance2) continue;
        const Node& node = nodes_[box.place];
        if (node.second > 0) {
            const Near first{distance2(point, box.place + 1), box.place + 1},
                second{distance2(point, node.second), node.second};
            const bool swap = second.distance2 < first.distance2;
            later[n++] = swap ? first : second;
            later[n++] = swap ? second : first;
            continue;
        }
        for (std::uint32_t i = node.begin; i < node.end; ++i) {
            float d2 = 0;
            for (size_t d = 0; d < dimensions(); ++d)
                d2 += (at_[d][i] - point[d]) * (at_[d][i] - point[d]);
            const Near here{d2, i};
            if (found.size() == count) {
                if (!(here < found.back())) continue;
                found.pop_back();
            }
            found.insert(std::upper_bound(found.begin(), found.end(), here), here);
        }
    }
}

}  // namespace weft::adaptive
