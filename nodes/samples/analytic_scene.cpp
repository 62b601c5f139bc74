#include "samples/analytic_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <span>

#include "graph/error.h"
#include "samples/analytic_garden.h"
#include "samples/analytic_known.h"
#include "samples/random.h"

namespace weft {
namespace {

using namespace analytic;

struct Entry {
    std::string_view name;
    Scene (*build)(const AnalyticOptions&);
    Color (*exact)(const AnalyticOptions&, int x, int y);  // null: not known
};
constexpr Entry entries[] = {{"garden", garden_scene, nullptr},
                             {"step", step_scene, step_exact},
                             {"plane", plane_scene, plane_exact},
                             {"disc", disc_scene, disc_exact},
                             {"layers", layers_scene, layers_exact}};

const Entry& entry_of(std::string_view name) {
    for (const Entry& entry : entries)
        if (entry.name == name) return entry;
    throw Error(fmt::format("no analytic scene '{}'; there are {}", name,
                            fmt::join(analytic_scene_names(), ", ")));
}

void check(const AnalyticOptions& o, int spp) {
    if (o.width < 1 || o.height < 1 || o.width > 32768 || o.height > 32768)
        throw Error(fmt::format("an analytic scene of {} x {} pixels; expected 1 to 32768 each way",
                                o.width, o.height));
    if (spp < 1 || spp > 1 << 20)
        throw Error(fmt::format("{} samples a pixel; expected 1 to {}", spp, 1 << 20));
    if (!(o.aperture >= 0) || !std::isfinite(o.aperture) || !std::isfinite(o.shutter))
        throw Error(
            fmt::format("aperture {} and shutter {}; expected finite numbers, aperture 0 or more",
                        o.aperture, o.shutter));
}

// Which of the sampler's dimensions are what: the lens takes the pair that Sobol' stratifies best.
enum Dimension { lens_a, lens_b, film_x, film_y, shutter_time, dimensions };

// Samples [first, first + per_pixel) of every pixel of a tile, pixel by pixel.
struct Batch5 {
    Rays rays;
    float film_x[Rays::capacity], film_y[Rays::capacity];
    float u[Rays::capacity], v[Rays::capacity], t[Rays::capacity];
};
struct TilePixels {
    int x0, y0, x1, y1;
    int count() const { return (x1 - x0) * (y1 - y0); }
};
constexpr int most_per_pixel = Rays::capacity / (Tracer::tile * Tracer::tile);

void make_rays(const Camera& camera, Sampler sampler, std::uint64_t seed, const TilePixels& tile,
               int spp, int first, int per_pixel, Batch5& batch) {
    float numbers[dimensions * most_per_pixel];
    int n = 0;
    for (int y = tile.y0; y < tile.y1; ++y)
        for (int x = tile.x0; x < tile.x1; ++x) {
            fill_samples(sampler, seed, x, y, spp, first, per_pixel, dimensions, numbers,
                         most_per_pixel);
            const auto number = [&](Dimension d, int i) { return numbers[d * most_per_pixel + i]; };
            const float last_x = std::nextafter(float(x + 1), 0.0f),
                        last_y = std::nextafter(float(y + 1), 0.0f);
            for (int i = 0; i < per_pixel; ++i, ++n) {
                const Disk lens = concentric_disk(number(lens_a, i), number(lens_b, i));
                batch.film_x[n] = std::min(float(x) + number(film_x, i), last_x);
                batch.film_y[n] = std::min(float(y) + number(film_y, i), last_y);
                batch.u[n] = lens.u, batch.v[n] = lens.v;
                batch.t[n] = number(shutter_time, i);
            }
        }
    Rays& rays = batch.rays;
    rays.count = n;
    const float per_pixel_x = 1 / camera.scale, slope = camera.lens_radius / camera.focus;
    for (int i = 0; i < n; ++i) {
        rays.lens_x[i] = camera.lens_radius * batch.u[i];
        rays.lens_y[i] = camera.lens_radius * batch.v[i];
        rays.x[i] = (batch.film_x[i] - camera.center_x) * per_pixel_x - slope * batch.u[i];
        rays.y[i] = (batch.film_y[i] - camera.center_y) * per_pixel_x - slope * batch.v[i];
        rays.time[i] = batch.t[i] - 0.5f;
    }
}

struct Hit {
    const Primitive* primitive;  // null: the sky
    Vec3 position, normal;       // normal: towards the lens
    Surface surface;
};
Hit hit_of(const Scene& scene, const Rays& rays, int i) {
    const Vec3 direction{rays.x[i], rays.y[i], 1};
    if (rays.hit[i] < 0) return {nullptr, {}, {}, {{}, scene.sky(direction.x, direction.y)}};
    const Primitive& p = scene.primitives[size_t(rays.hit[i])];
    Hit hit{&p, rays.depth[i] * direction + Vec3{rays.lens_x[i], rays.lens_y[i], 0}, {}, {}};
    if (p.sphere()) {
        hit.normal = unit(hit.position - (p.origin + rays.time[i] * p.origin_motion));
    } else {
        hit.normal = unit(cross(p.side_a + rays.time[i] * p.side_a_motion,
                                p.side_b + rays.time[i] * p.side_b_motion));
        if (dot(hit.normal, direction) > 0) hit.normal = hit.normal * -1;
    }
    hit.surface = p.texture(p.paint, rays.a[i], rays.b[i], hit.normal);
    return hit;
}

// Runs work(tile, batch, first, per_pixel) over all tiles in parallel and all samples in order.
template <class Work>
void for_tiles(const Tracer& tracer, const AnalyticOptions& o, std::uint64_t seed, int spp,
               Context& ctx, const Work& work) {
    static_assert(analytic_band % Tracer::tile == 0);
    const int first_down = o.first_row / Tracer::tile, down = (o.rows() + Tracer::tile - 1) / Tracer::tile;
    const size_t tiles = size_t(tracer.tiles_x()) * size_t(down);
    std::atomic<size_t> done{0};
    ctx.parallel(tiles, 1, [&](size_t begin, size_t end) {
        const auto batch = std::make_unique<Batch5>();
        for (size_t index = begin; index < end; ++index) {
            const int tx = int(index % size_t(tracer.tiles_x())),
                      ty = first_down + int(index / size_t(tracer.tiles_x()));
            const TilePixels tile{tx * Tracer::tile, ty * Tracer::tile,
                                  std::min((tx + 1) * Tracer::tile, o.width),
                                  std::min((ty + 1) * Tracer::tile, o.height)};
            for (int first = 0; first < spp; first += most_per_pixel) {
                ctx.check_cancelled();
                const int per_pixel = std::min(most_per_pixel, spp - first);
                make_rays(tracer.scene().camera, o.sampler, seed, tile, spp, first, per_pixel,
                          *batch);
                tracer.trace(tx, ty, batch->rays);
                work(tile, *batch, first, per_pixel);
            }
            ctx.progress(double(++done), double(tiles), "tiles");
        }
    });
}

void put(std::vector<float>& to, size_t i, Vec3 v) {
    to[3 * i] = v.x, to[3 * i + 1] = v.y, to[3 * i + 2] = v.z;
}

// Homogeneous screen motion of a displacement (formats: motion).
Vec3 motion_of(const Camera& camera, Vec3 d) {
    return {camera.center_x * d.z + camera.scale * d.x, camera.center_y * d.z + camera.scale * d.y,
            d.z};
}

Json matrix(std::initializer_list<std::initializer_list<double>> rows) {
    Json list = Json::list();
    for (const auto& row : rows) {
        Json items = Json::list();
        for (double value : row) items.items.emplace_back(value);
        list.items.push_back(std::move(items));
    }
    return list;
}

}  // namespace

std::vector<std::string> analytic_scene_names() {
    std::vector<std::string> names;
    for (const Entry& entry : entries) names.emplace_back(entry.name);
    return names;
}

Samples analytic_samples(std::string_view name, const AnalyticOptions& o, Context& ctx) {
    const Entry& entry = entry_of(name);
    check(o, o.spp);
    const Scene scene = entry.build(o);
    const Tracer tracer(scene, o.width, o.height);
    const size_t n = size_t(o.width) * size_t(o.rows()) * size_t(o.spp);
    std::vector<float> xy(2 * n), uv(2 * n), t(n), z(n), motion(3 * n), rgb(3 * n), alpha(n);
    std::vector<float> position(3 * n), normal(3 * n), albedo(3 * n);
    std::vector<std::uint32_t> id(n);

    for_tiles(tracer, o, o.seed, o.spp, ctx,
              [&](const TilePixels& tile, const Batch5& batch, int first, int per_pixel) {
                  int k = 0;
                  for (int y = tile.y0; y < tile.y1; ++y)
                      for (int x = tile.x0; x < tile.x1; ++x)
                          for (int s = 0; s < per_pixel; ++s, ++k) {
                              const size_t i =
                                  (size_t(y - o.first_row) * size_t(o.width) + size_t(x)) * size_t(o.spp) +
                                  size_t(first + s);
                              const Rays& rays = batch.rays;
                              xy[2 * i] = batch.film_x[k], xy[2 * i + 1] = batch.film_y[k];
                              uv[2 * i] = batch.u[k], uv[2 * i + 1] = batch.v[k];
                              t[i] = batch.t[k];
                              z[i] = rays.depth[k];
                              const Hit hit = hit_of(scene, rays, k);
                              put(rgb, i, hit.surface.radiance);
                              if (!hit.primitive) continue;
                              put(motion, i,
                                  motion_of(scene.camera,
                                            hit.primitive->displacement(rays.a[k], rays.b[k])));
                              put(position, i, hit.position);
                              put(normal, i, hit.normal);
                              put(albedo, i, hit.surface.albedo);
                              alpha[i] = 1;
                              id[i] = std::uint32_t(rays.hit[k]) + 1;
                          }
              });

    Samples samples;
    samples.width = o.width;
    samples.height = o.rows();
    samples.spp = o.spp;
    samples.lens = scene.camera.lens();
    samples.set_size(n);
    samples.add("xy", 2, std::move(xy));
    samples.add("uv", 2, std::move(uv));
    samples.add("t", 1, std::move(t));
    samples.add("z", 1, std::move(z));
    samples.add("motion", 3, std::move(motion));
    samples.add("rgb", 3, std::move(rgb));
    samples.add("alpha", 1, std::move(alpha));
    samples.add("position", 3, std::move(position));
    samples.add("normal", 3, std::move(normal));
    samples.add("albedo", 3, std::move(albedo));
    samples.add_ids("id", std::move(id));
    samples.meta = Json::object();
    samples.meta.set("shutter", Json::list({0.0, 1.0}));
    samples.meta.set("source", fmt::format("analytic:{}, {} spp, seed {}", name, o.spp, o.seed));
    const Camera& c = scene.camera;
    Json camera = Json::object();
    camera.set("world_to_camera", matrix({{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}));
    camera.set("camera_to_pixel",
               matrix({{c.scale, 0, c.center_x}, {0, c.scale, c.center_y}, {0, 0, 1}}));
    samples.meta.set("camera", std::move(camera));
    samples.meta = samples.meta_object();
    return samples;
}

Image analytic_reference(std::string_view name, const AnalyticOptions& o, int spp, Context& ctx) {
    const Entry& entry = entry_of(name);
    check(o, spp);
    const Scene scene = entry.build(o);
    const Tracer tracer(scene, o.width, o.height);
    Image image(o.width, o.rows(), 3);
    image.color_space = "lin_rec709";
    std::vector<Color> sums(size_t(o.width) * size_t(o.rows()));
    const std::uint64_t seed = mix(o.seed ^ 0x5265666572656e63ull);

    for_tiles(tracer, o, seed, spp, ctx,
              [&](const TilePixels& tile, const Batch5& batch, int, int per_pixel) {
                  int k = 0;
                  for (int y = tile.y0; y < tile.y1; ++y)
                      for (int x = tile.x0; x < tile.x1; ++x) {
                          auto& sum = sums[size_t(y - o.first_row) * size_t(o.width) + size_t(x)];
                          for (int s = 0; s < per_pixel; ++s, ++k) {
                              const Hit hit = hit_of(scene, batch.rays, k);
                              sum[0] += double(hit.surface.radiance.x);
                              sum[1] += double(hit.surface.radiance.y);
                              sum[2] += double(hit.surface.radiance.z);
                                    }
                      }
              });
    for (int y = 0; y < o.rows(); ++y)
        for (int x = 0; x < o.width; ++x)
            for (size_t c = 0; c < 3; ++c)
                image.at(x, y)[c] = float(sums[size_t(y) * size_t(o.width) + size_t(x)][c] / spp);
    return image;
}

std::optional<std::array<double, 3>> analytic_exact(std::string_view name, const AnalyticOptions& o,
                                                    int x, int y) {
    const Entry& entry = entry_of(name);
    check(o, o.spp);
    if (!entry.exact) return std::nullopt;
    return entry.exact(o, x, y);
}

}  // namespace weft
