#include <cmath>

#include "light-field/kernels.h"

namespace weft::light_field {

void lay_grid(const Hierarchy& h, int x0, int y0, int x1, int y1, float reach, float radius,
              Projection& out) {
    out.hierarchy = &h;
    out.reach = reach;
    out.cell_width = 0.5f * radius;
    out.cell_height = radius;
    // A little farther, so that rounding of what lies at the very reach loses nothing.
    const float far = reach * 1.0001f + 1e-3f + 1e-6f * float(std::max(h.width, h.height));
    out.column0 = int(std::floor((float(x0) - far) / out.cell_width));
    out.row0 = int(std::floor((float(y0) - far) / out.cell_height));
    out.columns = int(std::floor((float(x1) + far) / out.cell_width)) + 1 - out.column0;
    out.rows = int(std::floor((float(y1) + far) / out.cell_height)) + 1 - out.row0;
}

void collect(const Hierarchy& h, int x0, int y0, int x1, int y1, float reach, Block& block) {
    block.hierarchy = &h;
    block.x0 = x0;
    block.y0 = y0;
    block.x1 = x1;
    block.y1 = y1;
    block.reach = reach;
    block.group.clear();
    // The grid that samples are sorted into may be two cells wider on each side (project_kernel.cpp).
    const float grown = reach + 2 * h.radius;
    h.collect(float(x0) - grown, float(y0) - grown, float(x1) + grown, float(y1) + grown, block.group);

    constexpr size_t spare = 16;  // vectors read past the end find bounds that are nowhere
    const size_t n = block.groups = block.group.size();
    const auto take = [&](std::span<const float> from, std::vector<float>& to, float filling) {
        to.assign(n + spare, filling);
        for (size_t i = 0; i < n; ++i) to[i] = from[block.group[i]];
    };
    const Hierarchy::Groups& g = h.groups;
    take(g.slope, block.slope, 0);
    take(g.velocity_x, block.velocity_x, 0);
    take(g.velocity_y, block.velocity_y, 0);
    take(g.x_low, block.x_low, 2e30f);
    take(g.x_high, block.x_high, -2e30f);
    take(g.y_low, block.y_low, 2e30f);
    take(g.y_high, block.y_high, -2e30f);
    block.seen.resize(n + spare);

    // Ranges of slope and velocity, and their means.
    float low[3] = {1e30f, 1e30f, 1e30f}, high[3] = {-1e30f, -1e30f, -1e30f};
    double mean[3] = {};
    size_t bounded = 0;
    for (size_t k = 0; k < n; ++k) {
        const std::uint32_t i = block.group[k];
        if (g.slope_spread[i] > 1e29f) continue;
        const float middle[3] = {g.slope[i], g.velocity_x[i], g.velocity_y[i]};
        const float half[3] = {g.slope_spread[i], g.velocity_x_spread[i], g.velocity_y_spread[i]};
        for (int part = 0; part < 3; ++part) {
            low[part] = std::min(low[part], middle[part] - half[part]);
            high[part] = std::max(high[part], middle[part] + half[part]);
            mean[part] += double(middle[part]);
        }
        ++bounded;
    }
    // Steps coarser than this could not tell surfaces from one another; what is out of range then is marked.
    const float most_range[3] = {254 * 0.15f, 254 * 0.3f, 254 * 0.3f};
    for (int part = 0; part < 3; ++part) {
        if (high[part] - low[part] <= most_range[part]) continue;
        low[part] = bounded ? float(mean[part] / double(bounded)) - 0.5f * most_range[part] : 0.0f;
        high[part] = low[part] + most_range[part];
    }
    // Half a step to spare at each end for rounding.
    const auto step = [&](int part) { return high[part] > low[part] ? (high[part] - low[part]) / 254.0f : 0.0f; };
    block.slope_step = std::max(step(0), 1e-3f);
    block.velocity_step = std::max({step(1), step(2), 1e-3f});
    block.slope_low = low[0] - 0.5f * block.slope_step;
    block.velocity_x_low = low[1] - 0.5f * block.velocity_step;
    block.velocity_y_low = low[2] - 0.5f * block.velocity_step;
    block.group.resize(n + spare, 0);
}

}  // namespace weft::light_field
