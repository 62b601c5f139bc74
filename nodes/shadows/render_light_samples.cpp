// render-light-samples: for each camera sample a ray from a point of the light towards what the
// camera saw, and the first thing that it meets: one shadow ray a sample (light_samples.h).
#include <atomic>

#include "render/surface.h"
#include "runtime/node.h"
#include "shadows/camera_samples.h"
#include "shadows/light_samples.h"

namespace weft {
namespace {
using namespace shadows;
using namespace render;

struct RenderLightSamples {
    int per_sample = 1;
    std::uint64_t seed = 1;

    static void declare(Ports<RenderLightSamples>& node) {
        node.about(
                "what the light sees along shadow rays to the samples' first hits: the first thing "
                "on each")
            .in<Scene>("scene", "that the samples were rendered from")
            .in<Samples>(
                "samples",
                "xy, z (uv, t, motion); position, if there, is exact where the camera turns")
            .in<LightView>("light-view", "of the same samples")
            .out<Samples>("light-samples", "seen from the light; receivers behind it have none")
            .param("per-sample", &RenderLightSamples::per_sample,
                   {.unit = "rays",
                    .min = 1,
                    .max = 1024,
                    .about = "shadow rays a camera sample, each from another point of the light"})
            .param("seed", &RenderLightSamples::seed, {.about = "of the light's points"});
    }
    Cost cost(const Shapes& in) const {
        const double n = double(in["samples"].records) * per_sample;
        return {{{"light-samples", {0, 0, 0, std::int64_t(n), 52 * n}}}, 0, 1000 * n};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const LightView& view = in.get<LightView>("light-view");
        samples.require("render-light-samples", {"xy", "z"});
        const RayScene rays(in.get<Scene>("scene"), ctx);
        LightSampleArrays made(samples.size() * size_t(per_sample));
        UnseenOfAll all;
        std::atomic<size_t> rows_done = 0;
        ctx.parallel_rows(
            samples.height,
            [&](Rows rows) {
                const FlushDenormals flush;
                Rays ray;
                ray.resize(64);
                Unseen unseen;
                for (int y = rows.begin; y < rows.end; ++y)
                    for (int x = 0; x < samples.width; ++x)
                        trace_pixel(samples, view, rays, x, y, ray, made, unseen);
                all += unseen;
                ctx.progress(double(rows_done += size_t(rows.end - rows.begin)), samples.height,
                             "rows");
            },
            4);
        warn_of(all, view, ctx);
        out.set("light-samples", std::move(made).take(view, samples));
    }

  private:
    void trace_pixel(const Samples& samples, const LightView& view, const RayScene& rays, int x,
                     int y, Rays& ray, LightSampleArrays& made, Unseen& unseen) const {
        const CameraSamples from(samples);
        const auto position = samples.values("position");
        const Samples::Range range =
            samples.of_pixel(size_t(y) * size_t(samples.width) + size_t(x));
        const int count = int(range.end - range.begin) * per_sample;
        for (size_t i = range.begin; i < range.end; ++i) {
            if (!from.hit(i)) continue;
            const double t = from.time(i);
            const auto ends = from.ends(i);
            const Point3 receiver =
                position.empty()
                    ? view.from_camera(ends[0], ends[1], t)
                    : view.from_world(
                          to_double({position[3 * i], position[3 * i + 1], position[3 * i + 2]}),
                          t);
            if (!(receiver.z > view.nearest)) {
                unseen.outside += view.shines_behind() && receiver.z < -view.nearest;
                continue;
            }
            const Vec3 target = to_float(view.to_world(receiver, t));
            for (int r = 0; r < per_sample; ++r) {
                const auto index =
                    std::uint32_t((i - range.begin) * size_t(per_sample) + size_t(r));
                const Disk numbers = light_numbers(seed, x, y, count, index);
                const LightPoint l = view.draw(double(numbers.u), double(numbers.v), receiver);
                LightHit hit{receiver, {}, {}, t, l.lx, l.ly, std::uint32_t(i)};
                const Vec3 origin = to_float(view.to_world(view.start(l, receiver), t));
                const Vec3 way = target - origin;
                const float distance = length(way);
                if (!(distance > 0)) continue;
                // A little farther than the receiver, for its own motion and normal.
                ray.set(0, origin, way * (1 / distance), 1e-4f * distance, (1 + 1e-4f) * distance,
                        float(t), solid_mask | sheer_mask);
                rays.intersect(ray, 0, 1);
                if (ray.object[0] != no_object) take_hit(view, rays, ray, distance, t, hit);
                if (LightSampleArrays::seen(view, hit, unseen))
                    made.set(i * size_t(per_sample) + size_t(r), view, hit);
            }
        }
    }

    static void take_hit(const LightView& view, const RayScene& rays, const Rays& ray,
                         float distance, double t, LightHit& hit) {
        const Object& object = rays.objects()[ray.object[0]];
        const SurfacePoint seen =
            surface_at(object, ray.primitive[0], ray.u[0], ray.v[0], float(t));
        hit.stopped = ray.distance[0] < distance * (1 - 1e-4f);
        if (hit.stopped) hit.at = view.from_world(to_double(seen.position), t);
        const Point3 tip = view.from_world(to_double(seen.position + seen.geometric), t),
                     foot = view.from_world(to_double(seen.position), t);
        hit.normal = tip - foot;
        const auto at = [&](float time) {
            return view.from_world(
                to_double(position_at(object, ray.primitive[0], ray.u[0], ray.v[0], time)),
                double(time));
        };
        if (object.moving() || view.moves) hit.motion = at(1) - at(0);
    }
};

WEFT_NODE(RenderLightSamples, "render-light-samples", 1)

}  // namespace
}  // namespace weft
