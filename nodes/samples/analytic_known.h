// Small scenes whose pixels are known in closed form.
#pragma once
#include <array>

#include "samples/analytic_geometry.h"
#include "samples/analytic_scene.h"

namespace weft::analytic {

Scene step_scene(const AnalyticOptions& options);
Scene plane_scene(const AnalyticOptions& options);
Scene disc_scene(const AnalyticOptions& options);
Scene layers_scene(const AnalyticOptions& options);

using Color = std::array<double, 3>;
Color step_exact(const AnalyticOptions& options, int x, int y);
Color plane_exact(const AnalyticOptions& options, int x, int y);
Color disc_exact(const AnalyticOptions& options, int x, int y);
Color layers_exact(const AnalyticOptions& options, int x, int y);

// Share of the unit disk with u < h.
double disk_below(double h);
// Area common to two disks of radii a and b whose centres are d apart.
double common_area(double a, double b, double d);

}  // namespace weft::analytic
