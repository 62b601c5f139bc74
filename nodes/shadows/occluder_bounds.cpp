// occluder-bounds: between which depths a light's occluders lie, as each pixel's own shadow rays
// say. A ray from light point Y to receiver point X, at distance d1 from the light's plane, passes
// an occluder at d2 where X + s Y is the same, s = d1 / d2 - 1: nearest and farthest occluder bound
// the slopes s of the visibility, and with them the wedge that holds its spectrum.
// Source: Egan et al. 2011, Sec. 3; Mehta et al. 2012, Sec. 5 (bounds from a few rays, spread to
// pixels around that met nothing).
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "image/image.h"
#include "image/image_cost.h"
#include "runtime/node.h"
#include "shadows/pixel_rays.h"

namespace weft {
namespace {
using namespace shadows;

struct OccluderBounds {
    int window = 10;

    static void declare(Ports<OccluderBounds>& node) {
        node.about(
                "slopes of a light's visibility, by the nearest and the farthest thing that stops "
                "a pixel's shadow rays; and the share of them that pass")
            .in<Samples>("samples",
                         "the camera's: xy, z (uv, t, motion; normal, id where there are)")
            .in<LightView>("light-view", "of the same samples")
            .in<Samples>("light-samples", "where their shadow rays ended; several a sample or none")
            .out<Image>("visibility", "Y: share of the pixel's rays that pass; 1 where it has none")
            .out<Image>("bounds",
                        "s-lo, s-hi: slopes d1/d2 - 1 of the farthest and the nearest occluder "
                        "(inf and 0: none); count: rays; pixel: its width at the receiver, world")
            .out<Image>("receivers",
                        "position in light space, normal and id of what most of the pixel's "
                        "samples show; distance 0 where they show nothing")
            .param("window", &OccluderBounds::window,
                   {.unit = "px",
                    .min = 0,
                    .max = 256,
                    .about = "pixels without occluders of their own take the bounds of those of "
                             "the same id up to here"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"visibility", image_shape(s.width, s.height, 1)},
                 {"bounds", image_shape(s.width, s.height, 4)},
                 {"receivers", image_shape(s.width, s.height, 7)}},
                8.0 * double(s.width) * double(s.height),
                50.0 * double(s.records)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const LightView& view = in.get<LightView>("light-view");
        const PixelRays rays(samples, view, in.get<Samples>("light-samples"), "occluder-bounds");
        Image visibility(samples.width, samples.height, 1);
        Image bounds(samples.width, samples.height, {"s-lo", "s-hi", "count", "pixel"});
        Image receivers(
            samples.width, samples.height,
            {"position.x", "position.y", "position.z", "normal.x", "normal.y", "normal.z", "id"});
        visibility.color_space = bounds.color_space = receivers.color_space = "Raw";
        ctx.parallel_rows(samples.height, [&](Rows rows) {
            std::vector<Point3> places;
            std::vector<ShadowRay> own;
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < samples.width; ++x) {
                    rays.find_places(x, y, places);
                    const PixelReceiver receiver = rays.receiver(x, y, places);
                    rays.of_pixel(x, y, places, own);
                    float *seen = visibility.at(x, y), *b = bounds.at(x, y),
                          *r = receivers.at(x, y);
                    size_t lit = 0;
                    b[0] = none;
                    for (const ShadowRay& ray : own) {
                        lit += ray.lit;
                        if (ray.lit || ray.id != receiver.id) continue;
                        const auto s = float(ray.slope);
                        b[0] = std::min(b[0], s), b[1] = std::max(b[1], s);
                    }
                    *seen = own.empty() ? 1.0f : float(lit) / float(own.size());
                    b[2] = float(own.size());
                    b[3] = float(receiver.pixel);
                    r[0] = float(receiver.at.x), r[1] = float(receiver.at.y);
                    r[2] = float(receiver.at.z);
                    r[3] = float(receiver.normal.x), r[4] = float(receiver.normal.y);
                    r[5] = float(receiver.normal.z);
                    // Ids are only told apart; up to 2^24 a float does so.
                    r[6] = float(receiver.id % (1u << 24));
                }
        });
        spread(receivers, bounds, ctx);
        if (out.wanted("bounds")) out.set("bounds", std::move(bounds));
        if (out.wanted("visibility")) out.set("visibility", std::move(visibility));
        if (out.wanted("receivers")) out.set("receivers", std::move(receivers));
    }

  private:
    static constexpr float none = std::numeric_limits<float>::infinity();

    // Bounds of the pixels around, first along rows, then along columns.
    void spread(const Image& receivers, Image& bounds, Context& ctx) const {
        if (window == 0) return;
        const Image own = bounds;
        Image wide = bounds;
        const auto pass = [&](const Image& from, Image& to, int dx, int dy) {
            ctx.parallel_rows(from.height(), [&](Rows rows) {
                for (int y = rows.begin; y < rows.end; ++y)
                    for (int x = 0; x < from.width(); ++x) {
                        const float id = receivers.at(x, y)[6];
                        float *b = to.at(x, y), lo = none, hi = 0;
                        for (int k = -window; k <= window; ++k) {
                            const int i = x + k * dx, j = y + k * dy;
                            if (i < 0 || i >= from.width() || j < 0 || j >= from.height()) continue;
                            if (receivers.at(i, j)[6] != id) continue;
                            lo = std::min(lo, from.at(i, j)[0]);
                            hi = std::max(hi, from.at(i, j)[1]);
                        }
                        b[0] = lo, b[1] = hi;
                    }
            });
        };
        pass(own, wide, 1, 0);
        pass(wide, bounds, 0, 1);
        for (int y = 0; y < own.height(); ++y)
            for (int x = 0; x < own.width(); ++x)
                if (own.at(x, y)[0] < none) std::copy_n(own.at(x, y), 2, bounds.at(x, y));
    }
};

WEFT_NODE(OccluderBounds, "occluder-bounds", 1)

}  // namespace
}  // namespace weft
