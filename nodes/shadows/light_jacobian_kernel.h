// How the camera's pixels lie on a light's film: the change of q a pixel, along the receiver's
// surface.
#pragma once
#include <array>

#include "shadows/light_view.h"

namespace weft::shadows {

// dq/dx, dq/dy: [row][column].
using Jacobian = std::array<std::array<double, 2>, 2>;

// At the receiver of a camera sample on a plane.
//   pixel_to_light   (x z, y z, z) of the camera to light space, at the sample's time
//   pixel            the receiver, (x z, y z, z)
//   normal           of the plane, light space
// Singular values are kept within 1 / `most` and `most` times those of a surface that faces both
// ways: pixels per pixel by distance alone. Edge-on to the camera: that of such a surface. Source:
// Lehtinen et al. 2011, App. B, by way of the tangent plane.
Jacobian light_jacobian(const LightView& view, const Map3& pixel_to_light, Point3 pixel,
                        Point3 normal, double most);

// |det J|: light pixels a camera pixel.
double area_of(const Jacobian& j);
// J J^T = (xx, xy, yy): a disc of radius r in the camera's picture becomes the ellipse d^T (J
// J^T)^-1 d < r^2.
std::array<double, 3> metric_of(const Jacobian& j);

}  // namespace weft::shadows
