// FilmPoints: points on a film, and how far the k nearest of them lie from a place: a balanced k-d
// tree in an array.
// Cost: n log^2 n to build, about log n + k a question.  Threads: asks from any.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

namespace weft::shadows {

class FilmPoints {
  public:
    using Point = std::array<float, 2>;
    explicit FilmPoints(std::vector<Point> points) : points_(std::move(points)) {
        build(0, points_.size(), 0);
    }
    size_t size() const { return points_.size(); }

    // The distance to the k-th nearest point, one at the place itself included; k at most size().
    // `nearest` has room for k numbers.
    float distance(Point at, std::span<float> nearest) const {
        std::fill(nearest.begin(), nearest.end(), INFINITY);
        look(0, points_.size(), 0, at, nearest);
        return std::sqrt(nearest.front());
    }

  private:
    // The middle one of a range parts it: what is less along the axis stands before it.
    void build(size_t begin, size_t end, size_t axis) {
        if (end - begin < 2) return;
        const size_t middle = begin + (end - begin) / 2;
        const auto at = [&](size_t i) { return points_.begin() + std::ptrdiff_t(i); };
        std::nth_element(at(begin), at(middle), at(end), [axis](const Point& a, const Point& b) {
            return a[axis] < b[axis];
        });
        build(begin, middle, 1 - axis);
        build(middle + 1, end, 1 - axis);
    }
    // `nearest` is a heap of squares, the farthest first.
    void look(size_t begin, size_t end, size_t axis, Point at, std::span<float> nearest) const {
        if (begin >= end) return;
        const size_t middle = begin + (end - begin) / 2;
        const Point p = points_[middle];
        const float dx = p[0] - at[0], dy = p[1] - at[1], square = dx * dx + dy * dy;
        if (square < nearest.front()) {
            std::pop_heap(nearest.begin(), nearest.end());
            nearest.back() = square;
            std::push_heap(nearest.begin(), nearest.end());
        }
        const float beyond = at[axis] - p[axis];
        if (beyond < 0)
            look(begin, middle, 1 - axis, at, nearest);
        else
            look(middle + 1, end, 1 - axis, at, nearest);
        if (!(beyond * beyond < nearest.front())) return;
        if (beyond < 0)
            look(middle + 1, end, 1 - axis, at, nearest);
        else
            look(begin, middle, 1 - axis, at, nearest);
    }

    std::vector<Point> points_;
};

}  // namespace weft::shadows
