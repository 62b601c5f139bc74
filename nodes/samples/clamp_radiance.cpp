// clamp-radiance: samples whose colours are no brighter than a bound, each channel for itself: what
// filters that cannot stand fireflies begin with. It takes light away; clamp-outliers, which asks a
// pixel's other samples, can keep it.
#include <algorithm>
#include <cmath>

#include "runtime/node.h"
#include "samples/samples.h"

namespace weft {
namespace {

struct ClampRadiance {
    float most = 10;

    static void declare(Ports<ClampRadiance>& node) {
        node.about("samples whose colours are no brighter than a bound")
            .in<Samples>("samples", "rgb")
            .out<Samples>("samples", "all channels as they were, but rgb")
            .param("most", &ClampRadiance::most,
                   {.unit = "radiance",
                    .min = 0,
                    .max = 1e9,
                    .about = "of red, green and blue, each for itself"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        const double bytes = s.bytes + 12 * double(s.records);
        return {{{"samples", {s.width, s.height, 0, s.records, bytes}}}, 0, 3 * double(s.records)};
    }

    void run(const Inputs& in, Outputs& out, Context&) const {
        Samples samples = in.get<Samples>("samples");
        samples.require("clamp-radiance", {"rgb"});
        std::vector<float> rgb(samples.rgb().begin(), samples.rgb().end());
        for (float& v : rgb)
            if (std::isfinite(v))
                v = std::min(v, most);  // what is not stays, for those who count it
        samples.add("rgb", 3, std::move(rgb));
        out.set("samples", std::move(samples));
    }
};

WEFT_NODE(ClampRadiance, "clamp-radiance", 1)

}  // namespace
}  // namespace weft
