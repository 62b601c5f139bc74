// read-samples: a renderer's sample buffer from a file, its values checked; or, for a file called
// analytic:NAME, one sample a pixel of a built-in scene.
#include "runtime/node.h"
#include "samples/analytic_scene.h"
#include "samples/sample_file.h"
#include "samples/sample_shape.h"
#include "samples/samples.h"

namespace weft {
namespace {

struct ReadSamples {
    InputFile file{"analytic:garden"};
    std::vector<std::string> channels;
    float tolerate = 0.01f;

    static void declare(Ports<ReadSamples>& node) {
        node.about(
                "reads a renderer's sample buffer: .npz (native), deep EXR, TLFR 1.3 or ILFR 2.2, "
                "told apart by content. Reads the basic channels xy uv t z motion rgb alpha weight "
                "z_gradient, and those listed in 'channels': what is not asked for costs nothing")
            .out<Samples>("samples", "the buffer; unusable samples are dropped with a warning")
            .param("file", &ReadSamples::file,
                   {.about = "sample file, or analytic:NAME, a built-in scene at 640 x 360 with "
                             "one sample a pixel (analytic-samples has more to choose)"})
            .param("channels", &ReadSamples::channels,
                   {.about =
                        "channels to read beside the basic ones; \"*\" reads all. A standard name "
                        "(normal, albedo ...) that the file lacks is passed over"})
            .param("tolerate", &ReadSamples::tolerate,
                   {.min = 0,
                    .max = 1,
                    .about = "part of the samples that may have an unusable depth, position, lens "
                             "position or time before it is an error"});
    }

    static constexpr std::string_view built_in = "analytic:";

    Cost cost(const Shapes&) const {
        if (file.path.starts_with(built_in)) {
            const AnalyticOptions options;
            const double samples = double(options.width) * options.height * options.spp;
            return {{{"samples",
                      {options.width, options.height, 0, std::int64_t(samples), 96 * samples}}}};
        }
        return {{{"samples", sample_shape(map_file(file.path), {channels, tolerate})}}};
    }

    void run(const Inputs&, Outputs& out, Context& ctx) const {
        if (file.path.starts_with(built_in)) {
            out.set("samples", analytic_samples(file.path.substr(built_in.size()), {}, ctx));
            return;
        }
        out.set("samples", read_sample_file(map_file(file.path), {channels, tolerate}, ctx));
    }
};

WEFT_NODE(ReadSamples, "read-samples", 1)

}  // namespace
}  // namespace weft
