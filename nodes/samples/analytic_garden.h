// The scene 'garden'.
#pragma once
#include "samples/analytic_geometry.h"
#include "samples/analytic_scene.h"

namespace weft::analytic {
Scene garden_scene(const AnalyticOptions& options);
}  // namespace weft::analytic
