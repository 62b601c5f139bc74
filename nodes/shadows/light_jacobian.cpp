// light-jacobian: how dense the camera's samples are on a light's film, sample by sample.
#include "runtime/node.h"
#include "shadows/camera_samples.h"
#include "shadows/light_jacobian_kernel.h"

namespace weft {
namespace {
using namespace shadows;

struct LightJacobian {
    float max_anisotropy = 16;
    bool metric = true;

    static void declare(Ports<LightJacobian>& node) {
        node.about(
                "how large the camera's pixels are on the light's film, by the receivers' tangent "
                "planes")
            .in<Samples>("samples", "xy, z (uv, t, motion) and geometric_normal, or normal")
            .in<LightView>("light-view", "of the same samples")
            .out<Samples>("samples",
                          "the same and light_density: light pixels a camera pixel; light_metric, "
                          "J J^T of J = dq/dx: xx, xy, yy; "
                          "1 and the unit matrix where nothing was hit")
            .param("max-anisotropy", &LightJacobian::max_anisotropy,
                   {.min = 1,
                    .max = 1e3,
                    .about =
                        "most that a pixel may be stretched or squeezed beyond what distances do"})
            .param("metric", &LightJacobian::metric,
                   {.about = "make light_metric: 12 bytes a sample that searches within a radius "
                             "have no use for"});
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const LightView& view = in.get<LightView>("light-view");
        samples.require("light-jacobian", {"xy", "z"});
        const bool geometric = samples.find("geometric_normal") != nullptr;
        if (!geometric) samples.require("light-jacobian", {"normal"});
        const auto normals = samples.values(geometric ? "geometric_normal" : "normal");
        const CameraSamples from(samples);
        std::vector<float> density(samples.size(), 1), all(metric ? 3 * samples.size() : 0, 0);
        const std::array<Map3, 2> to_light{view.world_to_light[0] * view.pixel_to_world[0],
                                           view.world_to_light[1] * view.pixel_to_world[1]};
        ctx.parallel(samples.size(), 16384, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) {
                if (metric) all[3 * i] = all[3 * i + 2] = 1;
                if (!from.hit(i)) continue;
                const double t = from.time(i);
                const auto mix_of = [&](Point3 a, Point3 b) { return a + (b - a) * t; };
                const Map3 m{mix_of(to_light[0].x, to_light[1].x),
                             mix_of(to_light[0].y, to_light[1].y),
                             mix_of(to_light[0].z, to_light[1].z),
                             mix_of(to_light[0].origin, to_light[1].origin)};
                const auto ends = from.ends(i);
                const Point3 pixel = mix_of(ends[0], ends[1]), p = m.point(pixel);
                if (!(p.z > 0)) continue;
                const Point3 normal = view.world_to_light[0].vector({double(normals[3 * i]),
                                                                     double(normals[3 * i + 1]),
                                                                     double(normals[3 * i + 2])});
                const Jacobian j = light_jacobian(view, m, pixel, normal, double(max_anisotropy));
                density[i] = float(area_of(j));
                if (!metric) continue;
                const auto jj = metric_of(j);
                for (size_t c = 0; c < 3; ++c) all[3 * i + c] = float(jj[c]);
            }
        });
        Samples with = samples;
        with.add("light_density", 1, std::move(density));
        if (metric) with.add("light_metric", 3, std::move(all));
        out.set("samples", std::move(with));
    }
};

WEFT_NODE(LightJacobian, "light-jacobian", 1)

}  // namespace
}  // namespace weft
