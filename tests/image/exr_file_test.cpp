// EXR pictures: exact values, attributes, colour, equal bytes, damaged files.
#include "image/exr_file.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "run_node.h"

namespace weft {
namespace {

Image odd_values(int width, int height, int channels = 3) {
    Image image(width, height, channels);
    std::uint32_t state = 1;
    for (float& value : image.pixels()) {
        state = state * 1664525u + 1013904223u;
        value = std::ldexp(float(state >> 8) / 16777216.0f, int(state % 40) - 20) *
                (state & 8 ? 1.0f : -1.0f);
    }
    const float special[] = {std::numeric_limits<float>::quiet_NaN(),
                             std::numeric_limits<float>::infinity(),
                             -std::numeric_limits<float>::infinity(),
                             std::numeric_limits<float>::denorm_min(),
                             -0.0f,
                             std::numeric_limits<float>::max()};
    for (size_t i = 0; i < std::size(special) && i < image.pixels().size(); ++i)
        image.pixels()[i] = special[i];
    image.color_space = "lin_rec709";
    return image;
}

bool same_bits(const Image& a, const Image& b) {
    return a.names() == b.names() && a.width() == b.width() && a.height() == b.height() &&
           std::memcmp(a.pixels().data(), b.pixels().data(), a.bytes()) == 0;
}

std::vector<std::string> warnings;

TEST(ExrFile, FloatsAreExactWhateverTheCompression) {
    const Image image = odd_values(37, 53);
    for (const Compression c : {Compression::automatic, Compression::none, Compression::rle,
                                Compression::zips, Compression::zip, Compression::piz}) {
        PictureOptions options;
        options.compression = c;
        EXPECT_TRUE(same_bits(image, decode_exr(encode_exr(image, options, warnings), "a.exr")))
            << int(c);
    }
}

TEST(ExrFile, HalvesAreExactForValuesThatAreHalves) {
    Image image(64, 64, 4);
    for (size_t i = 0; i < image.pixels().size(); ++i) image.pixels()[i] = float(i % 2048) / 64.0f;
    PictureOptions options;
    options.depth = Depth::half;
    EXPECT_TRUE(same_bits(image, decode_exr(encode_exr(image, options, warnings), "a.exr")));
}

TEST(ExrFile, HalfTakesTooLargeFiniteValuesAsItsLargest) {
    Image image(2, 1, 1);
    image.pixels()[0] = 1e9f;
    image.pixels()[1] = std::numeric_limits<float>::infinity();
    PictureOptions options;
    options.depth = Depth::half;
    const Image back = decode_exr(encode_exr(image, options, warnings), "a.exr");
    EXPECT_EQ(back.pixels()[0], 65504.0f);
    EXPECT_TRUE(std::isinf(back.pixels()[1]));
}

TEST(ExrFile, KeepsColourSpaceAttributesAndProvenance) {
    Image image = odd_values(4, 3);
    image.color_space = "ACEScg";
    image.display = "sRGB";
    image.view = "Raw";
    image.attributes["note"] = "Grüße, \"quoted\"\n";
    image.attributes["weft:graph"] = "of the picture it was made from";
    PictureOptions options;
    options.provenance = {"{\"weft\": 1}", "[]", "0.1.0"};
    const Image back = decode_exr(encode_exr(image, options, warnings), "a.exr");
    EXPECT_EQ(back.color_space, "ACEScg");
    EXPECT_EQ(back.display, "sRGB");
    EXPECT_EQ(back.view, "Raw");
    EXPECT_EQ(back.attributes.at("note"), "Grüße, \"quoted\"\n");
    EXPECT_EQ(back.attributes.at("weft:graph"), "{\"weft\": 1}");
    EXPECT_EQ(back.attributes.at("weft:version"), "0.1.0");
}

TEST(ExrFile, KnowsSpacesByTheirChromaticities) {
    for (const char* space : {"lin_rec709", "ACEScg", "ACES2065-1", "lin_rec2020", "lin_p3d65"}) {
        Image image(1, 1, 3);
        image.color_space = space;
        std::string bytes = encode_exr(image, {}, warnings);
        // Another program's file has no name of ours: spoil the attribute's.
        const size_t place = bytes.find("oiio:ColorSpace");
        ASSERT_NE(place, std::string::npos);
        bytes.replace(place, 4, "else");
        EXPECT_EQ(decode_exr(bytes, "a.exr").color_space, space);
    }
}

TEST(ExrFile, SaysNoDateAndGivesTheSameBytesTwice) {
    const Image image = odd_values(64, 40);
    const std::string once = encode_exr(image, {}, warnings);
    EXPECT_EQ(once, encode_exr(image, {}, warnings));
    EXPECT_EQ(once.find("Date"), std::string::npos);
    EXPECT_EQ(once.find("capDate"), std::string::npos);
}

TEST(ExrFile, OrdersChannelsAsPeopleDo) {
    Image image(
        2, 2,
        std::vector<std::string>{"Z", "A", "B", "direct.B", "G", "direct.R", "R", "direct.G"});
    for (size_t i = 0; i < image.pixels().size(); ++i) image.pixels()[i] = float(i);
    const Image back = decode_exr(encode_exr(image, {}, warnings), "a.exr");
    const std::vector<std::string> expected = {"R", "G",        "B",        "A",
                                               "Z", "direct.R", "direct.G", "direct.B"};
    EXPECT_EQ(back.names(), expected);
    EXPECT_EQ(back.at(1, 1)[back.find("direct.G")], image.at(1, 1)[image.find("direct.G")]);
}

TEST(ExrFile, ReadsADataWindowInsideTheDisplayWindow) {
    TestFolder folder;
    const std::string path = folder / "window.exr";
    Imf::Header header(Imath::Box2i({0, 0}, {9, 7}), Imath::Box2i({2, 3}, {5, 4}));
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    std::vector<float> values = {1, 2, 3, 4, 5, 6, 7, 8};
    {
        Imf::OutputFile file(path.c_str(), header);
        Imf::FrameBuffer frame;
        frame.insert(
            "Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data() - 2 - 3 * 4), 4, 16));
        file.setFrameBuffer(frame);
        file.writePixels(2);
    }
    const Image image = read_picture(path);
    ASSERT_EQ(image.width(), 10);
    ASSERT_EQ(image.height(), 8);
    EXPECT_EQ(image.at(2, 3)[0], 1);
    EXPECT_EQ(image.at(5, 4)[0], 8);
    EXPECT_EQ(image.at(6, 4)[0], 0);
    EXPECT_EQ(image.at(0, 0)[0], 0);
}

TEST(ExrFile, ReadsTiles) {
    TestFolder folder;
    const std::string path = folder / "tiles.exr";
    Imf::Header header(40, 30);
    header.setTileDescription(Imf::TileDescription(16, 16));
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    std::vector<float> values(40 * 30);
    for (size_t i = 0; i < values.size(); ++i) values[i] = float(i);
    {
        Imf::TiledOutputFile file(path.c_str(), header);
        Imf::FrameBuffer frame;
        frame.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4, 160));
        file.setFrameBuffer(frame);
        file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
    }
    const Image image = read_picture(path);
    EXPECT_EQ(image.at(39, 29)[0], values.back());
    EXPECT_EQ(image.at(17, 3)[0], values[3 * 40 + 17]);
}

TEST(ExrFile, ReadsAPartByItsName) {
    TestFolder folder;
    const std::string path = folder / "parts.exr";
    std::vector<Imf::Header> headers;
    for (const char* name : {"beauty", "depth"}) {
        Imf::Header header(2, 1);
        header.setName(name);
        header.setType(Imf::SCANLINEIMAGE);
        header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
        headers.push_back(header);
    }
    {
        Imf::MultiPartOutputFile file(path.c_str(), headers.data(), 2);
        for (int part = 0; part < 2; ++part) {
            float values[2] = {float(part), 7};
            Imf::FrameBuffer frame;
            frame.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values), 4, 8));
            Imf::OutputPart out(file, part);
            out.setFrameBuffer(frame);
            out.writePixels(1);
        }
    }
    EXPECT_EQ(read_picture(path).pixels()[0], 0);
    EXPECT_EQ(read_picture(path, {"depth", ""}).pixels()[0], 1);
    EXPECT_NE(error_of([&] {
                  read_picture(path, {"dept", ""});
              }).find("beauty, depth"),
              std::string::npos);
    EXPECT_EQ(picture_info(path).parts, (std::vector<std::string>{"beauty", "depth"}));
}

TEST(ExrFile, SendsDeepFilesToReadSamples) {
    TestFolder folder;
    Imf::Header header(2, 2);
    header.setType(Imf::DEEPSCANLINE);
    header.compression() = Imf::ZIPS_COMPRESSION;
    header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
    { Imf::DeepScanLineOutputFile file((folder / "deep.exr").c_str(), header); }
    EXPECT_NE(error_of([&] { read_picture(folder / "deep.exr"); }).find("read-samples"),
              std::string::npos);
    EXPECT_EQ(picture_info(folder / "deep.exr").format, "deep EXR");
}

TEST(ExrFile, TellsItsSizeBeforeItIsRead) {
    TestFolder folder;
    write_picture(folder / "a.exr", odd_values(31, 17), {}, warnings);
    const Shape shape = picture_shape(folder / "a.exr");
    EXPECT_EQ(shape.width, 31);
    EXPECT_EQ(shape.height, 17);
    EXPECT_EQ(shape.bytes, 31 * 17 * 12);
    EXPECT_EQ(picture_shape(folder / "none.exr").bytes, 0);
    Image grey(5, 4, 1);
    write_picture(folder / "a.png", grey, {}, warnings);
    EXPECT_EQ(picture_shape(folder / "a.png").bytes, 5 * 4 * 4);
}

TEST(ExrFile, EveryCutIsAnErrorThatNamesTheFile) {
    const std::string bytes = encode_exr(odd_values(16, 40), {}, warnings);
    for (size_t size = 4; size < bytes.size(); size += 1 + size / 16) {
        const std::string message =
            error_of([&] { decode_exr(std::string_view(bytes).substr(0, size), "cut.exr"); });
        EXPECT_TRUE(message.starts_with("cut.exr: ")) << size << " " << message;
    }
}

TEST(ExrFile, FlippedBytesNeverCrash) {
    const std::string bytes = encode_exr(odd_values(16, 20), {}, warnings);
    for (size_t i = 4; i < bytes.size(); i += i < 700 ? 1 : 37)
        for (const char flip : {char(0xff), char(0x80), char(0x01)}) {
            std::string damaged = bytes;
            damaged[i] = char(damaged[i] ^ flip);
            const std::string message = error_of([&] { decode_exr(damaged, "bad.exr"); });
            EXPECT_TRUE(message.empty() || message.starts_with("bad.exr: ")) << message;
        }
}

TEST(ExrFile, RefusesWhatItCannotHold) {
    PictureOptions options;
    options.depth = Depth::u8;
    EXPECT_NE(
        error_of([&] { encode_exr(odd_values(2, 2), options, warnings); }).find("half or float"),
        std::string::npos);
    EXPECT_NE(error_of([&] { encode_exr(Image(), {}, warnings); }), "");
    EXPECT_NE(error_of([&] {
                  encode_exr(Image(1, 1, std::vector<std::string>{"R", "R"}), {}, warnings);
              }).find("two channels called 'R'"),
              std::string::npos);
}

TEST(ExrFile, SaysWhatAFileHolds) {
    PictureOptions options;
    options.depth = Depth::half;
    options.compression = Compression::piz;
    options.provenance.graph = "{\"weft\": 1}";
    const PictureInfo info = exr_info(encode_exr(odd_values(31, 17), options, warnings), "a.exr");
    EXPECT_EQ(info.width, 31);
    EXPECT_EQ(info.height, 17);
    EXPECT_EQ(info.depth, "half");
    EXPECT_EQ(info.compression, "piz");
    EXPECT_EQ(info.channels, (std::vector<std::string>{"R", "G", "B"}));
    EXPECT_EQ(info.attributes.at("weft:graph"), "{\"weft\": 1}");
    EXPECT_NE(to_text(info, "a.exr").find("31 x 17"), std::string::npos);
    EXPECT_EQ(to_json(info, "a.exr").find("depth")->text, "half");
}

}  // namespace
}  // namespace weft
