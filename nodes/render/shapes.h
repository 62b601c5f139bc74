// Shapes: meshes made from a few numbers, around the origin.
// Triangles are counter-clockwise seen from outside; normals are unit; a texture is upright and not
// mirrored seen from outside (u to the right, v down), on a floor seen with -z away from the
// viewer.
#pragma once
#include <span>
#include <vector>

#include "render/scene.h"

namespace weft {

Mesh plane_mesh(int cells = 1);       // [-1, 1]^2 in x and z, facing +y
Mesh wall_mesh(int cells = 1);        // [-1, 1]^2 in x and y, facing +z
Mesh disc_mesh(int segments = 64);    // unit, in x and z, facing +y
Mesh cube_mesh();                     // [-1, 1]^3
Mesh sphere_mesh(int segments = 64);  // unit; half as many rings
// Turns a profile of (radius, height), from bottom to top, about +y. Edges sharper than
// `crease` radians stay sharp. Points at radius 0 close it.
Mesh lathe_mesh(std::span<const Vec2> profile, int segments = 64, float crease = 0.6f);
Mesh torus_mesh(float tube, int segments = 64);  // radius 1 about +y
// A tapering tube through points, `radii` one a point; open ends.
Mesh tube_mesh(std::span<const Vec3> points, std::span<const float> radii, int segments = 8);

// A smooth curve through the points of a profile (Catmull-Rom), `steps` pieces between two.
std::vector<Vec2> smooth_profile(std::span<const Vec2> points, int steps);

// Copies `part`, placed by `at`, into `mesh` (one motion key; their uv and normals are kept where
// both have them).
void append(Mesh& mesh, const Mesh& part, const Affine& at = {});

// Normals from the triangles, weighted by area, smooth across shared vertices, at every key.
void make_normals(Mesh& mesh);

}  // namespace weft
