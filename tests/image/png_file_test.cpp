// PNG pictures: exact values at 8 and 16 bit, clamping, colour tags, text, damaged files.
#include "image/png_file.h"

#include <cmath>
#include <limits>

#include "run_node.h"

namespace weft {
namespace {

std::vector<std::string> warnings;

PictureOptions deep() {
    PictureOptions options;
    options.depth = Depth::u16;
    return options;
}

TEST(PngFile, EveryEightBitValueIsExact) {
    Image image(16, 16, 1);
    for (size_t i = 0; i < 256; ++i) image.pixels()[i] = float(i) / 255.0f;
    const Image back = decode_png(encode_png(image, {}, warnings), "a.png");
    for (size_t i = 0; i < 256; ++i) EXPECT_EQ(back.pixels()[i], image.pixels()[i]) << i;
}

TEST(PngFile, EverySixteenBitValueIsExact) {
    Image image(256, 256, 1);
    for (size_t i = 0; i < 65536; ++i) image.pixels()[i] = float(i) / 65535.0f;
    const Image back = decode_png(encode_png(image, deep(), warnings), "a.png");
    for (size_t i = 0; i < 65536; ++i) ASSERT_EQ(back.pixels()[i], image.pixels()[i]) << i;
}

TEST(PngFile, KeepsPlacesOfChannels) {
    for (const int channels : {3, 4}) {
        Image image(5, 3, channels);
        for (size_t i = 0; i < image.pixels().size(); ++i)
            image.pixels()[i] = float(i % 7) / 255.0f;
        if (channels == 4)
            for (int y = 0; y < 3; ++y)
                for (int x = 0; x < 5; ++x) image.at(x, y)[3] = 1;
        for (const PictureOptions& options : {PictureOptions{}, deep()}) {
            const Image back = decode_png(encode_png(image, options, warnings), "a.png");
            ASSERT_EQ(back.channels(), channels);
            for (size_t i = 0; i < image.pixels().size(); ++i)
                EXPECT_NEAR(back.pixels()[i], image.pixels()[i],
                            options.depth == Depth::u16 ? 1e-5 : 1e-7);
        }
    }
}

TEST(PngFile, AlphaIsPremultipliedInMemoryOnly) {
    Image image(1, 1, 4);
    const float values[] = {0.1f, 0.2f, 0.4f, 0.5f};
    std::copy(values, values + 4, image.pixels().begin());
    const Image back = decode_png(encode_png(image, deep(), warnings), "a.png");
    for (size_t c = 0; c < 4; ++c) EXPECT_NEAR(back.pixels()[c], values[c], 2e-5);
}

TEST(PngFile, ClampsWhatItCannotHold) {
    Image image(5, 1, 1);
    const float inf = std::numeric_limits<float>::infinity();
    const float values[] = {-0.5f, 1.7f, std::nanf(""), inf, -inf};
    std::copy(values, values + 5, image.pixels().begin());
    const Image back = decode_png(encode_png(image, {}, warnings), "a.png");
    const float expected[] = {0, 1, 0, 1, 0};
    for (size_t i = 0; i < 5; ++i) EXPECT_EQ(back.pixels()[i], expected[i]) << i;
}

TEST(PngFile, TagsDisplaysAndKeepsText) {
    for (const char* space : {"sRGB", "Rec.709", "Display P3", "Rec.2100-PQ"}) {
        Image image(2, 2, 3);
        image.color_space = image.display = space;
        image.view = "Un-tone-mapped";
        image.attributes["note"] = "Grüße";
        PictureOptions options;
        options.provenance = {"{\"weft\": 1}", "[]", "0.1.0"};
        const std::string bytes = encode_png(image, options, warnings);
        EXPECT_EQ(bytes.find("sRGB\0") != std::string::npos, std::string(space) == "sRGB") << space;
        EXPECT_EQ(bytes.find("cICP") == std::string::npos, std::string(space) == "sRGB") << space;
        const Image back = decode_png(bytes, "a.png");
        EXPECT_EQ(back.color_space, space);
        EXPECT_EQ(back.display, space);
        EXPECT_EQ(back.view, "Un-tone-mapped");
        EXPECT_EQ(back.attributes.at("note"), "Grüße");
        EXPECT_EQ(back.attributes.at("weft:graph"), "{\"weft\": 1}");
        EXPECT_EQ(back.attributes.at("weft:inputs"), "[]");
    }
}

TEST(PngFile, SameBytesTwiceAtEveryLevel) {
    Image image(40, 30, 3);
    for (size_t i = 0; i < image.pixels().size(); ++i) image.pixels()[i] = float(i % 251) / 250.0f;
    for (const int level : {0, 1, 6, 9}) {
        PictureOptions options;
        options.level = level;
        const std::string once = encode_png(image, options, warnings);
        EXPECT_EQ(once, encode_png(image, options, warnings));
        EXPECT_EQ(decode_png(once, "a.png").pixels()[100],
                  float(100) / 250.0f > 0 ? std::round(0.4f * 255) / 255 : 0);
    }
}

TEST(PngFile, NamesChannelsThatHaveNoPlace) {
    warnings.clear();
    Image image(2, 2, std::vector<std::string>{"R", "G", "B", "Z"});
    EXPECT_EQ(decode_png(encode_png(image, {}, warnings), "a.png").channels(), 3);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].find("Z"), std::string::npos);
    Image none(2, 2, std::vector<std::string>{"u", "v"});
    EXPECT_NE(error_of([&] { encode_png(none, {}, warnings); }).find("u v"), std::string::npos);
}

TEST(PngFile, EveryCutAndFlipIsSaidOrHarmless) {
    Image image(20, 20, 3);
    for (size_t i = 0; i < image.pixels().size(); ++i)
        image.pixels()[i] = float((i * 37) % 256) / 255.0f;
    const std::string bytes = encode_png(image, {}, warnings);
    for (size_t size = 8; size + 12 < bytes.size(); size += 5) {
        const std::string message =
            error_of([&] { decode_png(std::string_view(bytes).substr(0, size), "cut.png"); });
        EXPECT_TRUE(message.starts_with("cut.png: ")) << size;
    }
    for (size_t i = 8; i < bytes.size(); i += 3) {
        std::string damaged = bytes;
        damaged[i] = char(damaged[i] ^ 0x41);
        const std::string message = error_of([&] { decode_png(damaged, "bad.png"); });
        EXPECT_TRUE(message.empty() || message.starts_with("bad.png: ")) << message;
    }
}

}  // namespace
}  // namespace weft
