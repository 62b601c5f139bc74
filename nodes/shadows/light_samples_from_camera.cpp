// light-samples-from-camera: light samples where neither the scene nor its shadow rays are at hand:
// the camera's own first hits, each as if the light saw it. What the camera does not see casts no
// shadow.
#include <atomic>

#include "runtime/node.h"
#include "shadows/camera_samples.h"
#include "shadows/light_samples.h"

namespace weft {
namespace {
using namespace shadows;

struct LightSamplesFromCamera {
    std::uint64_t seed = 1;

    static void declare(Ports<LightSamplesFromCamera>& node) {
        node.about(
                "takes the camera's first hits for what the light sees: needs no scene, and knows "
                "no occluder that the camera does not see")
            .in<Samples>("samples", "xy, z (uv, t, motion); geometric_normal for slopes")
            .in<LightView>("light-view", "of the same samples")
            .out<Samples>("light-samples", "one a sample in front of the light")
            .param("seed", &LightSamplesFromCamera::seed, {.about = "of the light's points"});
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const LightView& view = in.get<LightView>("light-view");
        samples.require("light-samples-from-camera", {"xy", "z"});
        const CameraSamples from(samples);
        const auto normals = samples.values("geometric_normal");
        LightSampleArrays made(samples.size());
        UnseenOfAll all;
        ctx.parallel_rows(samples.height, [&](Rows rows) {
            Unseen unseen;
            const size_t wide = size_t(samples.width);
            for (size_t pixel = size_t(rows.begin) * wide; pixel < size_t(rows.end) * wide;
                 ++pixel) {
                const Samples::Range range = samples.of_pixel(pixel);
                for (size_t i = range.begin; i < range.end; ++i) {
                    if (!from.hit(i)) continue;
                    const double t = from.time(i);
                    const auto ends = from.ends(i);
                    LightHit hit{view.from_camera(ends[0], ends[1], t), {}, {}, t};
                    if (!(hit.at.z > view.nearest)) {
                        unseen.outside += view.shines_behind() && hit.at.z < -view.nearest;
                        continue;
                    }
                    const Disk numbers =
                        light_numbers(seed, int(pixel % wide), int(pixel / wide),
                                      int(range.end - range.begin), std::uint32_t(i - range.begin));
                    const auto l = view.point(double(numbers.u), double(numbers.v), hit.at);
                    hit.lx = l[0], hit.ly = l[1];
                    hit.source = std::uint32_t(i);
                    hit.motion = view.from_camera(ends[0], ends[1], 1) -
                                 view.from_camera(ends[0], ends[1], 0);
                    if (!normals.empty())
                        hit.normal = view.world_to_light[0].vector({double(normals[3 * i]),
                                                                    double(normals[3 * i + 1]),
                                                                    double(normals[3 * i + 2])});
                    if (LightSampleArrays::seen(view, hit, unseen)) made.set(i, view, hit);
                }
            }
            all += unseen;
        });
        warn_of(all, view, ctx);
        out.set("light-samples", std::move(made).take(view, samples));
    }
};

WEFT_NODE(LightSamplesFromCamera, "light-samples-from-camera", 1)

}  // namespace
}  // namespace weft
