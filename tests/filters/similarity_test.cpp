// The kernels of image filters against their scalar form, on every instruction set.
#include <gtest/gtest.h>

#include <functional>

#include "filters/gaussian_filter_kernel.h"
#include "filters/guides.h"
#include "filters/pictures.h"
#include "tests/instruction_sets.h"

namespace weft {
namespace {

using kernel::Planes;
using kernel::Similarity;

// What is compared: sizes about vectors and blocks, with and without holes and noise.
struct Case {
    int width, height;
    bool noise, holes;
};
const std::vector<Case> cases = {
    {1, 1, true, false},   {37, 1, true, false},   {1, 23, true, true}, {31, 19, true, true},
    {40, 35, false, true}, {131, 37, true, false}, {9, 7, false, false}};

struct Pictures {
    Image image, variance, features, features_variance, mask;
    Guides guides;
    explicit Pictures(const Case& c) {
        const std::vector<std::string> rgb = {"R", "G", "B"};
        const std::vector<std::string> layers = {"normal.x", "normal.y", "normal.z", "depth"};
        image = random_picture(c.width, c.height, {"A", "R", "G", "B"}, 1);
        variance = random_picture(c.width, c.height, rgb, 2, 0.1f);
        features = random_picture(c.width, c.height, layers, 3);
        features_variance = random_picture(c.width, c.height, layers, 4, 0.05f);
        mask = make_picture(c.width, c.height, {"Y"}, [](int x, int y, int) {
            return (x * 7 + y * 3) % 11 == 0 ? 0.0f : 1.0f;
        });
        guides = {&image, c.noise ? &variance : nullptr, &features,
                  c.noise ? &features_variance : nullptr, c.holes ? &mask : nullptr};
    }
};

// Holds the fast form to the scalar one at every pixel.
void expect_same(const Similarity& by, const std::string& what) {
    PlainContext ctx;
    std::vector<double> exact(size_t(kernel::output_planes(by)));
    for (const Isa isa : instruction_sets()) {
        const PinnedIsa pinned(isa);
        const Planes fast = means(by, ctx);
        for (int y = 0; y < by.planes.height; ++y)
            for (int x = 0; x < by.planes.width; ++x) {
                kernel::similar_mean(by, x, y, exact.data());
                for (int c = 0; c < fast.count; ++c) {
                    const double scale = std::max(1.0, std::abs(exact[size_t(c)]));
                    ASSERT_NEAR(fast.row(c, y)[x], exact[size_t(c)], 1e-5 * scale)
                        << what << " " << name_of(isa) << ", " << by.planes.width << " x "
                        << by.planes.height << ", plane " << c << " at " << x << ", " << y;
                }
            }
    }
}

TEST(Similarity, fast_form_equals_the_scalar_one) {
    PlainContext ctx;
    for (const Case& c : cases) {
        const Pictures of(c);
        for (const int patch : {0, 1, 3}) {
            Similarity by = similarity_of(of.guides, 5, patch, ctx);
            by.taps = window(5, 2);
            by.color.e = 0.05f, by.color.k2 = 0.5f;
            expect_same(by, "patches");
            add_features(of.guides, {{}, {1.5f}, 0.3f, 1}, by, ctx);
            expect_same(by, "patches and features");
            by.color.components = 0;
            expect_same(by, "features");
        }
    }
}

TEST(Similarity, fast_form_equals_the_scalar_one_with_holes_between_taps_and_variances) {
    PlainContext ctx;
    for (const Case& c : cases) {
        const Pictures of(c);
        Similarity by = similarity_of(of.guides, 8, 0, ctx);
        add_features(of.guides, {{"depth"}, {2.0f}, 0.1f, 0.5f}, by, ctx);
        by.taps = window(2, 1.5f);
        for (kernel::Tap& tap : by.taps) tap.dx *= 4, tap.dy *= 4;
        by.apart = false;
        by.color.e = 0.3f, by.color.k2 = 2;
        by.variances = by.color.variances;
        expect_same(by, "a trous");
        by.color.subtract = 0;
        expect_same(by, "without noise taken off");
    }
}

// Patch sums of outliers must not spill: sums run afresh at every pixel.
TEST(Similarity, fast_form_equals_the_scalar_one_beside_outliers) {
    PlainContext ctx;
    Image image = random_picture(50, 20, {"R", "G", "B"}, 1);
    Image variance = random_picture(50, 20, {"R", "G", "B"}, 2, 0.01f);
    image.at(20, 9)[1] = 1e9f;
    image.at(33, 12)[0] = -1e17f;
    variance.at(33, 12)[0] = 1e33f;
    const Guides guides{&image, &variance, nullptr, nullptr, nullptr};
    Similarity by = similarity_of(guides, 6, 3, ctx);
    by.taps = window(6);
    by.color.e = 1e-10f, by.color.k2 = 0.2f;
    expect_same(by, "outliers");
}

TEST(Gaussian, fast_form_equals_the_scalar_one) {
    PlainContext ctx;
    for (const Case& c : cases)
        for (const float sigma : {0.4f, 1.0f, 2.3f, 9.0f}) {
            const Pictures of(c);
            const std::vector<float> taps = kernel::gaussian_taps(sigma);
            const int radius = int(taps.size()) / 2;
            // Without colours or features the scalar form is a plain Gaussian.
            Guides plain = of.guides;
            plain.variance = nullptr;
            Similarity by = similarity_of(plain, radius, 0, ctx);
            by.color.components = 0;
            by.taps = window(radius, sigma);
            std::vector<double> exact(size_t(kernel::output_planes(by)));
            for (const Isa isa : instruction_sets()) {
                const PinnedIsa pinned(isa);
                Planes fast(c.width, c.height, by.channels + 1, 0);
                const auto rows = [] {
                    using namespace kernel;
                    return WEFT_PICK(gaussian_rows);
                }();
                rows(by.planes, by.channels, taps, 0, c.height, fast);
                for (int y = 0; y < c.height; ++y)
                    for (int x = 0; x < c.width; ++x) {
                        kernel::similar_mean(by, x, y, exact.data());
                        for (int i = 0; i < by.channels; ++i)
                            ASSERT_NEAR(fast.row(i, y)[x], exact[size_t(i)], 1e-5)
                                << sigma << " at " << x << ", " << y;
                    }
            }
        }
}

}  // namespace
}  // namespace weft
