// Filters from picture to picture on renderers' samples: closer to the reference than the plain
// mean of the samples, with their defaults, and as bright.
#include <gtest/gtest.h>

#include <filesystem>

#include "image/measures.h"
#include "image/picture_file.h"
#include "samples/sample_file.h"
#include "tests/run_node.h"

namespace weft {
namespace {

class RealSamples : public testing::TestWithParam<const char*> {};

double brightness(const Image& image) {
    double sum = 0;
    for (const float v : image.pixels()) sum += double(v);
    return sum;
}

TEST_P(RealSamples, filters_beat_the_box_and_keep_the_light) {
    const std::string folder =
        (std::filesystem::path(WEFT_SOURCE_DIR).parent_path() / "shared" / "data" / GetParam())
            .string();
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no samples of " << GetParam();
    PlainContext ctx;
    const Image reference = read_picture(folder + "/reference.exr");
    for (const char* file : {"/s01.npz", "/s08.npz"}) {
        const Samples samples = read_sample_file(map_file(folder + file), {{"*"}, 0.01f}, ctx);
        RunNode node("pixel-features");
        node.in("samples", samples);
        const TypeInfo* image = &type_info<Image>();
        Image color, noise, features, features_noise;
        node.run({{"color", image, &color, {}},
                  {"color-variance", image, &noise, {}},
                  {"features", image, &features, {}},
                  {"features-variance", image, &features_noise, {}}});
        const double box = compare_pictures(color, reference, ctx).measures.rel_mse;
        for (const char* type : {"non-local-means", "cross-bilateral-image", "a-trous"}) {
            RunNode filter(type);
            filter.in("image", color).in("variance", noise);
            if (type != std::string("non-local-means"))
                filter.in("features", features).in("features-variance", features_noise);
            const Image picture = filter.out<Image>("image");
            EXPECT_LT(compare_pictures(picture, reference, ctx).measures.rel_mse, 0.35 * box)
                << type << file;
            // Bright samples that are alone are unlike all others: some of their light is lost.
            EXPECT_NEAR(brightness(picture) / brightness(color), 1,
                        samples.mean_spp() < 2 ? 0.05 : 0.01)
                << type << file;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, RealSamples, testing::Values("killeroos", "buddhas", "bmw"));

}  // namespace
}  // namespace weft
