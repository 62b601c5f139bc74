// light-samples-from-file: light samples of the shadow rays that a renderer recorded, without its
// scene: shadow_hit, the first thing that the light sees along a sample's own shadow ray, from
// light_point, or point light_uv of a quad or a disc.
#include <fmt/format.h>

#include <atomic>
#include <cmath>

#include "runtime/node.h"
#include "samples/file_bytes.h"
#include "shadows/camera_samples.h"
#include "shadows/light_samples.h"

namespace weft {
namespace {
using namespace shadows;

struct LightSamplesFromFile {
    static void declare(Ports<LightSamplesFromFile>& node) {
        node.about(
                "what the light saw along shadow rays that a renderer recorded: one a sample, no "
                "scene needed")
            .in<Samples>("samples",
                         "xy, z, shadow_hit, light_point, or light_uv of a quad or a disc (uv, t, "
                         "motion, shadow_normal, shadow_motion; light_index where there are "
                         "several lights)")
            .in<LightView>("light-view", "of the same samples")
            .out<Samples>("light-samples",
                          "seen from the light; samples of other lights, of the background and "
                          "those that face away have none");
    }
    Cost cost(const Shapes& in) const {
        const double n = double(in["samples"].records);
        return {{{"light-samples", {0, 0, 0, std::int64_t(n), 52 * n}}}, 0, 100 * n};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const LightView& view = in.get<LightView>("light-view");
        samples.require("light-samples-from-file", {"xy", "z", "shadow_hit"});
        const bool points = samples.find("light_point") != nullptr;
        if (!points) samples.require("light-samples-from-file", {"light_uv"});
        if (!points && (!view.same_points() || view.shape == LightView::Shape::mesh))
            ctx.fail(
                fmt::format("light '{}' is a ball or a mesh, whose points light_uv does not name; "
                            "expected light_point, which render-samples writes on demand (channels)",
                            view.name));
        const Channel* index = samples.find("light_index");
        const Recorded from(samples);
        LightSampleArrays made(samples.size());
        std::atomic<size_t> all = 0, hits = 0, kept = 0;
        UnseenOfAll all_unseen;
        ctx.parallel(samples.size(), 16384, [&](size_t begin, size_t end) {
            size_t any = 0, there = 0, taken = 0;
            Unseen unseen;
            for (size_t i = begin; i < end; ++i) {
                if (!from.camera.hit(i)) continue;
                ++any;
                if (index && index->ids[i] != view.light) continue;
                ++there;
                LightHit hit;
                if (!from.read(view, i, hit) || !LightSampleArrays::seen(view, hit, unseen)) continue;
                ++taken;
                made.set(i, view, hit);
            }
            all += any, hits += there, kept += taken, all_unseen += unseen;
        });
        if (kept == 0 && hits > 0)
            ctx.fail(
                fmt::format("none of {} shadow_hit lies between light '{}' and what its "
                            "sample shows; expected world positions on the ray from {}",
                            size_t(hits), view.name, points ? "light_point" : "light_uv"));
        warn_of(all_unseen, view, ctx);
        // What only this node asks for, as a rule.
        for (const char* channel : {"shadow_hit", "light_point", "light_uv", "shadow_normal", "shadow_motion"})
            forget_pages(samples.values(channel));
        const double part = all > 0 && hits > 0 ? double(hits) / double(all) : 1;
        out.set("light-samples", std::move(made).take(view, samples, part));
    }

  private:
    struct Recorded {
        explicit Recorded(const Samples& s)
            : camera(s),
              hit(s.values("shadow_hit")),
              light_point(s.values("light_point")),
              light_uv(s.values("light_uv")),
              normal(s.values("shadow_normal")),
              motion(s.values("shadow_motion")) {}
        CameraSamples camera;
        std::span<const float> hit, light_point, light_uv, normal, motion;

        static Point3 at(std::span<const float> values, size_t i) {
            return {double(values[3 * i]), double(values[3 * i + 1]), double(values[3 * i + 2])};
        }
        // False where the hit does not lie on the ray: none was recorded.
        bool read(const LightView& view, size_t i, LightHit& out) const {
            const double t = camera.time(i);
            const auto ends = camera.ends(i);
            const Point3 receiver = view.from_camera(ends[0], ends[1], t);
            if (!(receiver.z > view.nearest)) return false;
            const LightPoint l =
                light_point.empty()
                    ? view.draw(double(light_uv[2 * i]), double(light_uv[2 * i + 1]), receiver)
                    : view.seen_through(view.from_world(at(light_point, i), t), receiver);
            const Point3 world = at(hit, i), seen = view.from_world(world, t);
            const Point3 from = view.start(l, receiver), ray = receiver - from, way = seen - from;
            const double along = dot(way, ray) / dot(ray, ray);
            const Point3 aside = way - ray * along;
            if (!(along > 0 && along < 1 + 1e-3) || !(dot(aside, aside) < 1e-6 * dot(ray, ray)))
                return false;
            out = {seen, {}, {}, t, l.lx, l.ly, std::uint32_t(i)};
            if (!normal.empty()) out.normal = view.from_world(world + at(normal, i), t) - seen;
            const Point3 gap = seen - receiver;
            if (dot(gap, gap) < 1e-8 * dot(ray, ray)) {
                // The receiver itself, which moves as the camera saw it do.
                out.at = receiver;
                out.motion =
                    view.from_camera(ends[0], ends[1], 1) - view.from_camera(ends[0], ends[1], 0);
                return true;
            }
            out.stopped = true;
            const Point3 whole = motion.empty() ? Point3{} : at(motion, i),
                         open = world - whole * t;
            if (!motion.empty() || view.moves)
                out.motion = view.from_world(open + whole, 1) - view.from_world(open, 0);
            return true;
        }
    };
};

WEFT_NODE(LightSamplesFromFile, "light-samples-from-file", 1)

}  // namespace
}  // namespace weft
