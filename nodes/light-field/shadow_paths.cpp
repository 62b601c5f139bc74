// shadow-paths: how far shadows may move over a picture while the shutter is open, block by block, for
// the spacing of output-locations. A light sample was sent to a sample of the picture, and on that way
// stopped by something: so far as this moves, a shadow does there.
#include <algorithm>
#include <cmath>

#include "image/image.h"
#include "light-field/points.h"
#include "runtime/node.h"
#include "samples/samples.h"

namespace weft {
namespace {

struct ShadowPaths {
    static void declare(Ports<ShadowPaths>& node) {
        node.about("the longest way that anything goes that shadow rays to a block of the picture met")
            .in<Samples>("shadows", "light samples: xy, z and source, motion if anything moves")
            .in<Samples>("samples", "those of the camera that the rays were sent to")
            .out<Image>("paths", "Y: px of the light's film, which are about those of the picture; a pixel for each 32 x 32 of these");
    }
    void run(const Inputs& in, Outputs& out, Context&) const {
        const Samples &shadows = in.get<Samples>("shadows"), &samples = in.get<Samples>("samples");
        shadows.require("shadow-paths", {"xy", "z", "source"});
        samples.require("shadow-paths", {"xy"});
        using light_field::blocks_across;
        Image paths(blocks_across(samples.width), blocks_across(samples.height), 1);
        const auto seen = samples.xy(), xy = shadows.xy(), z = shadows.z(), motion = shadows.motion();
        const auto& source = shadows.find("source")->ids;
        const auto block = [](float at, int count) { return std::clamp(int(at) / light_field::location_block, 0, count - 1); };
        for (size_t i = 0; shadows.has_motion() && i < shadows.size(); ++i) {
            const float x = motion[3 * i] - xy[2 * i] * motion[3 * i + 2],
                        y = motion[3 * i + 1] - xy[2 * i + 1] * motion[3 * i + 2];
            const size_t to = source[i];
            if (2 * to + 1 >= seen.size()) throw Error("'shadows' were sent to other samples; link those that they were made of");
            float& path = *paths.at(block(seen[2 * to], paths.width()), block(seen[2 * to + 1], paths.height()));
            path = std::max(path, std::sqrt(x * x + y * y) / z[i]);
        }
        out.set("paths", std::move(paths));
    }
};

WEFT_NODE(ShadowPaths, "shadow-paths", 1)

}  // namespace
}  // namespace weft
