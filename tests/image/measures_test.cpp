// Error measures: known answers, and FLIP against its paper.
#include "image/measures.h"

#include <cmath>

#include "image/flip.h"
#include "image/picture_file.h"
#include "image/plane.h"
#include "run_node.h"

namespace weft {
namespace {

Image flat(int width, int height, float r, float g, float b, const char* space = "sRGB") {
    Image image(width, height, 3);
    for (size_t i = 0; i < image.pixels().size(); i += 3) {
        image.pixels()[i] = r;
        image.pixels()[i + 1] = g;
        image.pixels()[i + 2] = b;
    }
    image.color_space = space;
    return image;
}

Image noisy(int width, int height, std::uint32_t seed) {
    Image image = flat(width, height, 0, 0, 0, "lin_rec709");
    for (float& value : image.pixels()) {
        seed = seed * 1664525u + 1013904223u;
        value = float(seed >> 8) / 16777216.0f;
    }
    return image;
}

TEST(Measures, EqualPicturesDoNotDiffer) {
    PlainContext ctx;
    const Image image = noisy(40, 30, 7);
    const Measures m = compare_pictures(image, image, ctx).measures;
    EXPECT_EQ(m.rmse, 0);
    EXPECT_EQ(m.rel_mse, 0);
    EXPECT_TRUE(std::isinf(m.psnr) && m.psnr > 0);
    EXPECT_NEAR(m.ssim, 1, 1e-9);
    EXPECT_EQ(m.flip, 0);
}

TEST(Measures, KnownValuesOfFlatPictures) {
    PlainContext ctx;
    const Image a = flat(20, 20, 0.6f, 0.6f, 0.6f), b = flat(20, 20, 0.5f, 0.5f, 0.5f);
    const Measures m = compare_pictures(a, b, ctx).measures;
    EXPECT_NEAR(m.rmse, 0.1, 1e-6);
    EXPECT_NEAR(m.rel_mse, 0.01 / 0.26, 1e-6);
    EXPECT_NEAR(m.psnr, 20, 1e-4);
    const double c1 = 1e-4;
    EXPECT_NEAR(m.ssim, (2 * 0.6 * 0.5 + c1) / (0.36 + 0.25 + c1), 1e-6);
}

TEST(Measures, RelativeErrorIsOverEachChannelOfTheReference) {
    PlainContext ctx;
    const Image a = flat(1, 1, 1, 2, 0, "lin_rec709"), b = flat(1, 1, 2, 4, 0.5f, "lin_rec709");
    const double expected = (1 / 4.01 + 4 / 16.01 + 0.25 / 0.26) / 3;
    EXPECT_NEAR(compare_pictures(a, b, ctx).measures.rel_mse, expected, 1e-9);
}

TEST(Measures, PixelsCountByTheirWeight) {
    PlainContext ctx;
    Image a = flat(4, 1, 0.5f, 0.5f, 0.5f), where(4, 1, 1);
    const Image b = a;
    for (int c = 0; c < 3; ++c) a.at(1, 0)[c] += 0.3f, a.at(2, 0)[c] += 9;
    *where.at(0, 0) = 2, *where.at(1, 0) = 1;
    const auto measured = [&] {
        return compare_pictures(a, b, ctx, ErrorKind::flip, 1, &where).measures;
    };
    EXPECT_NEAR(measured().rmse, 0.3 / std::sqrt(3.0), 1e-6);
    EXPECT_NEAR(measured().rel_mse, 0.09 / 0.26 / 3, 1e-6);
    for (float& weight : where.pixels()) weight = 1;
    EXPECT_EQ(measured().rmse, compare_pictures(a, b, ctx).measures.rmse);
    *where.at(3, 0) = -1;
    EXPECT_NE(error_of(measured).find("'where' is -1 at pixel 3, 0"), std::string::npos);
    for (float& weight : where.pixels()) weight = 0;
    EXPECT_NE(error_of(measured).find("a pixel that counts"), std::string::npos);
    where = Image(3, 1, 1);
    EXPECT_NE(error_of(measured).find("'where' is 3 x 1"), std::string::npos);
}

TEST(Measures, LinearPicturesAreJudgedAsUntoneMappedSrgb) {
    PlainContext ctx;
    // Equal on the screen: both white there.
    const Image a = flat(12, 12, 1, 1, 1, "lin_rec709"), b = flat(12, 12, 7, 7, 7, "lin_rec709");
    const Measures m = compare_pictures(a, b, ctx).measures;
    EXPECT_NEAR(m.rmse, 6, 1e-6);
    EXPECT_EQ(m.flip, 0);
    EXPECT_TRUE(std::isinf(m.psnr));
}

TEST(Measures, SpacesAreBroughtToRec709) {
    PlainContext ctx;
    // Rec.709's red in ACEScg.
    const RgbPixels red =
        display_values(flat(1, 1, 0.613097f, 0.070194f, 0.020616f, "ACEScg"), ctx);
    EXPECT_NEAR(red.values[0], 1, 1e-4);
    EXPECT_NEAR(red.values[1], 0, 1e-3);
    EXPECT_NEAR(red.values[2], 0, 1e-3);
    const RgbPixels grey = display_values(flat(1, 1, 0.18f, 0.18f, 0.18f, "lin_rec709"), ctx);
    EXPECT_NEAR(grey.values[0], 0.46136, 1e-5);
}

TEST(Measures, RefusesWhatCannotBeCompared) {
    PlainContext ctx;
    EXPECT_NE(
        error_of([&] { compare_pictures(noisy(4, 4, 1), noisy(4, 5, 1), ctx); }).find("4 x 5"),
        std::string::npos);
    Image other = noisy(4, 4, 1);
    other.color_space = "ACEScg";
    EXPECT_NE(
        error_of([&] { compare_pictures(noisy(4, 4, 1), other, ctx); }).find("ocio-color-space"),
        std::string::npos);
}

TEST(Measures, NotFiniteValuesAreCountedAsZeroAndSaid) {
    PlainContext ctx;
    Image a = noisy(8, 8, 3);
    const Image b = a;
    a.pixels()[5] = std::nanf("");
    const Measures m = compare_pictures(a, b, ctx).measures;
    EXPECT_NEAR(m.rmse, std::abs(b.pixels()[5]) / std::sqrt(192.0), 1e-7);
    ASSERT_EQ(ctx.warnings.size(), 1u);
    EXPECT_NE(ctx.warnings[0].find("1 values"), std::string::npos);
}

double flip_of(const Image& a, const Image& b) {
    PlainContext ctx;
    const std::vector<float> map =
        flip_map(display_values(a, ctx), display_values(b, ctx), usual_pixels_per_degree, ctx);
    double sum = 0;
    for (const float value : map) {
        EXPECT_GE(value, 0);
        EXPECT_LE(value, 1);
        sum += value;
    }
    return sum / double(map.size());
}

TEST(Flip, IsSymmetricAndGrowsWithTheDifference) {
    const Image grey = flat(30, 30, 0.5f, 0.5f, 0.5f);
    double last = 0;
    for (const float v : {0.55f, 0.6f, 0.7f, 0.9f}) {
        const Image other = flat(30, 30, v, v, v);
        const double error = flip_of(grey, other);
        EXPECT_GT(error, last);
        EXPECT_NEAR(error, flip_of(other, grey), 1e-6);
        last = error;
    }
}

// By hand from the paper's formulas. White against black: L* differs by 100, so the error is
// 100^0.7 = 25.12; the largest, green against blue with Hunt's effect, is 41.28; above the knee of
// 0.4 of it, 0.95 + 0.05 (25.12 - 16.51) / (41.28 - 16.51) = 0.9674.
TEST(Flip, WhiteAgainstBlackAsInThePaper) {
    EXPECT_NEAR(flip_of(flat(24, 24, 1, 1, 1), flat(24, 24, 0, 0, 0)), 0.9674, 2e-4);
}

TEST(Flip, GreenAgainstBlueIsTheLargest) {
    EXPECT_NEAR(flip_of(flat(24, 24, 0, 1, 0), flat(24, 24, 0, 0, 1)), 1.0, 1e-4);
}

TEST(Flip, FineNoiseCountsLessThanCoarse) {
    // The eye does not see single pixels of colour at this distance, but does see blocks of
    // sixteen.
    const auto checker = [](int size, float offset) {
        Image image = flat(96, 96, 0.5f, 0.5f, 0.5f);
        for (int y = 0; y < 96; ++y)
            for (int x = 0; x < 96; ++x) {
                const float sign = ((x / size + y / size) & 1) ? 1.0f : -1.0f;
                image.at(x, y)[0] += sign * offset;
                image.at(x, y)[2] -= sign * offset;
            }
        return image;
    };
    const Image grey = flat(96, 96, 0.5f, 0.5f, 0.5f);
    EXPECT_LT(2 * flip_of(grey, checker(1, 0.2f)), flip_of(grey, checker(16, 0.2f)));
}

TEST(Flip, AFireflyIsFoundWhereItIs) {
    PlainContext ctx;
    const Image grey = flat(41, 41, 0.2f, 0.2f, 0.2f);
    Image spot = grey;
    for (int c = 0; c < 3; ++c) spot.at(20, 20)[c] = 1;
    const std::vector<float> map = flip_map(display_values(grey, ctx), display_values(spot, ctx),
                                            usual_pixels_per_degree, ctx);
    const size_t worst = size_t(std::max_element(map.begin(), map.end()) - map.begin());
    EXPECT_EQ(worst, 20u * 41 + 20);
    EXPECT_EQ(map[0], 0);
}

TEST(Plane, SeparableFilterIsThePlainSum) {
    PlainContext ctx;
    Plane in(13, 9);
    for (size_t i = 0; i < in.values.size(); ++i) in.values[i] = float((i * 31) % 17);
    const Taps ax = {0.25f, 0.5f, -0.125f, 0.25f, 0.125f}, ay = {0.5f, 0.25f, 0.25f};
    const Plane out = filtered(in, ax, ay, ctx);
    for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 13; ++x) {
            double sum = 0;
            for (int j = -1; j <= 1; ++j)
                for (int i = -2; i <= 2; ++i)
                    sum += double(ax[size_t(i + 2)]) * ay[size_t(j + 1)] *
                           in.row(std::clamp(y + j, 0, 8))[std::clamp(x + i, 0, 12)];
            EXPECT_NEAR(out.row(y)[x], sum, 1e-4);
        }
}

TEST(Compare, GivesARowAPictureAndAnErrorPicture) {
    const Image reference = noisy(32, 32, 1), a = noisy(32, 32, 2), b = reference;
    RunNode node("compare");
    node.in("image", a, "box").in("image", b, "tlfr").in("reference", reference);
    const Table table = node.out<Table>("table");
    ASSERT_EQ(table.rows.size(), 2u);
    EXPECT_EQ(std::get<std::string>(*table.find(0, "picture")), "box");
    EXPECT_GT(std::get<double>(*table.find(0, "relmse")), 0.1);
    EXPECT_EQ(std::get<double>(*table.find(1, "rmse")), 0);
    const Image error = node.out<Image>("error");
    EXPECT_EQ(error.width(), 32);
    EXPECT_EQ(error.color_space, "sRGB");
    EXPECT_GT(error.at(5, 5)[0], 0.1f);
    const Image other = noisy(3, 3, 1);
    RunNode bad("compare");
    bad.in("image", other, "crop").in("reference", reference);
    EXPECT_NE(error_of([&] { bad.out<Table>("table"); }).find("'crop'"), std::string::npos);
}

TEST(Compare, FilesAreNamedInErrors) {
    TestFolder folder;
    std::vector<std::string> warnings;
    PlainContext ctx;
    write_picture(folder / "a.exr", noisy(8, 8, 1), {}, warnings);
    write_picture(folder / "b.exr", noisy(8, 8, 2), {}, warnings);
    write_picture(folder / "c.exr", noisy(9, 8, 2), {}, warnings);
    EXPECT_GT(compare_files(folder / "a.exr", folder / "b.exr", ctx).measures.rmse, 0.1);
    EXPECT_NE(
        error_of([&] { compare_files(folder / "a.exr", folder / "c.exr", ctx); }).find("c.exr"),
        std::string::npos);
}

TEST(ErrorImage, GivesValuesOrColours) {
    const Image a = flat(4, 4, 0.75f, 0.75f, 0.75f, "lin_rec709"),
                b = flat(4, 4, 0.5f, 0.5f, 0.5f, "lin_rec709");
    RunNode node("error-image");
    node.set("error", "absolute").set("values", true).in("image", a).in("reference", b);
    const Image values = node.out<Image>("image");
    ASSERT_EQ(values.channels(), 1);
    EXPECT_EQ(values.pixels()[0], 0.25f);
    node.set("values", false).set("range", 0.25);
    EXPECT_NEAR(node.out<Image>("image").pixels()[0], 0.99, 1e-6);
}

}  // namespace
}  // namespace weft
