// Chooses the film of a light view: how many pixels a unit of it has, where it is in focus, which
// part of it is looked at.
#pragma once
#include <string>

#include "runtime/context.h"
#include "shadows/light_view.h"

namespace weft::shadows {

struct FitOptions {
    std::string light;  // its name, or its place in meta.lights; "": the first that has an area,
                        // else the first
    double pixels = 0;  // of film a unit of w at depth 1; 0: as dense as the camera's
    double focus = 0;   // world units; 0: between the nearest and the farthest receiver
};

// A view of a light of samples.meta that holds all receivers: the samples' first hits in front of
// the light, seen from any point of it. Throws Error where there is no such light, no camera in the
// meta, nothing in front of the light.
LightView fit_light_view(const Samples& samples, const FitOptions& options, Context& ctx);

// What a light of samples.meta sends out, as render-samples chooses lights by: luminance times area,
// or solid angle. Of a spot, whose cones the meta does not tell, that of a point. Throws Error where
// there is no such light.
double light_power(const Samples& samples, const std::string& light);

}  // namespace weft::shadows
