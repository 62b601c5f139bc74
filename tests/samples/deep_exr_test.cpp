#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineOutputPart.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRgbaFile.h>

#include "sample_files.h"
#include "samples/exr_channels.h"
#include "samples/exr_header.h"
#include "samples/write_deep_exr.h"

namespace weft::testing {
namespace {

TEST(DeepExr, everything_comes_back_bit_for_bit) {
    const TemporaryFolder folder;
    for (const bool deflate : {false, true}) {
        PlainContext ctx;
        write_deep_exr(rich_buffer(), folder / "a.exr", deflate, ctx);
        EXPECT_TRUE(ctx.warnings.empty());
        const Samples s = read_file(folder / "a.exr");
        expect_equal(rich_buffer(), s);
        EXPECT_EQ(s.meta.find("source")->text, "made by a test");
    }
}

TEST(DeepExr, samples_a_pixel_may_vary) {
    const TemporaryFolder folder;
    Samples uneven;
    uneven.width = uneven.height = 2;
    uneven.first = std::vector<std::uint64_t>{0, 3, 3, 4, 5};
    uneven.add("xy", 2, {.5f, .5f, .25f, .75f, .1f, .2f, .5f, 1.5f, 1.5f, 1.5f});
    uneven.add("rgb", 3, std::vector<float>(15, 0.5f));
    PlainContext ctx;
    write_deep_exr(uneven, folder / "a.exr", true, ctx);
    expect_equal(uneven, read_file(folder / "a.exr"));
}

TEST(DeepExr, channels_that_it_cannot_name_are_left_out) {
    const TemporaryFolder folder;
    Samples s = small_buffer();
    s.add("R", 1, std::vector<float>(s.size(), 1));
    PlainContext ctx;
    write_deep_exr(s, folder / "a.exr", false, ctx);
    ASSERT_EQ(ctx.warnings.size(), 1u);
    EXPECT_SAYS(ctx.warnings[0],
                "a.exr: channel 'R' is left out: 'R' cannot be its name in a deep EXR");
    expect_equal(small_buffer(), read_file(folder / "a.exr"));
}

TEST(DeepExr, a_buffer_without_pixels_is_refused) {
    const TemporaryFolder folder;
    Samples s = small_buffer();
    s.domain = "light";
    PlainContext ctx;
    EXPECT_SAYS(error_of([&] { write_deep_exr(s, folder / "a.exr", false, ctx); }), "write .npz");
    EXPECT_FALSE(std::filesystem::exists(folder / "a.exr"));
}

TEST(DeepExr, names_of_components) {
    const auto name = [](const char* channel, int components, int part) {
        return exr_name({channel, components, standard_role(channel), {}, {}}, part);
    };
    EXPECT_EQ(name("rgb", 3, 2), "B");
    EXPECT_EQ(name("uv", 2, 1), "v");
    EXPECT_EQ(name("z", 1, 0), "Z");
    EXPECT_EQ(name("motion", 3, 2), "motion.z");
    EXPECT_EQ(name("direct", 3, 0), "direct.R");
    EXPECT_EQ(name("things", 6, 5), "things.5");
    EXPECT_EQ(exr_part("diffuse.g").channel, "diffuse");
    EXPECT_EQ(exr_part("diffuse.g").part, 1);
    EXPECT_EQ(exr_part("weft.shade").channel, "weft.shade");
}

// A file as another program writes it: halves, no x and y, a picture beside it, a window that does
// not start at 0, a different number of samples in each pixel.
std::string foreign_file(const std::string& path, Imf::Compression compression) {
    const Imath::Box2i window({10, 20}, {12, 21});
    std::vector<Imf::Header> headers(2, Imf::Header(window, window));
    headers[0].setName("beauty");
    headers[0].setType(Imf::SCANLINEIMAGE);
    headers[0].channels().insert("R", Imf::Channel(Imf::FLOAT));
    headers[1].setName("deep");
    headers[1].setType(Imf::DEEPSCANLINE);
    headers[1].compression() = compression;
    for (const char* c : {"R", "G", "B", "Z"})
        headers[1].channels().insert(c, Imf::Channel(c[0] == 'Z' ? Imf::FLOAT : Imf::HALF));
    headers[1].channels().insert("id", Imf::Channel(Imf::UINT));
    Imf::MultiPartOutputFile file(path.c_str(), headers.data(), 2);

    std::vector<float> picture(6, 1);
    Imf::FrameBuffer flat;
    flat.insert("R", Imf::Slice::Make(Imf::FLOAT, picture.data(), window, 4, 12));
    Imf::OutputPart part(file, 0);
    part.setFrameBuffer(flat);
    part.writePixels(2);

    std::vector<unsigned> counts{1, 0, 40, 2, 3, 1}, ids(47);
    std::vector<Imath::half> color(47);
    std::vector<float> depth(47);
    for (size_t i = 0; i < 47; ++i)
        color[i] = float(i) / 4, depth[i] = float(i + 1), ids[i] = unsigned(i * i);
    std::vector<char*> colors, depths, idents;
    for (size_t pixel = 0, first = 0; pixel < 6; first += counts[pixel++]) {
        colors.push_back(reinterpret_cast<char*>(color.data() + first));
        depths.push_back(reinterpret_cast<char*>(depth.data() + first));
        idents.push_back(reinterpret_cast<char*>(ids.data() + first));
    }
    const auto corner = [&](auto* first, size_t size) {  // where pixel (0, 0) would be
        return reinterpret_cast<char*>(first) - size * (10 + 3 * 20);
    };
    Imf::DeepFrameBuffer frame;
    frame.insertSampleCountSlice(Imf::Slice(Imf::UINT, corner(counts.data(), 4), 4, 12));
    for (const char* c : {"R", "G", "B"})
        frame.insert(c, Imf::DeepSlice(Imf::HALF, corner(colors.data(), 8), 8, 24, 2));
    frame.insert("Z", Imf::DeepSlice(Imf::FLOAT, corner(depths.data(), 8), 8, 24, 4));
    frame.insert("id", Imf::DeepSlice(Imf::UINT, corner(idents.data(), 8), 8, 24, 4));
    Imf::DeepScanLineOutputPart deep(file, 1);
    deep.setFrameBuffer(frame);
    deep.writePixels(2);
    return path;
}

TEST(DeepExr, another_programs_file_is_read_with_pixel_centres) {
    const TemporaryFolder folder;
    for (const auto compression :
         {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION}) {
        const FileBytes file = map_file(foreign_file(folder / "a.exr", compression));
        PlainContext ctx;
        const Samples s = read_sample_file(file, {.channels = {"*"}}, ctx);
        ASSERT_EQ(ctx.warnings.size(), 1u);
        EXPECT_SAYS(ctx.warnings[0],
                    "a.exr: no channels x, y: samples are taken to lie at their pixels' centres");
        EXPECT_EQ(s.width, 3);
        EXPECT_EQ(s.height, 2);
        EXPECT_EQ(s.spp, 0);
        EXPECT_EQ(s.size(), 47u);
        EXPECT_EQ(s.of_pixel(2).begin, 1u);
        EXPECT_EQ(s.of_pixel(2).end, 41u);
        for (size_t i = 0; i < 47; ++i) {
            EXPECT_EQ(s.rgb()[3 * i + 1], float(i) / 4);
            EXPECT_EQ(s.z()[i], float(i + 1));
            EXPECT_EQ(s.find("id")->ids[i], i * i);
        }
        EXPECT_EQ(s.xy()[2 * 46], 2.5f);
        EXPECT_EQ(s.xy()[2 * 46 + 1], 1.5f);
    }
}

struct BrokenExr : ::testing::Test {
    const TemporaryFolder folder;
    const std::string path = folder / "a.exr";
    std::string good(bool deflate = true) {
        PlainContext ctx;
        write_deep_exr(small_buffer(), path, deflate, ctx);
        return bytes_in(path);
    }
    std::string says_of(const std::string& bytes) {
        put_bytes(path, bytes);
        return error_reading(path);
    }
    // Where the value of a header attribute begins.
    static size_t value_of(const std::string& bytes, const std::string& name,
                           const std::string& type) {
        return bytes.find(name + '\0' + type + '\0') + name.size() + type.size() + 2 + 4;
    }
};

TEST_F(BrokenExr, every_cut_is_an_error) {
    const std::string whole = good();
    expect_cuts_refused(whole);
    EXPECT_SAYS(says_of(whole.substr(0, whole.size() / 2)),
                "lies outside the file; it is cut short or damaged");
    EXPECT_SAYS(says_of(whole.substr(0, 100)), "a.exr: cut short");
}

TEST_F(BrokenExr, no_single_damaged_byte_brings_it_down) {
    for (const bool deflate : {false, true}) read_with_damaged_bytes(good(deflate));
}

TEST_F(BrokenExr, huge_windows_allocate_nothing) {
    std::string bytes = good();
    const std::int32_t huge = 900000000;
    std::memcpy(&bytes[value_of(bytes, "dataWindow", "box2i") + 8], &huge, 4);
    EXPECT_SAYS(says_of(bytes), "its 900000001 x 3 pixels do not fit into the file; it is damaged");
    bytes = good();
    std::memcpy(&bytes[value_of(bytes, "dataWindow", "box2i") + 12], &huge, 4);
    EXPECT_SAYS(says_of(bytes), "it has 3 chunks for 900000001 lines of deep samples");
}

TEST_F(BrokenExr, what_it_is_not) {
    {
        Imf::RgbaOutputFile flat(path.c_str(), 4, 3, Imf::WRITE_RGB);
        const std::vector<Imf::Rgba> pixels(12);
        flat.setFrameBuffer(pixels.data(), 1, 4);
        flat.writePixels(3);
    }
    EXPECT_SAYS(error_reading(path),
                "an EXR picture without deep samples; expected a deep EXR, or use read-image");
    std::string bytes = good();
    bytes.replace(value_of(bytes, "type", "string"), 12, "deeptile\0\0\0\0", 12);
    EXPECT_SAYS(says_of(bytes), "no deep scanline part in this EXR");
    bytes = good();
    bytes[value_of(bytes, "compression", "compression")] = 3;
    EXPECT_SAYS(says_of(bytes),
                "deep samples packed by method 3; this program reads none, RLE and ZIPS");
    Samples s = small_buffer();
    std::erase_if(s.channels, [](const Channel& c) { return c.name == "rgb"; });
    PlainContext ctx;
    write_deep_exr(s, path, false, ctx);
    EXPECT_SAYS(error_reading(path), "no channels R, G, B");
}

TEST_F(BrokenExr, lines_that_were_never_written_are_named) {
    std::string bytes = good();
    const ExrHeader header = read_exr_header(file_of(bytes));
    const size_t table =
        bytes.find(std::string(reinterpret_cast<const char*>(header.offsets.data()), 24));
    std::memset(&bytes[table + 8], 0, 8);
    EXPECT_SAYS(says_of(bytes), "line 1 is missing; the file was not finished");
    std::memcpy(&bytes[table + 8], &header.offsets[2], 8);
    EXPECT_SAYS(says_of(bytes), "line 1 is not where the table says; the file is damaged");
}

}  // namespace
}  // namespace weft::testing
