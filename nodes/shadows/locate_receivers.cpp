// locate-receivers: where on a light's film the shadow of each location is to be looked up: the
// receiver's place at the location's time, seen from one point of the light. Source: Lehtinen et
// al. 2011, Sec. 4.  Departure: the light's points are two further dimensions of the locations' own
// set (light-field/points.h), common to a slice as (u, v, t) is, so that light samples are carried
// there once for all of its locations.
#include <algorithm>
#include <bit>
#include <cmath>

#include "light-field/points.h"
#include "light-field/streams.h"
#include "runtime/node.h"
#include "shadows/light_view.h"
#include "shadows/streams.h"

namespace weft {
namespace {

struct LocateReceivers {
    std::uint64_t seed = 1;

    static void declare(Ports<LocateReceivers>& node) {
        node.about(
                "where on the light's film, from which of its points and at what time the light of "
                "each location is asked for")
            .in<Locations>("locations", "of the camera")
            .in<SeenSamples>("seen", "the sample that each sees")
            .in<Hierarchy>("hierarchy", "of the camera's samples")
            .in<Samples>("samples",
                         "the same; geometric_normal keeps curved surfaces from shadowing "
                         "themselves, light_density scales the search")
            .in<LightView>("light-view", "of the same samples")
            .out<Locations>("locations", "on the light's film, at a point (u, v) of the light")
            .out<ShadowQueries>("queries", "the receivers' depths there")
            .param("seed", &LocateReceivers::seed, {.about = "of the light's points"});
    }
    void batch(const Inputs& in, Outputs& out) const {
        const Locations& from = in.get<Locations>("locations");
        const SeenSamples& seen = in.get<SeenSamples>("seen");
        const Hierarchy& h = in.get<Hierarchy>("hierarchy");
        const Samples& samples = in.get<Samples>("samples");
        const LightView& view = in.get<LightView>("light-view");
        Locations& at = out.get<Locations>("locations");
        ShadowQueries& ask = out.get<ShadowQueries>("queries");
        const auto normals = samples.values("geometric_normal"),
                   density = samples.values("light_density");
        const size_t n = from.size();
        if (h.size() != samples.size())
            throw Error(
                "'samples' are not those of 'hierarchy': link the ones that build-hierarchy got, "
                "or the ones they were made of");
        start(from, view, n, at);
        ask.inverse_depth.assign(n, 0);
        ask.slope_x.assign(n, 0);
        ask.slope_y.assign(n, 0);
        ask.sample.assign(n, SeenSamples::none);
        if (!density.empty())
            at.ratio.assign(n, 1);
        else
            at.ratio.clear();
        float x0 = 1e30f, y0 = 1e30f, x1 = -1e30f, y1 = -1e30f;
        for (size_t l = 0; l < n; ++l) {
            const std::uint32_t s = seen.sample[l];
            if (s == SeenSamples::none || h.W[s] >= 0x1p+39f)
                continue;  // nothing there, or the background
            const std::uint32_t i = h.order[s];
            ask.sample[l] = i;
            const double t = double(from.t_of(l));
            const Point3 middle{double(h.X[s]), double(h.Y[s]), double(h.W[s])};
            Point3 half;
            if (h.moving) half = Point3{double(h.VX[s]), double(h.VY[s]), double(h.VW[s])} * 0.5;
            const Point3 p = view.from_camera(middle - half, middle + half, t);
            if (!(p.z > 0)) continue;
            if (!at.shared) {
                const auto on_light = view.point(number(from, l, 0), number(from, l, 1), p);
                at.u[l] = float(on_light[0]), at.v[l] = float(on_light[1]);
            }
            const auto q = view.project(p, double(at.u_of(l)), double(at.v_of(l)));
            if (!(q[0] >= 0 && q[0] < view.width && q[1] >= 0 && q[1] < view.height)) continue;
            at.x[l] = float(q[0]), at.y[l] = float(q[1]);
            x0 = std::min(x0, at.x[l]), x1 = std::max(x1, at.x[l]);
            y0 = std::min(y0, at.y[l]), y1 = std::max(y1, at.y[l]);
            ask.inverse_depth[l] = float(1 / p.z);
            if (!normals.empty()) {
                const Point3 world{double(normals[3 * i]), double(normals[3 * i + 1]),
                                   double(normals[3 * i + 2])};
                const auto slope =
                    view.inverse_depth_gradient(p, view.world_to_light[0].vector(world));
                ask.slope_x[l] = float(slope[0]), ask.slope_y[l] = float(slope[1]);
            }
            if (!density.empty()) at.ratio[l] = std::sqrt(density[i]);
        }
        // What is not asked lies where the others do, and costs next to nothing.
        if (x1 < x0) x0 = y0 = x1 = y1 = 0;
        for (size_t l = 0; l < n; ++l)
            if (ask.inverse_depth[l] == 0) at.x[l] = x0, at.y[l] = y0;
        at.x0 = int(std::floor(x0)), at.y0 = int(std::floor(y0));
        at.x1 = int(std::floor(x1)) + 1, at.y1 = int(std::floor(y1)) + 1;
    }

  private:
    void start(const Locations& from, const LightView& view, size_t n, Locations& at) const {
        at.shared = from.shared && view.same_points();
        at.slice = from.slice;
        at.x.resize(n);
        at.y.resize(n);
        const size_t sets = at.shared ? 1 : n;
        at.u.assign(sets, 0);
        at.v.assign(sets, 0);
        at.t.resize(sets);
        for (size_t l = 0; l < sets && n > 0; ++l) at.t[l] = from.t_of(l);
        if (!at.shared || n == 0) return;
        const auto on_light = view.point(number(from, 0, 0), number(from, 0, 1), {});
        at.u[0] = float(on_light[0]), at.v[0] = float(on_light[1]);
    }
    // A location's number for the light's point, in one of two dimensions.
    double number(const Locations& from, size_t l, int dimension) const {
        if (from.shared)
            return double(light_field::light_number(seed, std::uint32_t(from.slice), dimension));
        const auto bits = [](float a, float b) {
            return std::uint64_t(std::bit_cast<std::uint32_t>(a)) << 32 |
                   std::bit_cast<std::uint32_t>(b);
        };
        const std::uint64_t key =
            mix(mix(seed + std::uint64_t(dimension)) ^ bits(from.x[l], from.y[l]));
        return double(unit_float(mix(key ^ bits(from.u_of(l), from.t_of(l)))));
    }
};

WEFT_NODE(LocateReceivers, "locate-receivers", 1)

}  // namespace
}  // namespace weft
