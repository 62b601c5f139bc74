// directional-occlusion: how much of what lies above them surfaces see, by direction, from a ray a
// sample: the far-field form of sheared visibility. A ray from x_s along omega_s that was stopped,
// or not, between the depths z_min and z_max of a pixel's occluders says the same of the direction
// in which the pixel sees the point that the ray passes at their harmonic mean depth, zbar; there
// rays of pixels around are compared, so nothing is rotated.
//   along  a Gaussian of the change of direction, deviation s_x / (zbar^2 (1/z_min - 1/z_max) / 2),
//          s_x = 0.5 max(p, z_min theta): p a pixel's width, theta = 1 rad that of the cosine
//   near   what is nearer than 4 p / theta changes over few pixels: such hits are counted apart,
//          over 5 x 5 pixels and not slid; z_min is no less than that
//   parts  the directions are cut in 4 x 4 of equal cosine, each with a mean of its own
// Source: Egan et al. 2011 (directional occlusion), Sec. 4 and 5.  Departure: sliding is counted in
// full, so that a pixel's directions need no second filter; near hits, for which more rays were
// shot, are the two averages' difference.
#include <fmt/format.h>

#include <array>
#include <numbers>

#include "image/each_line.h"
#include "image/image.h"
#include "image/image_cost.h"
#include "render/shading_frame.h"
#include "runtime/node.h"
#include "samples/samplers.h"
#include "samples/samples.h"

namespace weft {
namespace {

constexpr float theta = 1;     // rad: of the cosine lobe
constexpr int near_reach = 2;  // px
constexpr size_t parts = 4;    // of the directions, along each axis
constexpr int bands = 9;       // spherical harmonics, up to the second band

// Real spherical harmonics of a unit vector.
std::array<double, bands> harmonics_of(Vec3 d) {
    const double x = double(d.x), y = double(d.y), z = double(d.z);
    return {0.28209479177387814,
            0.4886025119029199 * y,
            0.4886025119029199 * z,
            0.4886025119029199 * x,
            1.0925484305920792 * x * y,
            1.0925484305920792 * y * z,
            0.31539156525252005 * (3 * z * z - 1),
            1.0925484305920792 * x * z,
            0.5462742152960396 * (x * x - y * y)};
}

struct DirectionalOcclusion {
    enum class Output { occlusion, visibility, harmonics };
    Output output = Output::occlusion;
    int window = 10, reach = 32;
    float normal_angle = 30, depth = 0.1f;

    static void declare(Ports<DirectionalOcclusion>& node) {
        node.about("how much of what is above them surfaces see, from rays shared between pixels")
            .in<Samples>("samples",
                         "xy, z, position, normal, bounce, hit_distance (id): of "
                         "render-occlusion-rays")
            .out<Image>("image",
                        "Y: the part of the sky's cosine that is hidden, or seen; or c0 to c8: "
                        "integrals of "
                        "visibility times cosine times spherical harmonics, in world space")
            .out<Image>("rays", "that had a say, its own among them")
            .choice("output", &DirectionalOcclusion::output,
                    {"occlusion", "visibility", "harmonics"}, {.about = "what the picture holds"})
            .param("window", &DirectionalOcclusion::window,
                   {.unit = "px",
                    .min = 0,
                    .max = 256,
                    .about = "pixels of the same id up to here bound the occluders' depths"})
            .param("reach", &DirectionalOcclusion::reach,
                   {.unit = "px", .min = 0, .max = 1024, .about = "from how far rays are taken"})
            .param("normal-angle", &DirectionalOcclusion::normal_angle,
                   {.unit = "degrees",
                    .min = 0,
                    .max = 90,
                    .about = "rays of surfaces turned farther off are left out"})
            .param("depth", &DirectionalOcclusion::depth,
                   {.min = 0,
                    .max = 1e6,
                    .about = "and those farther off the pixel's plane, in parts of the depth of "
                             "its nearest occluder"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"image", image_shape(s.width, s.height, output == Output::harmonics ? 9 : 1)},
                 {"rays", image_shape(s.width, s.height, 1)}},
                sizeof(Pixel) * double(s.width) * double(s.height),
                20000.0 * double(s.records)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        samples.require("directional-occlusion",
                        {"xy", "z", "position", "normal", "bounce", "hit_distance"});
        if (samples.domain != "camera")
            ctx.fail(
                fmt::format("needs a camera's samples, these are of domain '{}'", samples.domain));
        const Rays rays(samples);
        std::vector<Pixel> pixels(samples.pixels());
        ctx.parallel_for(
            samples.pixels(), [&](size_t p) { pixels[p] = rays.pixel(p); }, 256);
        find_sizes(samples, pixels);
        spread(samples, pixels, ctx);

        const bool whole = output == Output::harmonics;
        Image image = whole ? Image(samples.width, samples.height, names())
                            : Image(samples.width, samples.height, 1);
        Image used(samples.width, samples.height, 1);
        image.color_space = used.color_space = "Raw";
        each_line(ctx, samples.height, "rows", [&](int y) {
            for (int x = 0; x < samples.width; ++x)
                filter(samples, rays, pixels, x, y, image.at(x, y), *used.at(x, y));
        });
        if (out.wanted("image")) out.set("image", std::move(image));
        if (out.wanted("rays")) out.set("rays", std::move(used));
    }

  private:
    // Where a pixel's surface lies, and between which depths its occluders do.
    struct Pixel {
        Vec3 at, normal;
        std::uint32_t id = 0, rays = 0;
        float size = 0, nearest = INFINITY, farthest = 0;
        float own_nearest = INFINITY, own_farthest = 0;
    };
    static std::vector<std::string> names() {
        std::vector<std::string> all;
        for (int c = 0; c < bands; ++c) all.push_back(fmt::format("c{}", c));
        return all;
    }

    struct Rays {
        explicit Rays(const Samples& s)
            : samples(s),
              position(s.values("position")),
              normal(s.values("normal")),
              way(s.values("bounce")),
              distance(s.values("hit_distance")) {
            if (const Channel* channel = s.find("id")) ids = channel->ids.view();
        }
        const Samples& samples;
        std::span<const float> position, normal, way, distance;
        std::span<const std::uint32_t> ids;

        static Vec3 vector(std::span<const float> of, size_t i) {
            return {of[3 * i], of[3 * i + 1], of[3 * i + 2]};
        }
        bool there(size_t i) const { return distance[i] > 0; }
        bool stopped(size_t i) const { return distance[i] < INFINITY; }
        // The normal on the side that the ray left to.
        Vec3 facing(size_t i) const {
            const Vec3 n = vector(normal, i);
            return dot(n, vector(way, i)) < 0 ? -n : n;
        }
        Pixel pixel(size_t p) const {
            Pixel out;
            const auto range = samples.of_pixel(p);
            for (size_t i = range.begin; i < range.end; ++i) {
                if (!there(i)) continue;
                // The surface of the first hit; others of the pixel are another's.
                const std::uint32_t id = ids.empty() ? 0 : ids[i];
                if (out.rays == 0) out.id = id;
                if (id != out.id) continue;
                ++out.rays;
                out.at = out.at + vector(position, i), out.normal = out.normal + facing(i);
                if (!stopped(i)) continue;
                out.own_nearest = std::min(out.own_nearest, distance[i]);
                out.own_farthest = std::max(out.own_farthest, distance[i]);
            }
            if (out.rays == 0) return out;
            out.at = out.at * (1 / float(out.rays));
            const float l = length(out.normal);
            out.normal = l > 0 ? out.normal * (1 / l) : Vec3{0, 0, 1};
            return out;
        }
    };

    // How wide pixels are: half the way to their neighbours on either side, the shorter.
    static void find_sizes(const Samples& samples, std::vector<Pixel>& pixels) {
        const int width = samples.width, height = samples.height;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                Pixel& own = pixels[size_t(y) * size_t(width) + size_t(x)];
                float least = INFINITY;
                for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
                    const int i = x + dx, j = y + dy;
                    if (i < 0 || i >= width || j < 0 || j >= height) continue;
                    const Pixel& next = pixels[size_t(j) * size_t(width) + size_t(i)];
                    if (next.rays > 0 && next.id == own.id)
                        least = std::min(least, length(next.at - own.at));
                }
                own.size = least < INFINITY ? least : 0;
            }
    }

    void spread(const Samples& samples, std::vector<Pixel>& pixels, Context& ctx) const {
        const int width = samples.width, height = samples.height;
        const auto pass = [&](int dx, int dy, const std::vector<Pixel>& from,
                              std::vector<Pixel>& to) {
            ctx.parallel_rows(height, [&](Rows rows) {
                for (int y = rows.begin; y < rows.end; ++y)
                    for (int x = 0; x < width; ++x) {
                        Pixel& own = to[size_t(y) * size_t(width) + size_t(x)];
                        float nearest = INFINITY, farthest = 0;
                        for (int k = -window; k <= window; ++k) {
                            const int i = x + k * dx, j = y + k * dy;
                            if (i < 0 || i >= width || j < 0 || j >= height) continue;
                            const Pixel& next = from[size_t(j) * size_t(width) + size_t(i)];
                            if (next.rays == 0 || next.id != own.id) continue;
                            nearest = std::min(nearest, next.own_nearest);
                            farthest = std::max(farthest, next.own_farthest);
                        }
                        own.nearest = nearest, own.farthest = farthest;
                    }
            });
        };
        std::vector<Pixel> wide = pixels;
        pass(1, 0, pixels, wide);
        for (Pixel& p : wide) p.own_nearest = p.nearest, p.own_farthest = p.farthest;
        pass(0, 1, wide, pixels);
    }

    struct Part {
        double all = 0, hidden = 0;
        std::array<double, bands> basis{};  // summed where asked for

        void add(double w, bool hides, bool counts, Vec3 way) {
            all += w;
            if (hides) hidden += w;
            if (!counts) return;
            const auto here = harmonics_of(way);
            for (size_t c = 0; c < here.size(); ++c) basis[c] += w * here[c];
        }
    };

    void filter(const Samples& samples, const Rays& rays, const std::vector<Pixel>& pixels, int x,
                int y, float* to, float& used) const {
        const int width = samples.width, height = samples.height;
        const Pixel& own = pixels[size_t(y) * size_t(width) + size_t(x)];
        if (own.rays == 0) {
            if (output == Output::visibility) *to = 1;
            return;
        }
        // Nothing is met anywhere near: all is seen, whoever's rays are asked.
        const bool open = !(own.nearest < INFINITY);
        const float limit = 4 * own.size / theta;
        const float nearest = std::max(own.nearest, limit),
                    farthest = std::max(own.farthest, nearest);
        float zbar = 1, deviation = 1;
        int around = 0;
        if (!open && reach > 0) {
            zbar = 2 / (1 / nearest + 1 / farthest);
            const float across = 0.5f * std::max(own.size, nearest * theta);
            const float spread_of = zbar * zbar * (1 / nearest - 1 / farthest) / 2;
            deviation = std::min(spread_of > 0 ? across / spread_of : INFINITY, 2 * theta);
            // Half a radian at most: beyond, slid rays leave the half-space.
            const float far = std::min(2.5f * deviation, 0.5f) * zbar;
            around = own.size > 0 ? std::min(int(far / own.size), reach) : 0;
        }
        const bool shared = around > 0;
        const render::ShadingFrame frame(own.normal);
        const float least_cosine = std::cos(normal_angle * std::numbers::pi_v<float> / 180);
        std::array<Part, parts * parts> sums;
        Part near;
        size_t count = 0;
        for (int j = std::max(y - around, 0); j <= std::min(y + around, height - 1); ++j)
            for (int i = std::max(x - around, 0); i <= std::min(x + around, width - 1); ++i) {
                const size_t p = size_t(j) * size_t(width) + size_t(i);
                const Pixel& there = pixels[p];
                if (there.rays == 0 || there.id != own.id) continue;
                const bool self = i == x && j == y;
                if (!self && (dot(there.normal, own.normal) < least_cosine ||
                              std::abs(dot(there.at - own.at, own.normal)) > depth * nearest))
                    continue;
                const auto range = samples.of_pixel(p);
                for (size_t k = range.begin; k < range.end; ++k) {
                    if (!rays.there(k) || (!rays.ids.empty() && rays.ids[k] != own.id)) continue;
                    const Vec3 way = Rays::vector(rays.way, k);
                    const bool close = shared && rays.distance[k] < limit;
                    double w = 1 / double(there.rays);
                    if (shared && std::max(std::abs(i - x), std::abs(j - y)) <= near_reach)
                        near.add(w, close, close, way);
                    Vec3 slid = way;
                    if (!self) {
                        slid = unit(Rays::vector(rays.position, k) + way * zbar - own.at);
                        const Vec3 turn = slid - way;
                        const float off2 = dot(turn, turn) / (2 * deviation * deviation);
                        if (off2 > 3.125f) continue;
                        w *= double(std::exp(-off2));
                    }
                    const Vec3 local = frame.to_local(slid);
                    if (!(local.z > 0)) continue;
                    const bool hidden = rays.stopped(k) && !close;
                    sums[part_of(local)].add(w, hidden, !hidden, slid);
                    ++count;
                }
            }
        write(sums, near, shared, to);
        used = float(count);
    }

    // Parts hold as much of the cosine each: the disc below the directions, mapped to a square.
    static size_t part_of(Vec3 local) {
        const Disk square = concentric_square(local.x, local.y);
        const auto cell = [](float a) {
            return size_t(std::clamp(a * float(parts), 0.0f, float(parts) - 1));
        };
        return cell(square.v) * parts + cell(square.u);
    }

    void write(const std::array<Part, parts * parts>& sums, const Part& near, bool shared,
               float* to) const {
        double most = 0, all = 0;
        for (const Part& part : sums) most = std::max(most, part.all), all += part.all;
        std::array<double, bands> seen{};
        double hidden = 0, n = 0;
        for (const Part& part : sums) {
            // Of a pixel's own few rays each counts alike; they are spread well already.
            const double of = shared ? part.all : all;
            if (!(part.all > (shared ? 1e-3 * most : 0))) continue;
            hidden += part.hidden / of;
            for (size_t c = 0; c < seen.size(); ++c) seen[c] += part.basis[c] / of;
            n += shared ? 1 : part.all / all;
        }
        if (!(n > 0)) return;
        hidden /= n;
        for (double& v : seen) v /= n;
        if (near.all > 0) {
            hidden = std::min(hidden + near.hidden / near.all, 1.0);
            for (size_t c = 0; c < seen.size(); ++c) seen[c] -= near.basis[c] / near.all;
        }
        if (output == Output::occlusion)
            *to = float(hidden);
        else if (output == Output::visibility)
            *to = float(1 - hidden);
        else  // rays lie by cosine / pi
            for (size_t c = 0; c < seen.size(); ++c) to[c] = float(std::numbers::pi * seen[c]);
    }
};

WEFT_NODE(DirectionalOcclusion, "directional-occlusion", 1)

}  // namespace
}  // namespace weft
