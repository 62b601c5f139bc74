// A mesh that shines, as a light view looks out of it: the plane through its middle, a rectangle on
// it, its triangles in light space (light_view.h).
//   plane      of a flat mesh its own; of another one across its mean normal or, where it shines to
//              all sides, facing `towards`
//   rectangle  the smallest along one of its edges that holds all of it, seen along the plane's
//              normal
#pragma once
#include <array>
#include <string>
#include <vector>

#include "shadows/light_view.h"

namespace weft::shadows {

struct WorldMesh {
    using Corners = std::array<Point3, 3>;
    std::vector<Corners> open, close;  // at the shutter's opening; at its close, empty: the same
    std::vector<double> chances;       // what part of the light each sends out; empty: by area
    bool two_sided = false;
};

// Sets what of a view says where its light is and what it looks like: light_to_world, ax, ay, radius,
// triangles, flat, two_sided. Throws Error, naming `what`, where no triangle has an area or the mesh
// changes shape.
void place_mesh(const WorldMesh& mesh, Point3 towards, const std::string& what, LightView& view);

}  // namespace weft::shadows
