// render-occlusion-rays: from each sample's first hit one ray into the half-space that it faces,
// and how far that gets: what directional occlusion is made of. Directions are spread by the
// cosine.
#include <fmt/format.h>

#include <atomic>

#include "render/diffuse_bsdf.h"
#include "render/keyed_motion.h"
#include "render/shading_frame.h"
#include "render/surface.h"
#include "runtime/node.h"
#include "samples/samplers.h"
#include "samples/samples.h"

namespace weft {
namespace {
using namespace render;

struct RenderOcclusionRays {
    float distance = 0;
    std::uint64_t seed = 1;

    static void declare(Ports<RenderOcclusionRays>& node) {
        node.about("how far a ray gets that leaves each sample's first hit, by the cosine")
            .in<Scene>("scene", "that the samples were rendered from")
            .in<Samples>("samples", "xy, z, position, normal (t)")
            .out<Samples>("samples",
                          "with bounce, the ray's direction, and hit_distance, world units: inf "
                          "where it meets nothing, 0 where there is no hit to start from")
            .param("distance", &RenderOcclusionRays::distance,
                   {.unit = "scene",
                    .min = 0,
                    .max = 1e15,
                    .about = "how far away things still count; 0: any distance"})
            .param("seed", &RenderOcclusionRays::seed, {.about = "of the directions"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"samples", {s.width, s.height, 0, s.records, s.bytes + 16 * double(s.records)}}},
                0,
                1000 * double(s.records)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        Samples samples = in.get<Samples>("samples");
        const Scene& scene = in.get<Scene>("scene");
        samples.require("render-occlusion-rays", {"xy", "z", "position", "normal"});
        if (samples.domain != "camera")
            ctx.fail(
                fmt::format("needs a camera's samples, these are of domain '{}'", samples.domain));
        const RayScene rays(scene, ctx);
        const KeyedMotion camera(scene.camera.to_world);
        const auto z = samples.z(), t = samples.t(), position = samples.values("position"),
                   normal = samples.values("normal");
        std::vector<float> bounce(3 * samples.size()), reached(samples.size());
        const float most = distance > 0 ? distance : INFINITY;
        std::atomic<size_t> done = 0;
        ctx.parallel_rows(
            samples.height,
            [&](Rows rows) {
                const FlushDenormals flush;
                Rays ray;
                ray.resize(64);
                for (int y = rows.begin; y < rows.end; ++y)
                    for (int x = 0; x < samples.width; ++x) {
                        const auto range =
                            samples.of_pixel(size_t(y) * size_t(samples.width) + size_t(x));
                        const int spp = int(range.end - range.begin);
                        if (spp == 0) continue;
                        const SampleSequence numbers =
                            sample_sequence(Sampler::sobol, seed, x, y, spp);
                        for (size_t i = range.begin; i < range.end; ++i) {
                            if (!(z[i] < INFINITY)) continue;
                            const float time = t.empty() ? 0.5f : t[i];
                            const Vec3 at{position[3 * i], position[3 * i + 1],
                                          position[3 * i + 2]};
                            Vec3 n{normal[3 * i], normal[3 * i + 1], normal[3 * i + 2]};
                            if (!(dot(n, n) > 0)) continue;
                            const Vec3 eye = camera.at(time).origin;
                            if (dot(n, eye - at) < 0) n = -n;
                            // The fifth pair: those before are the film's, the lens's, the
                            // shutter's and the light's.
                            const Disk d = numbers(std::uint32_t(i - range.begin), 4);
                            const Vec3 way =
                                unit(ShadingFrame(n).to_world(cosine_direction(d.u, d.v)));
                            const float off = 1e-4f * length(eye - at);
                            ray.set(0, at + n * off, way, 0, most, time, solid_mask | sheer_mask);
                            rays.intersect(ray, 0, 1);
                            bounce[3 * i] = way.x, bounce[3 * i + 1] = way.y,
                                       bounce[3 * i + 2] = way.z;
                            reached[i] = ray.object[0] != no_object ? ray.distance[0] : INFINITY;
                        }
                    }
                ctx.progress(double(done += size_t(rows.end - rows.begin)), samples.height, "rows");
            },
            4);
        samples.add("bounce", 3, std::move(bounce));
        samples.add("hit_distance", 1, std::move(reached));
        samples.meta = samples.meta_object();
        out.set("samples", std::move(samples));
    }
};

WEFT_NODE(RenderOcclusionRays, "render-occlusion-rays", 1)

}  // namespace
}  // namespace weft
