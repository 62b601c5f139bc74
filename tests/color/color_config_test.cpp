// Colour through OpenColorIO: the shipped config's numbers, other configs, what is said of unknown
// names.
#include "color/color_config.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>

#include "color/apply_color.h"
#include "run_node.h"

namespace weft {
namespace {

std::array<float, 3> mapped(const ColorTransform& transform, float r, float g, float b) {
    std::array<float, 3> rgb = {r, g, b};
    transform.apply(rgb.data(), 1);
    return rgb;
}

float shown(const char* display, const char* view, float grey) {
    return mapped(ColorConfig::shipped()->display("lin_rec709", display, view), grey, grey,
                  grey)[0];
}

TEST(ShippedConfig, GivesTheKnownNumbers) {
    EXPECT_NEAR(shown("sRGB", "ACES 1.0 SDR", 0.18f), 0.35595, 2e-5);
    EXPECT_NEAR(shown("sRGB", "ACES 1.0 SDR", 1.0f), 0.81197, 2e-5);
    EXPECT_NEAR(shown("sRGB", "ACES 1.0 SDR", 16.0f), 0.99974, 2e-5);
    EXPECT_NEAR(shown("sRGB", "Un-tone-mapped", 0.18f), 0.46136, 2e-5);
    EXPECT_NEAR(shown("Rec.2100-PQ", "Un-tone-mapped", 0.18f), 0.34797, 2e-5);
    EXPECT_NEAR(shown("Display P3", "Un-tone-mapped", 0.18f), 0.46136, 2e-5);
    EXPECT_NEAR(shown("Rec.709", "Un-tone-mapped", 0.18f), std::pow(0.18, 1 / 2.4), 2e-5);
    EXPECT_EQ(shown("sRGB", "Raw", 0.18f), 0.18f);
    const auto red = mapped(ColorConfig::shipped()->convert("lin_rec709", "ACEScg"), 1, 0, 0);
    EXPECT_NEAR(red[0], 0.613097, 2e-6);
    EXPECT_NEAR(red[1], 0.070194, 2e-6);
    EXPECT_NEAR(red[2], 0.020616, 2e-6);
    EXPECT_NEAR(mapped(ColorConfig::shipped()->convert("srgb_tx", "ACEScg"), 0.5f, 0.5f, 0.5f)[0],
                0.214041, 2e-6);
}

TEST(ShippedConfig, UntoneMappedIsTheSrgbCurve) {
    for (const float v : {0.0f, 0.001f, 0.0031308f, 0.02f, 0.3f, 0.9f, 1.0f}) {
        const double expected = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
        EXPECT_NEAR(shown("sRGB", "Un-tone-mapped", v), expected, 2e-5) << v;
    }
}

TEST(ShippedConfig, WhiteStaysWhiteInEverySpace) {
    for (const char* space :
         {"ACEScg", "ACES2065-1", "lin_rec2020", "lin_p3d65", "lin_ap0", "scene_linear"}) {
        const auto white = mapped(ColorConfig::shipped()->convert("lin_rec709", space), 1, 1, 1);
        for (const float value : white) EXPECT_NEAR(value, 1, 2e-5) << space;
    }
}

TEST(ShippedConfig, DefaultsAndOtherNames) {
    const ColorTransform usual = ColorConfig::shipped()->display("ACEScg", "", "");
    EXPECT_EQ(usual.display, "sRGB");
    EXPECT_EQ(usual.view, "ACES 1.0 SDR");
    EXPECT_EQ(usual.color_space, "sRGB");
    const ColorTransform other = ColorConfig::shipped()->display(
        "ACEScg", "Rec.1886 Rec.709 - Display", "ACES 1.0 - SDR Video");
    EXPECT_EQ(other.display, "Rec.709");
    EXPECT_EQ(other.view, "ACES 1.0 SDR");
    EXPECT_EQ(ColorConfig::shipped()->display("ACEScg", "Rec.2100-PQ", "").view,
              "ACES 1.1 HDR (1000 nits)");
}

TEST(ShippedConfig, DataIsLeftAlone) {
    EXPECT_EQ(mapped(ColorConfig::shipped()->display("Raw", "sRGB", "ACES 1.0 SDR"), 0.3f, 2, -1),
              (std::array<float, 3>{0.3f, 2, -1}));
}

TEST(ShippedConfig, UnknownNamesComeWithNearOnes) {
    const auto config = ColorConfig::shipped();
    const std::string space = error_of([&] { config->convert("lin_rec79", "ACEScg"); });
    EXPECT_NE(space.find("did you mean 'lin_rec709'"), std::string::npos) << space;
    EXPECT_NE(space.find("ACES2065-1"), std::string::npos) << space;
    EXPECT_NE(error_of([&] { config->display("ACEScg", "sRBG", ""); }).find("did you mean 'sRGB'"),
              std::string::npos);
    const std::string view = error_of([&] { config->display("ACEScg", "sRGB", "Filmic"); });
    EXPECT_NE(view.find("ACES 1.0 SDR, Un-tone-mapped, Raw"), std::string::npos) << view;
    EXPECT_NE(error_of([&] { config->look("ACEScg", "warm", false); }).find("no look 'warm'"),
              std::string::npos);
}

// A studio's config: other names, a look, an interchange role.
const char* const studio = R"(ocio_profile_version: 2
strictparsing: true
roles: {default: plate, scene_linear: plate, aces_interchange: ap0}
file_rules:
  - !<Rule> {name: Default, colorspace: default}
displays:
  sRGB - Display:
    - !<View> {name: Plain, colorspace: srgb}
    - !<View> {name: Warm, colorspace: srgb, looks: warm}
looks:
  - !<Look> {name: warm, process_space: plate, transform: !<CDLTransform> {slope: [2, 1, 1]}}
colorspaces:
  - !<ColorSpace> {name: ap0}
  - !<ColorSpace>
    name: plate
    to_scene_reference: !<BuiltinTransform> {style: ACEScg_to_ACES2065-1}
  - !<ColorSpace>
    name: srgb
    from_scene_reference: !<GroupTransform>
      children:
        - !<BuiltinTransform> {style: ACEScg_to_ACES2065-1, direction: inverse}
        - !<BuiltinTransform> {style: UTILITY - ACES-AP1_to_LINEAR-REC709_BFD}
        - !<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055, direction: inverse}
)";

class StudioConfig : public testing::Test {
  protected:
    TestFolder folder;
    std::string path = folder / "studio.ocio";
    void SetUp() override { std::ofstream(path) << studio; }
    void TearDown() override { unsetenv("OCIO"); }
};

TEST_F(StudioConfig, TheParameterGoesBeforeTheEnvironment) {
    EXPECT_EQ(ColorConfig::open("")->name(), "weft-1");
    setenv("OCIO", path.c_str(), 1);
    EXPECT_EQ(ColorConfig::open("")->name(), path);
    setenv("OCIO", "/nowhere.ocio", 1);
    EXPECT_EQ(ColorConfig::open(path)->name(), path);
    EXPECT_NE(error_of([&] { ColorConfig::open(""); }).find("$OCIO names '/nowhere.ocio'"),
              std::string::npos);
    EXPECT_EQ(ColorConfig::open(path), ColorConfig::open(path));  // parsed once
}

TEST_F(StudioConfig, ASpaceItLacksIsJoinedThroughTheInterchange) {
    const auto config = ColorConfig::open(path);
    const auto red = mapped(config->convert("lin_rec709", "plate"), 1, 0, 0);
    EXPECT_NEAR(red[0], 0.613097, 1e-5);
    const auto back = mapped(config->convert("plate", "lin_rec709"), red[0], red[1], red[2]);
    EXPECT_NEAR(back[0], 1, 1e-5);
    EXPECT_NEAR(back[1], 0, 1e-5);
    EXPECT_NEAR(mapped(config->display("lin_rec709", "", ""), 0.18f, 0.18f, 0.18f)[0], 0.46136,
                2e-5);
    EXPECT_EQ(config->display("lin_rec709", "sRGB", "").display, "sRGB - Display");
}

TEST_F(StudioConfig, LooksAreAppliedAndUndone) {
    const auto config = ColorConfig::open(path);
    EXPECT_NEAR(mapped(config->look("plate", "warm", false), 0.2f, 0.2f, 0.2f)[0], 0.4, 1e-6);
    EXPECT_NEAR(mapped(config->look("plate", "warm", true), 0.4f, 0.2f, 0.2f)[0], 0.2, 1e-6);
    const float plain = mapped(config->display("plate", "", "Plain"), 0.1f, 0.1f, 0.1f)[0];
    EXPECT_GT(mapped(config->display("plate", "", "Warm"), 0.1f, 0.1f, 0.1f)[0], plain + 0.05f);
    EXPECT_EQ(mapped(config->display("plate", "", "Plain", "warm"), 0.1f, 0.1f, 0.1f),
              mapped(config->display("plate", "", "Warm"), 0.1f, 0.1f, 0.1f));
    // A joined space goes to the studio's and back.
    EXPECT_NEAR(mapped(config->look("ACEScg", "warm", false), 0.2f, 0.2f, 0.2f)[0], 0.4, 1e-4);
}

TEST_F(StudioConfig, WithoutTheInterchangeTheErrorListsItsNames) {
    std::string text = studio;
    text.replace(text.find(", aces_interchange: ap0"), 23, "");
    const std::string plain = folder / "plain.ocio";
    std::ofstream(plain) << text;
    const std::string message =
        error_of([&] { ColorConfig::open(plain)->convert("lin_rec709", "plate"); });
    for (const char* part : {"plain.ocio", "'lin_rec709'", "aces_interchange", "ap0, plate, srgb"})
        EXPECT_NE(message.find(part), std::string::npos) << message;
}

TEST_F(StudioConfig, ADamagedConfigIsNamed) {
    const std::string bad = folder / "bad.ocio";
    std::ofstream(bad) << "ocio_profile_version: 2\nroles: [";
    EXPECT_NE(error_of([&] { ColorConfig::open(bad); }).find("bad.ocio"), std::string::npos);
}

Image grey_picture(int channels) {
    Image image(19, 35, channels);
    for (float& value : image.pixels()) value = 0.18f;
    image.color_space = "lin_rec709";
    return image;
}

TEST(OcioDisplay, TellsWhatItMade) {
    const Image image = grey_picture(3);
    RunNode node("ocio-display");
    node.in("image", image);
    const Image out = node.out<Image>("image");
    EXPECT_NEAR(out.at(18, 34)[1], 0.35595, 2e-5);
    EXPECT_EQ(out.display, "sRGB");
    EXPECT_EQ(out.view, "ACES 1.0 SDR");
    EXPECT_EQ(out.attributes.at("weft:ocio"), "weft-1");
    EXPECT_TRUE(node.ctx.warnings.empty());
}

TEST(OcioDisplay, SanitisesAndSaysSo) {
    Image image = grey_picture(3);
    image.at(3, 3)[0] = std::numeric_limits<float>::infinity();
    image.at(4, 3)[1] = std::nanf("");
    RunNode node("ocio-display");
    node.in("image", image);
    const Image out = node.out<Image>("image");
    for (const float value : out.pixels()) ASSERT_TRUE(std::isfinite(value));
    ASSERT_EQ(node.ctx.warnings.size(), 1u);
    EXPECT_NE(node.ctx.warnings[0].find("2 values"), std::string::npos);
}

TEST(OcioDisplay, DividesByAlphaAndLeavesOtherChannels) {
    Image image(1, 1, std::vector<std::string>{"R", "G", "B", "A", "Z"});
    const float values[] = {0.09f, 0.09f, 0.09f, 0.5f, 123};
    std::copy(values, values + 5, image.pixels().begin());
    image.color_space = "lin_rec709";
    RunNode node("ocio-display");
    node.set("view", "Un-tone-mapped").in("image", image);
    const Image out = node.out<Image>("image");
    EXPECT_NEAR(out.pixels()[0], 0.46136 * 0.5, 2e-5);
    EXPECT_EQ(out.pixels()[3], 0.5f);
    EXPECT_EQ(out.pixels()[4], 123);
}

TEST(OcioDisplay, GreyPicturesGetColours) {
    const Image image = grey_picture(1);
    RunNode node("ocio-display");
    node.in("image", image);
    const Image out = node.out<Image>("image");
    ASSERT_EQ(out.channels(), 3);
    EXPECT_NEAR(out.at(5, 5)[2], 0.35595, 2e-5);
}

TEST(OcioColorSpace, ConvertsAndNamesTheSpace) {
    const Image image = grey_picture(3);
    RunNode node("ocio-color-space");
    node.in("image", image);
    EXPECT_EQ(node.out<Image>("image").color_space, "ACEScg");
    node.set("to", "ACEScct").set("from", "ACEScg");
    EXPECT_NEAR(node.out<Image>("image").pixels()[0], (std::log2(0.18) + 9.72) / 17.52, 1e-5);
}

TEST(Exposure, DoublesPerStop) {
    Image image(1, 1, 4);
    const float values[] = {1, 2, 3, 0.5f};
    std::copy(values, values + 4, image.pixels().begin());
    RunNode node("exposure");
    node.set("stops", 2).set("gain", Json::list({1, 0.5, 1})).in("image", image);
    const Image out = node.out<Image>("image");
    EXPECT_EQ(out.pixels()[0], 4);
    EXPECT_EQ(out.pixels()[1], 4);
    EXPECT_EQ(out.pixels()[2], 12);
    EXPECT_EQ(out.pixels()[3], 0.5f);
}

}  // namespace
}  // namespace weft
