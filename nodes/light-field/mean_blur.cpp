#include "light-field/mean_blur.h"

#include <algorithm>
#include <cmath>

namespace weft::light_field {

MeanBlur mean_blur(const Hierarchy& h, int x0, int y0, int x1, int y1,
                   std::vector<std::uint32_t>& groups) {
    const float grown = 2 * h.largest_radius(x0, y0, x1, y1);
    groups.clear();
    h.collect(float(x0) - grown, float(y0) - grown, float(x1) + grown, float(y1) + grown, groups);
    const Hierarchy::Groups& g = h.groups;
    double slope = 0, velocity = 0, n = 0;
    for (const std::uint32_t i : groups) {
        if (g.slope_spread[i] > 1e29f) continue;
        const double s = double(g.slope[i]), x = double(g.velocity_x[i]), y = double(g.velocity_y[i]);
        slope += s * s;
        velocity += x * x + y * y;
        ++n;
    }
    n = std::max(n, 1.0);
    return {float(2 * std::sqrt(slope / n)) * std::max(1.0f, h.lens.aspect), float(std::sqrt(velocity / n))};
}

}  // namespace weft::light_field
