// slope-tensors: around each sample, a distance in which the way is short that its surface point
// takes over lens and shutter: known from motion and depth, where structure-tensors has to
// estimate. Wrong for shading that does not move with its surface: shadows, highlights,
// reflections.
#include <cmath>

#include "adaptive/metrics.h"
#include "adaptive/near_samples.h"
#include "adaptive/symmetric.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace adaptive;

struct SlopeTensors {
    float trust = 0.98f;

    static void declare(Ports<SlopeTensors>& node) {
        node.about(
                "a distance around each sample that is short along its trajectory over lens and "
                "shutter")
            .in<Samples>("samples", "xy, z; with t motion, with uv a lens")
            .in<LeafTree>("leaves", "axes and their scales; else from the samples", Need::optional)
            .out<Metrics>("tensors", "of each sample")
            .param("trust", &SlopeTensors::trust,
                   {.min = 0,
                    .max = 1,
                    .about = "how little distance along the trajectory counts: 1 not at all"});
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        samples.require("slope-tensors", {"xy", "z"});
        Metrics metrics = metrics_over(samples, in.find<LeafTree>("leaves"), "slope-tensors");
        const std::vector<std::string>& axes = metrics.space.axes;
        for (const std::string& axis : axes) {
            if (axis == "t" && samples.motion().empty())
                ctx.fail(
                    "this buffer has t but no motion; render it with motion, or use "
                    "structure-tensors");
            if (axis == "u" && !samples.lens)
                ctx.fail(
                    "this buffer has uv but says nothing of its lens; add it to meta, or use "
                    "structure-tensors");
        }
        metrics.upper.resize(metrics.numbers() * metrics.size());
        ctx.parallel_for(
            metrics.size(),
            [&](size_t i) {
                fill(samples, metrics, metrics.tree->order()[i],
                     &metrics.upper[metrics.numbers() * i]);
            },
            4096);
        metrics.supports = supports_of(*metrics.tree, ctx);
        out.set("tensors", std::move(metrics));
    }

  private:
    // |r|^2 + (1 - trust) (all other axes)^2, with r = (dx, dy) - the way over these axes.
    void fill(const Samples& samples, const Metrics& metrics, size_t sample, float* upper) const {
        const size_t n = metrics.dimensions();
        const float x = samples.xy()[2 * sample], y = samples.xy()[2 * sample + 1],
                    z = samples.z()[sample];
        Matrix m{};
        // Rows of r: its derivative along each axis.
        std::array<double, most_axes> rx{}, ry{};
        rx[0] = ry[1] = 1;
        for (size_t d = 2; d < n; ++d) {
            const std::string& axis = metrics.space.axes[d];
            const double extent = double(metrics.space.extent[d]);
            const bool known = axis == "t" || axis == "u" || axis == "v";
            m[d][d] = known ? 1 - double(trust) : 1;
            if (axis == "t" && std::isfinite(z)) {
                const float* motion = &samples.motion()[3 * sample];
                rx[d] = -double((motion[0] - x * motion[2]) / z) / extent;
                ry[d] = -double((motion[1] - y * motion[2]) / z) / extent;
            }
            // The disk's diameter is the axis' extent.
            const double coc = samples.lens ? double(samples.lens->c0 / z + samples.lens->c1) : 0;
            if (axis == "u") rx[d] = -2 * double(samples.lens->aspect) * coc / extent;
            if (axis == "v") ry[d] = -2 * coc / extent;
        }
        for (size_t a = 0; a < n; ++a)
            for (size_t b = a; b < n; ++b)
                *upper++ = float(m[a][b] + rx[a] * rx[b] + ry[a] * ry[b]);
    }
};

WEFT_NODE(SlopeTensors, "slope-tensors", 3)

}  // namespace
}  // namespace weft
