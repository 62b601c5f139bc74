// Analytic scenes: built in, made of textured patches and spheres with closed-form intersections,
// seen through a thin lens over a shutter. They need no file and no renderer, and any number of
// samples can be had of them, so they are the default input of every graph and the tests' truth.
//
//   garden   flowers, leaves, butterflies, grass and lights at dusk, in deep layers; sky at z =
//   +inf step     a bright half-plane moving across a dark one, in focus           exact plane    a
//   smooth texture in focus, nothing moves                        exact disc     a small light out
//   of focus against black                       exact layers   a bright half-plane out of focus in
//   front of a texture in focus exact
//
// Everything moves on straight lines at constant speed (a patch's corners each on its own),
// radiance is constant along a point's trajectory: reprojection by `coc` and `motion` is exact up
// to rounding. World and camera coordinates are the same: x right, y down, z forward, lens centre
// at the origin.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "image/image.h"
#include "runtime/context.h"
#include "samples/samplers.h"
#include "samples/samples.h"

namespace weft {

struct AnalyticOptions {
    int width = 640, height = 360;
    int spp = 1;
    std::uint64_t seed = 1;
    Sampler sampler = Sampler::sobol;
    float aperture = 1;  // times the scene's own lens radius; 0: a pinhole
    float shutter = 1;   // times the scene's own motion about the middle of the shutter; 0: still
    // Only rows [first_row, end_row) of the picture, both multiples of analytic_band or the height; 0, 0: all.
    int first_row = 0, end_row = 0;
    int rows() const { return (end_row > 0 ? end_row : height) - first_row; }
};

constexpr int analytic_band = 16;  // rows

std::vector<std::string> analytic_scene_names();

// Samples of a scene: xy, uv, t, z, motion, rgb, alpha, and the features position, normal, albedo
// and id (0: background). Throws Error naming the scenes there are if `scene` is none of them.
Samples analytic_samples(std::string_view scene, const AnalyticOptions& options, Context& ctx);

// The mean of `spp` samples a pixel (box filter over pixel, lens and shutter), R G B. Samples are
// not kept; options.spp is not looked at. The seed is taken so that no sample of analytic_samples
// comes back.
Image analytic_reference(std::string_view scene, const AnalyticOptions& options, int spp,
                         Context& ctx);

// What the reference of pixel (x, y) converges to, where it is known: closed form at a point (disc,
// layers: averaged over the pixel by quadrature to 1e-4 of the range) or over the pixel (step,
// plane).
std::optional<std::array<double, 3>> analytic_exact(std::string_view scene,
                                                    const AnalyticOptions& options, int x, int y);

}  // namespace weft
