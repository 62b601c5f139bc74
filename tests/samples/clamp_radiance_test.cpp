// clamp-radiance: bounds colours and nothing else.
#include <cmath>
#include <limits>

#include "samples/samples.h"
#include "tests/run_node.h"

namespace weft {
namespace {

TEST(ClampRadiance, bounds_each_colour_and_leaves_what_is_not_finite) {
    constexpr float inf = std::numeric_limits<float>::infinity();
    Samples samples;
    samples.width = 2;
    samples.height = samples.spp = 1;
    samples.set_size(2);
    samples.add("xy", 2, {0.5f, 0.5f, 1.5f, 0.5f});
    samples.add("rgb", 3, {12, 3, -1, inf, NAN, 10});
    const Samples out = RunNode("clamp-radiance").in("samples", samples).out<Samples>("samples");
    const std::vector<float> expected = {10, 3, -1, inf};
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), out.rgb().begin()));
    EXPECT_TRUE(std::isnan(out.rgb()[4]));
    EXPECT_EQ(out.rgb()[5], 10.0f);
    EXPECT_EQ(out.xy()[2], 1.5f);
    EXPECT_EQ(samples.rgb()[0], 12.0f);
}

}  // namespace
}  // namespace weft
