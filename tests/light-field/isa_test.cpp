// Whole pictures by each instruction set: the same but for rounding, and where rounding turns a
// decision (which samples are near, which surface is seen) the other way.
#include <fmt/format.h>

#include <algorithm>

#include "samples/analytic_scene.h"
#include "tests/light-field/light_field_test.h"

namespace weft {
namespace {

Image picture_by(Isa isa, const std::string& file) {
    const PinnedIsa pinned(isa);
    return GraphRun(tlfr_text(file, R"("per-pixel": 32)")).picture;
}

// Differences of two pictures, channel by channel, relative to the values or a hundredth of white.
struct Difference {
    size_t values = 0, turned = 0;  // turned: by more than rounding
    double most = 0;
    Difference(const Image& a, const Image& b) {
        for (size_t i = 0; i < a.pixels().size(); ++i, ++values) {
            const double x = double(a.pixels()[i]), y = double(b.pixels()[i]);
            const double here = std::abs(x - y) / std::max({std::abs(x), std::abs(y), 0.01});
            turned += here > 1e-5;
            most = std::max(most, here);
        }
    }
};

void expect_agreement(const std::string& file, double turned_part, const std::string& what) {
    const Image reference = picture_by(Isa::v2, file);
    for (const Isa isa : instruction_sets()) {
        const Difference d(picture_by(isa, file), reference);
        ASSERT_GT(d.values, 0u);
        EXPECT_LE(double(d.turned), turned_part * double(d.values)) << what << ", v" << int(isa);
        EXPECT_LT(d.most, 0.05) << what << ", v" << int(isa);
        testing::Test::RecordProperty(
            fmt::format("{}_v{}", what, int(isa)),
            fmt::format("{} of {} turned, most {:.2g}", d.turned, d.values, d.most));
    }
}

TEST(InstructionSets, AgreeOnWholePictures) {
    if (instruction_sets().size() < 2)
        GTEST_SKIP() << "this processor has one of the instruction sets only";
    PlainContext ctx;
    for (const char* scene : {"garden", "layers", "disc"}) {
        AnalyticOptions options;
        options.width = 96;
        options.height = 54;
        options.spp = 4;
        const TestFolder folder;
        write_npz(analytic_samples(scene, options, ctx), folder / "samples.npz", false, ctx);
        expect_agreement(folder / "samples.npz", 0.01, scene);
    }
}

}  // namespace
}  // namespace weft
