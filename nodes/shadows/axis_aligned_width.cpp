// axis-aligned-width: how wide a pixel's visibility may be filtered without a blur that shows, and
// how many shadow rays such a filter needs.
//   omega  min(mu / (sigma s2), 1 / (p (1 + s2))): where the occluders' farthest slope s2 meets the
//          light's band limit mu / sigma, or the pixel's own
//   beta   1 / omega, the radius at which weights end; world units on the light's plane
//   n      4 (1 / (1 + s2) + p omega)^2 (1 + sigma min(s1 omega, s1 / (p (1 + s1))))^2
// Source: Mehta et al. 2012, Sec. 5.  Departures: a light that is no Gaussian has sigma = A / 2 for
// its half extent A, which keeps the error of an edge's ramp within 0.02; where there are more
// rays than n asks for, beta falls by (n / N)^(1/4), so that the picture converges.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "image/image.h"
#include "image/image_cost.h"
#include "runtime/node.h"
#include "shadows/light_view.h"

namespace weft {
namespace {

struct AxisAlignedWidth {
    float mu = 2, sigma = 0.5f;
    int least = 9, most = 144, reach = 64;

    static void declare(Ports<AxisAlignedWidth>& node) {
        node.about(
                "how wide 'axis-aligned-filter' may filter a light's visibility, and how many "
                "shadow rays a pixel it needs")
            .in<Image>("bounds", "of occluder-bounds")
            .in<Image>("receivers", "of the same")
            .in<LightView>("light-view", "of the same samples")
            .out<Image>("width",
                        "beta: world units, 0 where nothing is to be filtered; radius: the same "
                        "in px; x, y: the pixel's place on the light's plane; samples: n")
            .out<Image>("counts", "samples a pixel: n, within 'least' and 'most'")
            .out<Image>("more",
                        "of these, how many are yet to be made; for 'counts' of "
                        "render-samples")
            .param(
                "mu", &AxisAlignedWidth::mu,
                {.min = 0.1, .max = 100, .about = "standard deviations in the light's band limit"})
            .param("sigma", &AxisAlignedWidth::sigma,
                   {.min = 0.01,
                    .max = 10,
                    .about = "the light's deviation, in parts of its half extent"})
            .param("least", &AxisAlignedWidth::least,
                   {.unit = "samples", .min = 0, .max = 1 << 20, .about = "in any pixel"})
            .param("most", &AxisAlignedWidth::most,
                   {.unit = "samples", .min = 1, .max = 1 << 20, .about = "in any pixel"})
            .param("reach", &AxisAlignedWidth::reach,
                   {.unit = "px", .min = 0, .max = 1024, .about = "widest filter"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["bounds"];
        return {{{"width", image_shape(s.width, s.height, 5)},
                 {"counts", image_shape(s.width, s.height, 1)},
                 {"more", image_shape(s.width, s.height, 1)}},
                0,
                20.0 * double(s.width) * double(s.height)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image &bounds = in.get<Image>("bounds"), &receivers = in.get<Image>("receivers");
        const LightView& view = in.get<LightView>("light-view");
        const auto channel = [&](const Image& of, const char* name) {
            const int c = of.find(name);
            if (c < 0)
                ctx.fail(fmt::format("no channel '{}' among {}; link what occluder-bounds makes",
                                     name, fmt::join(of.names(), " ")));
            return c;
        };
        const int lo = channel(bounds, "s-lo"), hi = channel(bounds, "s-hi"),
                  count = channel(bounds, "count"), pixel = channel(bounds, "pixel");
        const int x_at = channel(receivers, "position.x"), y_at = channel(receivers, "position.y");
        if (bounds.width() != receivers.width() || bounds.height() != receivers.height())
            ctx.fail(fmt::format("'bounds' is {} x {}, 'receivers' {} x {}; expected one size",
                                 bounds.width(), bounds.height(), receivers.width(),
                                 receivers.height()));
        if (least > most)
            ctx.fail(
                fmt::format("least is {}, most is {}; expected least up to most", least, most));

        const bool solid = !view.same_points();
        const double ax = solid ? view.radius : view.ax, ay = solid ? view.radius : view.ay;
        const double half = std::sqrt(ax * ay);
        // An oblong light is taken for a square one by measuring along each side in its own unit.
        const double unit_x = ax > 0 ? half / ax : 1, unit_y = ay > 0 ? half / ay : 1;
        Image width(bounds.width(), bounds.height(), {"beta", "radius", "x", "y", "samples"});
        Image counts(bounds.width(), bounds.height(), 1);
        width.color_space = counts.color_space = "Raw";
        Image more = counts;
        ctx.parallel_rows(bounds.height(), [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < bounds.width(); ++x) {
                    const float* b = bounds.at(x, y);
                    float* w = width.at(x, y);
                    const double N = double(b[count]), p = double(b[pixel]);
                    const Width found = width_of(double(b[lo]), double(b[hi]), p, half);
                    const double n =
                        std::clamp(std::ceil(found.samples), double(least), double(most));
                    const double enough = std::max(found.samples, double(least));
                    const double beta =
                        found.beta * (N > enough ? std::pow(enough / N, 0.25) : 1.0);
                    w[0] = float(beta);
                    w[1] = p > 0 ? float(std::min(beta / p, double(reach))) : 0.0f;
                    w[2] = float(double(receivers.at(x, y)[x_at]) * unit_x);
                    w[3] = float(double(receivers.at(x, y)[y_at]) * unit_y);
                    w[4] = float(found.samples);
                    *counts.at(x, y) = float(n);
                    *more.at(x, y) = float(std::max(n - N, 0.0));
                }
        });
        if (out.wanted("width")) out.set("width", std::move(width));
        if (out.wanted("counts")) out.set("counts", std::move(counts));
        if (out.wanted("more")) out.set("more", std::move(more));
    }

  private:
    struct Width {
        double beta = 0, samples = 0;
    };
    // `p`: a pixel's width at the receiver; `half`: the light's extent.
    Width width_of(double s2, double s1, double p, double half) const {
        if (!(s2 < INFINITY) || !(p > 0)) return {};
        const double deviation = double(sigma) * half;
        const double by_light = deviation * s2 > 0 ? double(mu) / (deviation * s2) : INFINITY;
        const double omega = std::min(by_light, 1 / (p * (1 + s2)));
        const double over_pixels = 1 / (1 + s2) + p * omega;
        const double over_light = 1 + deviation * std::min(s1 * omega, s1 / (p * (1 + s1)));
        return {1 / omega, 4 * over_pixels * over_pixels * over_light * over_light};
    }
};

WEFT_NODE(AxisAlignedWidth, "axis-aligned-width", 1)

}  // namespace
}  // namespace weft
