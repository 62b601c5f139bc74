// compare: error measures of pictures against a reference, a row each, and where the first one
// errs. Measures: image/measures.h.
#include <fmt/format.h>

#include "image/image_cost.h"
#include "image/measures.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct Compare {
    ErrorKind error = ErrorKind::flip;
    float range = 1;

    static void declare(Ports<Compare>& node) {
        node.about("RMSE, relMSE, PSNR, SSIM and FLIP of pictures against a reference")
            .in<Image>("image", "pictures to judge, named by the nodes they come from",
                       Need::variadic)
            .in<Image>("reference", "the true picture, of the same size and colour space")
            .in<Image>("where",
                       "first channel: what a pixel counts for rmse and relmse; unset: all alike",
                       Need::optional)
            .out<Table>("table", "a row a picture: rmse, relmse, psnr (dB), ssim, flip")
            .out<Image>("error", "where the first picture errs, in false colour, sRGB")
            .choice("error", &Compare::error, {"flip", "relative", "absolute"},
                    {.about = "what the error picture shows"})
            .param("range", &Compare::range, {.min = 1e-6, .about = "error shown brightest"});
    }

    Cost cost(const Shapes& in) const { return cost_like(in, "reference", "error", 3, 34, 1500); }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image& reference = in.get<Image>("reference");
        const std::vector<const Image*> images = in.all<Image>("image");
        const std::vector<std::string>& names = in.names("image");
        const Image* where = in.find<Image>("where");
        Table table = measures_table();
        for (size_t i = 0; i < images.size(); ++i) {
            const std::string name = i < names.size() ? names[i] : fmt::format("{}", i + 1);
            try {
                Comparison found =
                    compare_pictures(*images[i], reference, ctx, error, range, where);
                add_row(table, name, found.measures);
                if (i == 0 && out.wanted("error")) out.set("error", std::move(found.error));
            } catch (const Error& e) {
                ctx.fail(fmt::format("'{}': {}", name, e.what()));
            }
        }
        if (out.wanted("table")) out.set("table", std::move(table));
    }
};

WEFT_NODE(Compare, "compare", 1);

}  // namespace
}  // namespace weft
