// sheared-visibility: the share of a light that each pixel sees, by a filter over receivers and
// light that is sheared along the slopes of its occluders: rays of pixels around are slid along
// s = d1 / d2 - 1, from light point to light point, onto the pixel's own receiver, and weighted by
// how much of the light they stand for there.
//   W      min(1 / p, Omega / s2): how fast visibility may vary over the receiver, radians a unit,
//          Omega the light's band limit: of a side of half extent A pi / A, of a disc 1.22 pi / A
//   across a Gaussian of deviation 0.35 / W
//   along  one of 0.8 / (W (s1 - s2) / 2), four half extents at most
//   parts  the light is cut in 4 x 4, each with a mean of its own: at the picture's sides, and
//          beside other surfaces, more rays stand for one part of the light than for another
// Source: Egan et al. 2011, Sec. 4.  Departures: the integral over the light in closed form; the
// light's limit is that of its shape, as for a camera's lens, which blurs an edge's ramp least.
#include <fmt/format.h>

#include <array>
#include <numbers>

#include "adaptive/sheared_weights.h"
#include "image/each_line.h"
#include "image/image.h"
#include "image/image_cost.h"
#include "runtime/node.h"
#include "shadows/pixel_rays.h"

namespace weft {
namespace {
using namespace shadows;

struct Ray {
    Point3 light, receiver, normal;
    bool lit;
};

struct ShearedVisibility {
    float across = 0.35f, along = 0.8f, contact = 0.02f, normal_angle = 30, depth = 0.1f;
    int reach = 32;

    static void declare(Ports<ShearedVisibility>& node) {
        node.about(
                "the share of a light that each pixel sees, from shadow rays around that are slid "
                "along the slopes of its occluders")
            .in<Samples>("samples",
                         "the camera's: xy, z (uv, t, motion; geometric_normal or normal, id)")
            .in<LightView>("light-view", "of the same samples")
            .in<Samples>("light-samples", "where their shadow rays ended")
            .in<Image>("bounds", "of occluder-bounds")
            .in<Image>("receivers", "of the same")
            .out<Image>("visibility", "Y: share seen")
            .out<Image>("rays", "shadow rays that had a say; 0 where a pixel kept its own mean")
            .param("across", &ShearedVisibility::across,
                   {.min = 0.001, .max = 100, .about = "deviation on the receiver, in 1 / W"})
            .param("along", &ShearedVisibility::along,
                   {.min = 0.001,
                    .max = 100,
                    .about = "deviation over the light, in cycles of what shearing leaves"})
            .param(
                "contact", &ShearedVisibility::contact,
                {.min = 0,
                 .max = 100,
                 .about = "slopes below: the occluder touches, and the pixel keeps its own mean"})
            .param("normal-angle", &ShearedVisibility::normal_angle,
                   {.unit = "degrees",
                    .min = 0,
                    .max = 180,
                    .about = "rays to receivers turned farther off are left out"})
            .param("depth", &ShearedVisibility::depth,
                   {.min = 0,
                    .max = 1e6,
                    .about = "and those farther off the pixel's plane, in parts of its distance"})
            .param("reach", &ShearedVisibility::reach,
                   {.unit = "px", .min = 0, .max = 1024, .about = "from how far rays are taken"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"visibility", image_shape(s.width, s.height, 1)},
                 {"rays", image_shape(s.width, s.height, 1)}},
                double(sizeof(Ray)) * double(s.records),
                20000.0 * double(s.records)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const LightView& view = in.get<LightView>("light-view");
        const PixelRays pixels(samples, view, in.get<Samples>("light-samples"),
                               "sheared-visibility");
        const Image &bounds = in.get<Image>("bounds"), &receivers = in.get<Image>("receivers");
        const Slopes at{bounds.find("s-lo"), bounds.find("s-hi"), bounds.find("pixel")};
        if (at.lo < 0 || at.hi < 0 || at.pixel < 0 || receivers.find("position.x") != 0 ||
            receivers.find("normal.x") != 3)
            ctx.fail(
                "'bounds' and 'receivers' are not of occluder-bounds; link its outputs of these "
                "names");
        for (const Image* image : {&bounds, &receivers})
            if (image->width() != samples.width || image->height() != samples.height)
                ctx.fail(
                    fmt::format("'bounds' or 'receivers' is {} x {}, the samples {} x {}; "
                                "expected one size",
                                image->width(), image->height(), samples.width, samples.height));

        const PixelRows rays = rays_of(pixels, receivers, ctx);
        Image visibility(samples.width, samples.height, 1);
        visibility.color_space = "Raw";
        Image used = visibility;
        each_line(ctx, samples.height, "rows", [&](int y) {
            for (int x = 0; x < samples.width; ++x)
                filter(view, rays, bounds.at(x, y), at, receivers, x, y, *visibility.at(x, y),
                       *used.at(x, y));
        });
        if (out.wanted("visibility")) out.set("visibility", std::move(visibility));
        if (out.wanted("rays")) out.set("rays", std::move(used));
    }

  private:
    // All rays, pixel by pixel.
    struct PixelRows {
        std::vector<Ray> rays;
        std::vector<size_t> first;  // of each pixel, and the end
        size_t width;
        std::span<const Ray> of(int x, int y) const {
            const size_t pixel = size_t(y) * width + size_t(x);
            return std::span(rays).subspan(first[pixel], first[pixel + 1] - first[pixel]);
        }
    };
    static PixelRows rays_of(const PixelRays& pixels, const Image& receivers, Context& ctx) {
        const auto width = size_t(receivers.width()), height = size_t(receivers.height());
        // Rows are filled at once, then joined.
        std::vector<PixelRows> rows(height);
        ctx.parallel_for(height, [&](size_t y) {
            std::vector<Point3> places;
            std::vector<ShadowRay> own;
            for (size_t x = 0; x < width; ++x) {
                pixels.find_places(int(x), int(y), places);
                pixels.of_pixel(int(x), int(y), places, own);
                const float* r = receivers.at(int(x), int(y));
                const Point3 normal{double(r[3]), double(r[4]), double(r[5])};
                for (const ShadowRay& ray : own)
                    rows[y].rays.push_back({ray.light, ray.receiver, normal, ray.lit});
                rows[y].first.push_back(rows[y].rays.size());
            }
        });
        PixelRows all{{}, {0}, width};
        for (const PixelRows& row : rows) {
            const size_t before = all.rays.size();
            all.rays.insert(all.rays.end(), row.rays.begin(), row.rays.end());
            for (const size_t end : row.first) all.first.push_back(before + end);
        }
        return all;
    }

    struct Slopes {
        int lo, hi, pixel;
    };
    static constexpr size_t parts = 4;  // of the light, along each axis
    struct Part {
        double all = 0, lit = 0;
    };
    // Of one axis of the light.
    struct Axis {
        double half, sigma_x, sigma_y;
    };

    Axis axis_of(double half, bool round, double lo, double hi, double pixel) const {
        const double limit = (round ? 1.22 : 1) * std::numbers::pi / half;
        const double band = std::min(1 / pixel, limit / lo);
        const double residual = band * (hi - lo) / 2;
        return {half, double(across) / band,
                std::min(residual > 0 ? double(along) / residual : INFINITY, 4 * half)};
    }

    // The part of a round light that the Gaussian around (x, y) has there, about: its mass on the
    // near side of the rim.
    static double on_disc(double x, double y, double half, double deviation) {
        const double r = std::sqrt(x * x + y * y + deviation * deviation);
        return 0.5 * std::erfc((r - half) / (deviation * std::numbers::sqrt2));
    }

    void filter(const LightView& view, const PixelRows& rays, const float* b, const Slopes& slopes,
                const Image& receivers, int x, int y, float& visibility, float& used) const {
        const int width = receivers.width(), height = receivers.height();
        const auto own = rays.of(x, y);
        size_t lit = 0;
        for (const Ray& ray : own) lit += ray.lit;
        visibility = own.empty() ? 1.0f : float(lit) / float(own.size());
        const double lo = double(b[slopes.lo]), hi = double(b[slopes.hi]),
                     pixel = double(b[slopes.pixel]);
        const bool solid = !view.same_points();
        const double ax = solid ? view.radius : view.ax, ay = solid ? view.radius : view.ay;
        if (!(lo < INFINITY) || !(lo > double(contact)) || !(pixel > 0) || !(ax > 0) || !(ay > 0))
            return;

        const bool round =
            view.shape != LightView::Shape::quad && view.shape != LightView::Shape::mesh;
        const Axis along_x = axis_of(ax, round, lo, hi, pixel),
                   along_y = axis_of(ay, round, lo, hi, pixel);
        const double shear = (lo + hi) / 2;
        const auto farthest = [&](const Axis& a) {
            return std::min(shear * 2 * a.half + 2.5 * a.sigma_x,
                            2.5 * std::hypot(a.sigma_x, shear * a.sigma_y));
        };
        const double far_x = farthest(along_x), far_y = farthest(along_y);
        const int around = std::min(int(std::ceil(std::max(far_x, far_y) / pixel)), reach);
        const float* r = receivers.at(x, y);
        const Point3 at{double(r[0]), double(r[1]), double(r[2])},
            normal{double(r[3]), double(r[4]), double(r[5])};
        const double least_cosine = std::cos(double(normal_angle) * std::numbers::pi / 180);

        std::array<Part, parts * parts> sums;
        double most = 0;
        size_t count = 0;
        for (int j = std::max(y - around, 0); j <= std::min(y + around, height - 1); ++j)
            for (int i = std::max(x - around, 0); i <= std::min(x + around, width - 1); ++i) {
                const auto there = rays.of(i, j);
                if (there.empty()) continue;
                // Where rays lie denser, each stands for less.
                const double each = 1 / double(there.size());
                for (const Ray& ray : there) {
                    // Along the ray onto the plane through the receiver that faces the light.
                    const double way = at.z / ray.receiver.z;
                    const Point3 hit = ray.light + (ray.receiver - ray.light) * way;
                    const double dx = hit.x - at.x, dy = hit.y - at.y;
                    if (std::abs(dx) > far_x || std::abs(dy) > far_y) continue;
                    if (dot(normal, ray.normal) < least_cosine * (dot(normal, normal) > 0))
                        continue;
                    if (std::abs(dot(normal, ray.receiver - at)) > double(depth) * at.z ||
                        std::abs(way - 1) > 2 * double(depth))
                        continue;
                    const Slid slid = slide(along_x, along_y, shear, round, dx, dy, ray);
                    const double w = each * slid.weight;
                    if (!(w > 0)) continue;
                    Part& part = sums[slid.part];
                    part.all += w;
                    if (ray.lit) part.lit += w;
                    most = std::max(most, w);
                    count += w > 1e-3 * most;
                }
            }
        if (count < 4) return;
        double all = 0, seen = 0, area = 0;
        for (const Part& part : sums) all = std::max(all, part.all);
        for (size_t k = 0; k < sums.size(); ++k) {
            if (!(sums[k].all > 1e-3 * all)) continue;
            const double share = round ? disc_share(k) : 1;
            seen += share * sums[k].lit / sums[k].all, area += share;
        }
        if (!(area > 0)) return;
        visibility = float(seen / area);
        used = float(count);
    }

    // The part of the light that is a ray's, slid onto the receiver.
    struct Slid {
        double weight = 0;
        size_t part = 0;
    };
    static Slid slide(const Axis& along_x, const Axis& along_y, double shear, bool round, double dx,
                      double dy, const Ray& ray) {
        using namespace adaptive;
        const ShearedGaussian x(dx, ray.light.x, along_x.sigma_x, along_x.sigma_y, shear),
            y(dy, ray.light.y, along_y.sigma_x, along_y.sigma_y, shear);
        Slid out;
        if (x.falloff + y.falloff > 5) return out;
        // In units of the light's half extents, which are as long either way where it is round.
        const double mx = x.middle / along_x.half, my = y.middle / along_y.half;
        const double deviation = 1 / (std::sqrt(x.a) * along_x.half);
        if (std::max(std::abs(mx), std::abs(my)) > 1 + 3 * deviation) return out;
        if (round)
            out.weight = std::exp(-x.falloff - y.falloff) * on_disc(mx, my, 1, deviation);
        else
            out.weight = gaussian_over_window(dx, ray.light.x, along_x.sigma_x, along_x.sigma_y,
                                              shear, along_x.half) *
                         gaussian_over_window(dy, ray.light.y, along_y.sigma_x, along_y.sigma_y,
                                              shear, along_y.half);
        // A ray that stands for half the light or more is of no one part.
        if (deviation < 0.5) {
            const auto cell = [](double m) {
                return size_t(std::clamp((m + 1) * (parts / 2.0), 0.0, parts - 1.0));
            };
            out.part = cell(my) * parts + cell(mx);
        }
        return out;
    }
    // How much of the unit disc lies in a part.
    static double disc_share(size_t part) {
        const auto side = [](size_t k) {
            return adaptive::Interval{float(k) * 2 / parts - 1, float(k + 1) * 2 / parts - 1};
        };
        return double(adaptive::share_on_disc(side(part % parts), side(part / parts)));
    }
};

WEFT_NODE(ShearedVisibility, "sheared-visibility", 1)

}  // namespace
}  // namespace weft
