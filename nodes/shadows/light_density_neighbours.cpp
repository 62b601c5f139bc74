// light-density-neighbours: how dense the camera's samples are on a light's film, by how far their
// nearest neighbours are there: no normals needed, and several surfaces at one place of the film
// count together. A ray of the light goes through its receiver's place on the film whatever stops it,
// so the receivers are where light samples are.
// Source: density of the k nearest (Loftsgaarden and Quesenberry 1965).
#include <algorithm>
#include <array>
#include <numbers>

#include "adaptive/point_tree.h"
#include "runtime/node.h"
#include "shadows/camera_samples.h"

namespace weft {
namespace {
using namespace shadows;

struct LightDensityNeighbours {
    int neighbours = 8;
    float most = 16;

    static void declare(Ports<LightDensityNeighbours>& node) {
        node.about(
                "how large the camera's pixels are on the light's film, by how near the receivers "
                "lie to each other there")
            .in<Samples>("samples", "xy, z (uv, t, motion)")
            .in<LightView>("light-view", "of the same samples")
            .out<Samples>("samples",
                          "the same and light_density: light pixels a camera pixel; 1 where nothing was "
                          "hit")
            .param("neighbours", &LightDensityNeighbours::neighbours,
                   {.min = 1, .max = 256, .about = "that the distance is measured to"})
            .param("most", &LightDensityNeighbours::most,
                   {.min = 1,
                    .max = 1e3,
                    .about = "most that a camera's pixel is as wide as one of the light, or that "
                             "one as it"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        const double n = double(s.records);
        return {{{"samples", {s.width, s.height, 0, s.records, s.bytes + 4 * n}}},
                8 * n,
                2000 * n};
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const LightView& view = in.get<LightView>("light-view");
        samples.require("light-density-neighbours", {"xy", "z"});
        const CameraSamples from(samples);
        // Where a sample's receiver lies at half time, seen from the middle of the light.
        const auto on_film = [&](size_t i, std::array<float, 2>& at) {
            if (!from.hit(i)) return false;
            const auto ends = from.ends(i);
            const Point3 p = view.from_camera(ends[0], ends[1], 0.5);
            if (!(p.z > view.nearest)) return false;
            const auto q = view.project(p, 0, 0);
            at = {float(q[0]), float(q[1])};
            return true;
        };
        std::vector<float> x, y;
        std::array<float, 2> at;
        for (size_t i = 0; i < samples.size(); ++i)
            if (on_film(i, at)) x.push_back(at[0]), y.push_back(at[1]);
        const adaptive::PointTree points({x, y});

        std::vector<float> density(samples.size(), 1);
        // The sample itself is the nearest.
        const size_t near = std::min(size_t(neighbours) + 1, points.size());
        const double spp = samples.mean_spp(), high = double(most) * double(most), low = 1 / high;
        ctx.parallel(samples.size(), 4096, [&](size_t begin, size_t end) {
            std::vector<adaptive::PointTree::Near> nearest;
            std::array<float, 2> place;
            for (size_t i = begin; i < end; ++i) {
                if (near > 1 && on_film(i, place)) {
                    points.nearest(place.data(), near, nearest);
                    const double r2 = double(nearest.back().distance2);
                    density[i] = float(
                        std::clamp(spp * std::numbers::pi * r2 / double(near - 1), low, high));
                }
            }
        });
        Samples with = samples;
        with.add("light_density", 1, std::move(density));
        out.set("samples", std::move(with));
    }
};

WEFT_NODE(LightDensityNeighbours, "light-density-neighbours", 1)

}  // namespace
}  // namespace weft
