// analytic-samples: samples of a built-in scene, which needs no file (analytic_scene.h).
#include "samples/analytic_node.h"
#include "samples/sample_bytes.h"

namespace weft {
namespace {

struct AnalyticSamples : AnalyticNode {
    int spp = 1;

    static void declare(Ports<AnalyticSamples>& node) {
        node.about("samples of a built-in scene: moving, out of focus, with exact depth and motion")
            .out<Samples>("samples",
                          "xy, uv, t, z, motion, rgb, alpha, position, normal, albedo, id")
            .param("spp", &AnalyticSamples::spp,
                   {.unit = "samples", .min = 1, .max = 1 << 20, .about = "samples a pixel"});
        declare_shared(node);
    }

    Cost cost(const Shapes&) const {
        const double samples = double(width) * height * spp;
        constexpr double floats = 2 + 2 + 1 + 1 + 3 + 3 + 1 + 3 + 3 + 3 + 1;
        return {{{"samples", {width, height, 0, std::int64_t(samples), samples * floats * 4}}},
                0,
                samples * 1000};
    }

    void run(const Inputs&, Outputs& out, Context& ctx) const {
        out.set("samples", analytic_samples(scene_name(), options(spp), ctx));
    }

    void piece(const Inputs&, size_t index, ByteWriter& to, Context& ctx) const {
        put_samples(to, analytic_samples(scene_name(), options_of_piece(spp, index), ctx));
    }
    void join(const Pieces& all, Outputs& out, Context&) const { out.set("samples", join_samples(all)); }
};

WEFT_NODE(AnalyticSamples, "analytic-samples", 1);

}  // namespace
}  // namespace weft
