// Which boxes of a partition share a face, kept as boxes are cut: to look beyond a box for samples
// near its sides (Hachisuka et al. 2008).
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace weft::adaptive {

inline constexpr size_t most_axes = 8;

struct LeafBox {
    std::array<float, most_axes> lo, hi;  // px
};

// Boxes touch in one axis and overlap in all others. Sides are equal bits where boxes were cut.
bool share_a_face(const LeafBox& a, const LeafBox& b, size_t axes);

// First cells over x and y, of one cell of the further axes; row by row from number `first`.
struct CellSlab {
    std::vector<float> x, y;  // sides, ascending
    std::uint32_t first = 0;
    std::uint32_t cell(size_t i, size_t j) const {
        return first + std::uint32_t(j * (x.size() - 1) + i);
    }
};

class LeafNeighbours {
  public:
    LeafNeighbours() = default;
    // Slabs in order, the first of the further axes fastest; cells[d] of them along axis d >= 2.
    LeafNeighbours(std::span<const CellSlab> slabs, std::span<const size_t> cells);

    bool empty() const { return of_.empty(); }
    std::span<const std::uint32_t> of(size_t leaf) const { return of_[leaf]; }
    // `leaf`, by `boxes` as they are now, was cut, and `other`, the last of them, is its other
    // part.
    template <class Leaf>
    void cut(std::uint32_t leaf, std::uint32_t other, std::span<const Leaf> boxes, size_t axes) {
        of_.emplace_back();
        const std::vector<std::uint32_t> before = std::exchange(of_[leaf], {});
        for (const std::uint32_t near : before) {
            std::erase(of_[near], leaf);
            for (const std::uint32_t part : {leaf, other})
                if (share_a_face(boxes[near], boxes[part], axes)) join(near, part);
        }
        join(leaf, other);
    }

  private:
    void join(std::uint32_t a, std::uint32_t b) {
        of_[a].push_back(b);
        of_[b].push_back(a);
    }

    std::vector<std::vector<std::uint32_t>> of_;
};

}  // namespace weft::adaptive
