// Sheets, crops and differences of pictures.
#include <cmath>

#include "image/draw_text.h"
#include "image/image.h"
#include "image/table.h"
#include "run_node.h"

namespace weft {
namespace {

Image flat(int width, int height, float value, const char* space = "sRGB") {
    Image image(width, height, 3);
    for (float& v : image.pixels()) v = value;
    image.color_space = space;
    return image;
}

size_t pixels_of(const Image& image, float red) {
    size_t count = 0;
    for (int y = 0; y < image.height(); ++y)
        for (int x = 0; x < image.width(); ++x) count += image.at(x, y)[0] == red;
    return count;
}

TEST(DrawText, EveryLetterIsSeenAndDiffers) {
    std::vector<std::string> seen;
    for (char letter = 33; letter < 127; ++letter) {
        Image image(6, 8, 3);
        draw_text(image, 0, 0, std::string(1, letter), 1, {1, 1, 1});
        std::string shape;
        for (const float value : image.pixels()) shape += value > 0 ? '#' : '.';
        EXPECT_NE(shape.find('#'), std::string::npos) << letter;
        EXPECT_EQ(std::find(seen.begin(), seen.end(), shape), seen.end()) << letter;
        seen.push_back(shape);
        EXPECT_EQ(image.at(5, 0)[0] + image.at(5, 7)[0], 0);  // the gap
    }
}

TEST(DrawText, GrowsByWholePixelsAndLeavesOffWhatIsOutside) {
    Image small(12, 8, 3), large(36, 24, 3);
    draw_text(small, 0, 0, "Ag", 1, {1, 1, 1});
    draw_text(large, 0, 0, "Ag", 3, {1, 1, 1});
    EXPECT_EQ(pixels_of(large, 1), 9 * pixels_of(small, 1));
    EXPECT_EQ(text_width("Ag", 3), 33);
    draw_text(small, -3, 5, "far beyond the edge, \xc3\xbc", 4, {1, 1, 1});
    EXPECT_EQ(text_width("\xc3\xbc", 1), 5);
}

TEST(Sheet, PutsPicturesInARowInOrder) {
    const Image a = flat(20, 10, 0.25f), b = flat(20, 10, 0.5f), c = flat(10, 10, 0.75f);
    RunNode node("sheet");
    node.set("gap", 4)
        .set("text-size", 0)
        .in("image", a, "a")
        .in("image", b, "b")
        .in("image", c, "c");
    const Image sheet = node.out<Image>("image");
    EXPECT_EQ(sheet.width(), 4 + 3 * 24);
    EXPECT_EQ(sheet.height(), 18);
    EXPECT_EQ(sheet.color_space, "sRGB");
    EXPECT_EQ(sheet.at(4, 4)[0], 0.25f);
    EXPECT_EQ(sheet.at(28, 13)[0], 0.5f);
    EXPECT_EQ(sheet.at(52, 4)[0], 0.75f);
    EXPECT_EQ(pixels_of(sheet, 0.75f), 100u);
    node.set("columns", 2).set("zoom", 2);
    const Image two = node.out<Image>("image");
    EXPECT_EQ(two.width(), 4 + 2 * 44);
    EXPECT_EQ(two.height(), 4 + 2 * 24);
    EXPECT_EQ(pixels_of(two, 0.75f), 400u);
}

TEST(Sheet, CaptionsHaveNamesAndMeasures) {
    const Image a = flat(300, 20, 0.25f), b = flat(300, 20, 0.5f);
    RunNode plain("sheet");
    plain.in("image", a, "box").in("image", b, "tlfr");
    const Image without = plain.out<Image>("image");
    EXPECT_GT(pixels_of(without, 0.92f), 100u);
    EXPECT_EQ(pixels_of(without, 0.66f), 0u);
    Table table({"picture", "relmse", "flip"});
    table.add({std::string("tlfr"), 0.0125, 0.05});
    plain.in("table", table);
    const Image with = plain.out<Image>("image");
    EXPECT_EQ(pixels_of(with, 0.92f), pixels_of(without, 0.92f));
    EXPECT_GT(pixels_of(with, 0.66f), 100u);
    EXPECT_GT(with.height(), without.height());
}

TEST(Sheet, RefusesLinearBesideDisplayPictures) {
    const Image a = flat(8, 8, 0.25f), b = flat(8, 8, 0.5f, "lin_rec709");
    RunNode node("sheet");
    node.in("image", a).in("image", b);
    EXPECT_NE(error_of([&] { node.out<Image>("image"); }).find("ocio-display"), std::string::npos);
}

TEST(Crop, CutsAndEnlarges) {
    Image image = flat(10, 8, 0);
    image.at(3, 2)[1] = 1;
    RunNode node("crop");
    node.set("x", 3).set("y", 2).set("width", 4).set("zoom", 2).in("image", image);
    const Image cut = node.out<Image>("image");
    EXPECT_EQ(cut.width(), 8);
    EXPECT_EQ(cut.height(), 12);
    EXPECT_EQ(cut.at(1, 1)[1], 1);
    EXPECT_EQ(cut.at(2, 0)[1], 0);
    node.set("x", 9);
    EXPECT_NE(error_of([&] { node.out<Image>("image"); }).find("10 x 8"), std::string::npos);
}

TEST(Difference, KeepsItsSign) {
    const Image a = flat(3, 3, 0.25f), b = flat(3, 3, 0.5f), c = flat(4, 3, 0);
    RunNode node("difference");
    node.set("gain", 2).in("image", a).in("reference", b);
    EXPECT_EQ(node.out<Image>("image").pixels()[5], -0.5f);
    node.set("absolute", true);
    EXPECT_EQ(node.out<Image>("image").pixels()[5], 0.5f);
    RunNode other("difference");
    other.in("image", a).in("reference", c);
    EXPECT_NE(error_of([&] { other.out<Image>("image"); }).find("4 x 3"), std::string::npos);
}

}  // namespace
}  // namespace weft
