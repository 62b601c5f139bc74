#include "light-field/hierarchy.h"

#include <algorithm>
#include <cmath>

#include "graph/error.h"

namespace weft {

size_t Hierarchy::bytes() const {
    size_t floats = X.size() + Y.size() + W.size() + paths.size() +
                    rgba.size() + plane_x.size() + plane_y.size() + end.size() +
                    bulge.size() + order.size();
    floats += radii.size() + 10 * groups.size();
    for (const Rects& level : levels) floats += 4 * level.size();
    return 4 * floats + groups.moves.size();
}

void Hierarchy::require_colors() const {
    if (rgba.size() == 0 && size() > 0)
        throw Error("'hierarchy' is of light samples, which have no colour to filter; depth-vote makes shadows of them");
}

float Hierarchy::radius_at(float x, float y) const {
    if (radii.empty()) return radius;
    const auto pixel = [](float at, int count) {
        return size_t(std::clamp(std::floor(at), 0.0f, float(count - 1)));
    };
    return radii[pixel(y, height) * size_t(width) + pixel(x, width)];
}

float Hierarchy::largest_radius(int x0, int y0, int x1, int y1) const {
    if (radii.empty()) return radius;
    x0 = std::clamp(x0, 0, width - 1), x1 = std::clamp(x1, x0 + 1, width);
    y0 = std::clamp(y0, 0, height - 1), y1 = std::clamp(y1, y0 + 1, height);
    float largest = 0;
    for (int y = y0; y < y1; ++y) {
        const float* row = &radii[size_t(y) * size_t(width)];
        largest = std::max(largest, *std::max_element(row + x0, row + x1));
    }
    return largest;
}

namespace {

struct Search {
    const Hierarchy& h;
    float x0, y0, x1, y1;
    std::vector<std::uint32_t>& found;

    void visit(size_t level, size_t begin, size_t end) const {
        const Hierarchy::Rects& rects = h.levels[level];
        end = std::min(end, rects.size());
        for (size_t i = begin; i < end; ++i) {
            if (rects.x_low[i] > x1 || rects.x_high[i] < x0 || rects.y_low[i] > y1 ||
                rects.y_high[i] < y0)
                continue;
            if (level == 0)
                found.push_back(std::uint32_t(i));
            else
                visit(level - 1, i * Hierarchy::fan_out, (i + 1) * Hierarchy::fan_out);
        }
    }
};

}  // namespace

void Hierarchy::collect(float x0, float y0, float x1, float y1,
                        std::vector<std::uint32_t>& found) const {
    if (levels.empty()) return;
    Search{*this, x0, y0, x1, y1, found}.visit(levels.size() - 1, 0, levels.back().size());
}

}  // namespace weft
