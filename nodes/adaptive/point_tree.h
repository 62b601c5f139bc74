// Points in a k-d tree: which lie near a place, in any number of dimensions.
// Source: Friedman, Bentley and Finkel 1977 (buckets; cuts across the widest side, at the median).
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "adaptive/adaptive_tree.h"

namespace weft::adaptive {

class PointTree {
  public:
    // `axes` x n. Equal points are told apart by their index, so that the tree is one only.
    explicit PointTree(const std::vector<std::span<const float>>& axes);

    size_t size() const { return order_.size(); }
    size_t dimensions() const { return at_.size(); }
    // In the tree's order, in which neighbours are mostly near each other.
    std::span<const float> at(size_t axis) const { return at_[axis]; }
    std::span<const std::uint32_t> order() const { return order_; }  // index of each point

    struct Near {
        float distance2;
        std::uint32_t place;  // in the tree's order
        bool operator<(const Near& other) const {
            return distance2 != other.distance2 ? distance2 < other.distance2 : place < other.place;
        }
    };
    // The `count` nearest, nearest first; all where there are fewer.
    void nearest(const float* point, size_t count, std::vector<Near>& found) const;

    // Of each node of the tree, the largest of its points' values (in the tree's order).
    std::vector<float> largest(std::span<const float> values) const;

    // take(begin, end) for runs of points, in the tree's order, of boxes for which
    // keep(lo, hi, node) holds (D numbers each) and so does it for every box around them.
    template <class Keep, class Take>
    void visit(Keep&& keep, Take&& take) const {
        if (nodes_.empty()) return;
        std::array<std::uint32_t, 64> later;
        size_t n = 0;
        later[n++] = 0;
        while (n > 0) {
            const std::uint32_t i = later[--n];
            const Node& node = nodes_[i];
            if (!keep(&bounds_[2 * dimensions() * i], &bounds_[2 * dimensions() * i + dimensions()],
                      i))
                continue;
            if (node.second == 0) {
                take(size_t(node.begin), size_t(node.end));
                continue;
            }
            later[n++] = node.second;
            later[n++] = i + 1;
        }
    }

  private:
    static constexpr size_t bucket = 12;
    struct Node {
        std::uint32_t begin, end;
        std::uint32_t second;  // child; the first follows its parent; 0: a bucket
    };
    float distance2(const float* point, std::uint32_t node) const;

    std::vector<Node> nodes_;
    std::vector<float> bounds_;  // of each node: lo, hi
    std::vector<std::vector<float>> at_;
    std::vector<std::uint32_t> order_;
};

}  // namespace weft::adaptive
