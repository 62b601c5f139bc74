// How near does the renderer come to what Embree itself traces?
//   bench_render [SCENE...] [--rays N] [--repeat N] [--spp N] [--width N] [--height N]
// For each built-in scene (all by default), on one thread, the same rays through the renderer's tracing and
// through a bare loop over Embree:
//   primary      from the camera over lens and shutter, a pixel's 16 together: packets, and one by one
//   shadow       from where those hit to points of the lights
//   incoherent   from where those hit into the hemisphere, by the cosine
// as millions of rays a second (median of --repeat runs) and their ratio; then a whole render: samples and
// rays a second, and where its time goes.
#include <embree3/rtcore.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "bench/cpu_time.h"
#include "render/path_tracer.h"
#include "render/procedural_scene.h"
#include "render/surface.h"
#include "samples/random.h"

namespace {

using namespace weft;
using namespace weft::render;

struct Options {
    std::vector<std::string> scenes;
    size_t rays = 1 << 19;
    int repeat = 5, spp = 16, width = 480, height = 270;
};

// Seconds of each work, taken in turns so that a busy machine slows all alike: medians.
std::vector<double> timed(int repeat, const std::vector<std::function<void()>>& works) {
    std::vector<std::vector<double>> took(works.size());
    for (int r = 0; r < repeat; ++r)
        for (size_t i = 0; i < works.size(); ++i) {
            const double start = cpu_s();
            works[i]();
            took[i].push_back(cpu_s() - start);
        }
    std::vector<double> medians;
    for (std::vector<double>& of : took) {
        std::sort(of.begin(), of.end());
        medians.push_back(of[of.size() / 2]);
    }
    return medians;
}

// The bare library: rays and hits lie as Embree wants them, nothing is read back.
RTCRayHit bare_ray(const Rays& rays, size_t i) {
    RTCRayHit r{};
    r.ray = {rays.ox[i], rays.oy[i],   rays.oz[i],  rays.near[i], rays.dx[i], rays.dy[i],
             rays.dz[i], rays.time[i], rays.far[i], rays.mask[i], 0,          0};
    r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return r;
}
struct Bare {
    std::vector<RTCRayHit> fresh, rays;
    std::vector<RTCRayHit16> fresh16, rays16;
    explicit Bare(const Rays& from, size_t n) {
        for (size_t i = 0; i < n; ++i) fresh.push_back(bare_ray(from, i));
        for (size_t i = 0; i + 16 <= n; i += 16) {
            RTCRayHit16 p{};
            for (size_t k = 0; k < 16; ++k) {
                const RTCRay& r = fresh[i + k].ray;
                p.ray.org_x[k] = r.org_x, p.ray.org_y[k] = r.org_y, p.ray.org_z[k] = r.org_z;
                p.ray.dir_x[k] = r.dir_x, p.ray.dir_y[k] = r.dir_y, p.ray.dir_z[k] = r.dir_z;
                p.ray.tnear[k] = r.tnear, p.ray.tfar[k] = r.tfar, p.ray.time[k] = r.time, p.ray.mask[k] = r.mask;
                p.hit.geomID[k] = p.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
            }
            fresh16.push_back(p);
        }
    }
    void reset() { rays = fresh, rays16 = fresh16; }
};

RTCIntersectContext context_of(RTCIntersectContextFlags flags) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = flags;
    return context;
}

// Rays that stand for what a path tracer asks.
struct Kinds {
    Rays primary, shadow, incoherent;
    size_t primaries = 0, shadows = 0, bounces = 0;
};
Kinds make_rays(const PathTracer& tracer, const Options& o) {
    Kinds kinds;
    const RayScene& scene = tracer.rays();
    const size_t most = o.rays / 16 * 16;
    for (Rays* rays : {&kinds.primary, &kinds.shadow, &kinds.incoherent}) rays->resize(most);
    std::uint64_t key = 1;
    const auto number = [&] { return unit_float(key = mix(key)); };
    const float infinity = std::numeric_limits<float>::infinity();
    const size_t pixels = size_t(o.width) * size_t(o.height);
    for (size_t i = 0; i < most; ++i) {
        const size_t pixel = i / 16 * pixels / (most / 16);
        const Disk lens = concentric_disk(number(), number());
        const float x = float(pixel % size_t(o.width)) + number(), y = float(pixel / size_t(o.width)) + number(), time = number();
        const Camera::Ray r = tracer.camera().ray(x, y, lens.u, lens.v, time);
        kinds.primary.set(i, r.origin, r.direction, 0, infinity, time, every_mask);
    }
    kinds.primaries = most;
    scene.intersect(kinds.primary, 0, most);
    for (size_t i = 0; i < most; ++i) {
        const std::uint32_t object = kinds.primary.object[i];
        if (object == no_object || tracer.lights().is_light(object)) continue;
        const float time = kinds.primary.time[i];
        const SurfacePoint at = surface_at(scene.objects()[object], kinds.primary.primitive[i], kinds.primary.u[i], kinds.primary.v[i], time);
        const Vec3 n = dot(at.geometric, kinds.primary.direction(i)) < 0 ? at.geometric : -at.geometric;
        const LightSample light = tracer.lights().sample(at.position, time, number(), number(), number());
        if (light.density > 0 && dot(n, light.direction) > 0)
            kinds.shadow.set(kinds.shadows++, offset_origin(at.position, n, at.error, light.direction), light.direction, 0,
                             light.distance * 0.999f, time, every_mask & ~light_mask);
        const float z = 2 * number() - 1, around = 6.2831853f * number(), across = std::sqrt(std::max(0.0f, 1 - z * z));
        const Vec3 sum = n + Vec3{across * std::cos(around), across * std::sin(around), z};
        if (dot(sum, sum) < 1e-6f) continue;
        const Vec3 way = unit(sum);
        kinds.incoherent.set(kinds.bounces++, offset_origin(at.position, n, at.error, way), way, 0, infinity, time, every_mask);
    }
    return kinds;
}

void row(const char* what, size_t rays, double ours, double bare) {
    fmt::print("  {:<24} {:8.2f} {:8.2f} {:7.0f} %\n", what, double(rays) / ours * 1e-6, double(rays) / bare * 1e-6, 100 * bare / ours);
}

void measure_tracing(const PathTracer& tracer, const Options& o) {
    const RayScene& scene = tracer.rays();
    const auto world = static_cast<RTCScene>(scene.embree_scene());
    Kinds kinds = make_rays(tracer, o);
    RTCIntersectContext side_by_side = context_of(RTC_INTERSECT_CONTEXT_FLAG_COHERENT), scattered = context_of(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
    fmt::print("  {:<24} {:>8} {:>8} {:>9}\n", "Mrays/s", "ours", "bare", "ours/bare");
    alignas(64) int valid[16];
    std::fill(valid, valid + 16, -1);
    const auto one_by_one = [&](Rays& rays, size_t n, const char* what) {
        Bare bare(rays, n);
        const double copy = timed(o.repeat, {[&] { bare.rays = bare.fresh; }})[0];
        const auto took = timed(o.repeat, {[&] { scene.intersect(rays, 0, n); }, [&] {
                                               bare.rays = bare.fresh;
                                               for (RTCRayHit& r : bare.rays) rtcIntersect1(world, &scattered, &r);
                                           }});
        row(what, n, took[0], took[1] - copy);
    };
    {
        Bare bare(kinds.primary, kinds.primaries);
        const double copy = timed(o.repeat, {[&] { bare.rays16 = bare.fresh16; }})[0];
        const auto took = timed(o.repeat, {[&] {
                                               for (size_t i = 0; i < kinds.primaries; i += 16) scene.intersect_packet(kinds.primary, i, i + 16);
                                           },
                                           [&] {
                                               bare.rays16 = bare.fresh16;
                                               for (RTCRayHit16& p : bare.rays16) rtcIntersect16(valid, world, &side_by_side, &p);
                                           }});
        row("primary, in packets", kinds.primaries, took[0], took[1] - copy);
    }
    one_by_one(kinds.primary, kinds.primaries, "primary, one by one");
    if (kinds.shadows > 0) {
        Bare bare(kinds.shadow, kinds.shadows);
        const double copy = timed(o.repeat, {[&] { bare.rays = bare.fresh; }})[0];
        const auto took = timed(o.repeat, {[&] { scene.occluded(kinds.shadow, 0, kinds.shadows); }, [&] {
                                               bare.rays = bare.fresh;
                                               for (RTCRayHit& r : bare.rays) rtcOccluded1(world, &scattered, &r.ray);
                                           }});
        row("shadow", kinds.shadows, took[0], took[1] - copy);
    }
    if (kinds.bounces > 0) one_by_one(kinds.incoherent, kinds.bounces, "incoherent");
}

void measure_render(const PathTracer& tracer, const Options& o) {
    PathWorkspacePointer workspace = tracer.workspace();
    SampleBatch batch;
    std::vector<PixelRun> runs;
    for (int y = 0; y < o.height; ++y) {
        runs.clear();
        for (int x = 0; x < o.width; ++x) runs.push_back({x, y, 0, std::uint32_t(o.spp), o.spp});
        for (size_t i = 0; i < runs.size(); i += 32)
            tracer.render(std::span(runs).subspan(i, std::min<size_t>(32, runs.size() - i)), *workspace, batch);
    }
    const RenderStatistics& s = PathTracer::statistics(*workspace);
    const double all = double(s.all_ns), rays = double(s.camera_rays + s.path_rays + s.shadow_rays);
    const double tracing = double(s.camera_ns + s.path_ns + s.shadow_ns), texture = double(s.texture_ns);
    fmt::print("  render, {} spp: {:.2f} M samples/s, {:.2f} Mrays/s in all, {:.2f} Mrays/s while tracing, {:.1f} rays a sample\n",
               o.spp, double(s.samples) / all * 1e3, rays / all * 1e3, rays / tracing * 1e3, rays / double(s.samples));
    fmt::print("  time: tracing {:.0f} % (camera {:.0f}, path {:.0f}, shadow {:.0f}), texture {:.0f} %, shading and output {:.0f} %\n",
               100 * tracing / all, 100 * double(s.camera_ns) / all, 100 * double(s.path_ns) / all, 100 * double(s.shadow_ns) / all,
               100 * texture / all, 100 * (all - tracing - texture) / all);
}

}  // namespace

int main(int argc, char** argv) try {
    Options o;
    for (int i = 1; i < argc; ++i) {
        const std::string key = argv[i];
        const auto value = [&] { return i + 1 < argc ? std::max(1, std::atoi(argv[++i])) : 1; };
        if (key == "--rays") o.rays = size_t(std::max(16, value()));
        else if (key == "--repeat") o.repeat = value();
        else if (key == "--spp") o.spp = value();
        else if (key == "--width") o.width = value();
        else if (key == "--height") o.height = value();
        else if (key.starts_with("--")) return fmt::print(stderr, "unknown option {}\n", key), 2;
        else o.scenes.push_back(key);
    }
    if (o.scenes.empty()) o.scenes = procedural_scene_names();
    const FlushDenormals flush;
    for (const std::string& name : o.scenes) {
        PlainContext ctx;
        const Scene scene = procedural_scene(name);
        RenderOptions options;
        options.width = o.width;
        options.height = o.height;
        const double start = cpu_s();
        const PathTracer tracer(scene, options, ctx);
        fmt::print("{}: {} triangles, {} placed, {}; made ready in {:.2f} s\n", name, scene.triangles(), scene.placed_triangles(),
                   tracer.has_motion() ? "moving" : "still", cpu_s() - start);
        measure_tracing(tracer, o);
        measure_render(tracer, o);
    }
} catch (const std::exception& e) {
    fmt::print(stderr, "bench_render: {}\n", e.what());
    return 1;
}
