// preserve-energy: a picture has its samples' energy afterwards, and where it had it already it
// stays as it was.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "filters/pictures.h"
#include "tests/run_node.h"

namespace weft {
namespace {

// A dim picture with one blob of light in its middle: as samples have it, and as a reconstruction
// made it that kept `kept` of that light.
struct Blob {
    int width = 96, height = 80;
    float background = 0.1f, light = 40, deviation = 2;

    Image picture(float kept, float shift = 0) const {
        return make_picture(width, height, {"R", "G", "B"}, [&](int x, int y, int c) {
            const float dx = float(x) - 48 - shift, dy = float(y) - 40;
            const float blob = light * std::exp(-(dx * dx + dy * dy) / (2 * deviation * deviation));
            return background + (c == 0 ? 1.0f : 0.5f) * kept * blob;
        });
    }
    Image means(float spp) const {
        const Image as_is = picture(1);
        return make_picture(width, height, {"R", "G", "B", "samples"},
                            [&](int x, int y, int c) { return c < 3 ? as_is.at(x, y)[c] : spp; });
    }
    double light_of(const Image& image, int channel) const {
        double sum = 0;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                sum += double(image.at(x, y)[channel]) - double(background);
        return sum;
    }
};

Image with_energy(const Image& image, const Image& means) {
    return RunNode("preserve-energy").in("image", image).in("means", means).out<Image>("image");
}

TEST(PreserveEnergy, BringsBackWhatAHighlightLostAndTakesWhatItGained) {
    const Blob blob;
    for (const float spp : {1.0f, 4.0f, 8.0f, 64.0f})
        for (const float kept : {0.5f, 0.8f, 1.3f})
            for (const float shift : {0.0f, 1.0f}) {
                const Image after = with_energy(blob.picture(kept, shift), blob.means(spp));
                for (const int c : {0, 2})
                    EXPECT_NEAR(blob.light_of(after, c) / blob.light_of(blob.picture(1), c), 1,
                                0.01)
                        << spp << " spp, kept " << kept << ", shifted " << shift;
            }
}

TEST(PreserveEnergy, LeavesAPictureThatHasIt) {
    const Blob blob;
    const Image before = blob.picture(1), after = with_energy(before, blob.means(4));
    for (size_t i = 0; i < before.pixels().size(); ++i)
        EXPECT_NEAR(after.pixels()[i], before.pixels()[i], 1e-4f * before.pixels()[i]);
}

TEST(PreserveEnergy, LeavesFurtherChannelsAndPixelsFarAway) {
    const Blob blob;
    const Image rgb = blob.picture(0.5f);
    const Image with_alpha =
        make_picture(blob.width, blob.height, {"R", "G", "B", "A"},
                     [&](int x, int y, int c) { return c < 3 ? rgb.at(x, y)[c] : 0.25f; });
    const Image after = with_energy(with_alpha, blob.means(8));
    ASSERT_EQ(after.channels(), 4);
    EXPECT_EQ(after.at(48, 40)[3], 0.25f);
    EXPECT_GT(after.at(48, 40)[0], 1.8f * rgb.at(48, 40)[0]);
    EXPECT_NEAR(after.at(1, 1)[0], rgb.at(1, 1)[0], 0.02f * rgb.at(1, 1)[0]);
}

// What has no samples has no mean: it neither counts nor stays behind what is around it.
TEST(PreserveEnergy, PixelsWithoutSamplesDoNotCount) {
    const Blob blob;
    Image means = blob.means(4);
    for (int y = 0; y < blob.height; ++y)
        for (int x = 0; x < blob.width; ++x)
            if ((x + y) % 3 == 0)
                for (int c = 0; c < 4; ++c) means.at(x, y)[c] = 0;
    const Image half = blob.picture(0.5f), after = with_energy(half, means);
    EXPECT_NEAR(blob.light_of(after, 0) / blob.light_of(blob.picture(1), 0), 1, 0.01);

    Image none(blob.width, blob.height, {"R", "G", "B", "samples"});
    EXPECT_TRUE(std::ranges::equal(with_energy(half, none).pixels(), half.pixels()));
}

TEST(PreserveEnergy, SmallAndBlackPicturesAreNoSpecialCase) {
    for (const auto& [width, height] : {std::pair{1, 1}, {3, 1}, {1, 40}, {5, 5}}) {
        const Image half =
            make_picture(width, height, {"R", "G", "B"}, [](int, int, int) { return 0.5f; });
        const Image means = make_picture(width, height, {"R", "G", "B", "samples"},
                                         [](int, int, int) { return 1.0f; });
        const Image after = with_energy(half, means);
        for (const float value : after.pixels()) EXPECT_NEAR(value, 1, 0.02f);

        const Image black(width, height, {"R", "G", "B"});
        const Image still_black = with_energy(black, means);
        for (const float value : still_black.pixels()) EXPECT_EQ(value, 0);
        const Image dark = make_picture(width, height, {"R", "G", "B", "samples"},
                                        [](int, int, int c) { return c < 3 ? 0.0f : 1.0f; });
        const Image darkened = with_energy(half, dark);
        for (const float value : darkened.pixels()) EXPECT_TRUE(std::isfinite(value));
    }
}

TEST(PreserveEnergy, OtherSizesAreAnError) {
    const Blob blob;
    try {
        with_energy(Image(4, 4, 3), blob.means(4));
        FAIL() << "no error";
    } catch (const Error& e) {
        EXPECT_NE(std::string(e.what()).find("4 x 4"), std::string::npos) << e.what();
        EXPECT_NE(std::string(e.what()).find("96 x 80"), std::string::npos) << e.what();
    }
}

}  // namespace
}  // namespace weft
