// TLFR 1.3 and ILFR 2.2.
#include "samples/record_file.h"

#include <fmt/format.h>

#include "sample_files.h"
#include "samples/ilfr.h"
#include "samples/tlfr.h"

namespace weft::testing {
namespace {

TEST(Tlfr, comes_back_bit_for_bit) {
    const TemporaryFolder folder;
    Samples s = small_buffer();
    s.add("z_gradient", 2, std::vector<float>(2 * s.size(), 1.0f / 3));
    for (const bool text : {false, true}) {
        PlainContext ctx;
        write_sample_file(s, folder / "a.tlfr", {.text = text}, ctx);
        EXPECT_TRUE(ctx.warnings.empty());
        expect_equal(s, read_file(folder / "a.tlfr"));
        expect_equal(s, read_file(folder / "a.tlfr.header"));  // either of the two names
    }
}

TEST(Tlfr, what_is_not_there_stays_away) {
    const TemporaryFolder folder;
    Samples s = small_buffer();
    std::erase_if(s.channels, [](const Channel& c) {
        return c.name == "uv" || c.name == "t" || c.name == "motion";
    });
    s.lens.reset();
    PlainContext ctx;
    write_sample_file(s, folder / "a.tlfr", {}, ctx);
    expect_equal(s, read_file(folder / "a.tlfr"));
}

TEST(Tlfr, infinity_is_written_as_1e10_without_motion) {
    const TemporaryFolder folder;
    Samples s = small_buffer(1, 1, 1);
    s.add("z", 1, {inf});
    s.add("motion", 3, {1, 2, 3});
    PlainContext ctx;
    write_sample_file(s, folder / "a.tlfr", {.text = true}, ctx);
    EXPECT_SAYS(ctx.warnings.at(0),
                "a.tlfr: TLFR 1.3 holds no motion of what is infinitely far: that of 1 sample");
    EXPECT_SAYS(bytes_in(folder / "a.tlfr"), ",0,1e+10,");
    const Samples back = read_file(folder / "a.tlfr");
    EXPECT_EQ(back.z()[0], inf);
    EXPECT_EQ(back.motion()[0], 0);
}

TEST(Tlfr, what_it_cannot_hold_is_named) {
    const TemporaryFolder folder;
    Samples s = rich_buffer();
    s.color_space = "ACEScg";
    s.lens->blades = 6;
    PlainContext ctx;
    write_sample_file(s, folder / "a.tlfr", {}, ctx);
    ASSERT_EQ(ctx.warnings.size(), 1u);
    EXPECT_SAYS(ctx.warnings[0],
                "a.tlfr: TLFR 1.3 cannot hold alpha, weight, albedo, five_things, id, the lens' "
                "aspect, blades and "
                "rotation, the colour space (ACEScg), 'source' of meta, 'shutter' of meta; write "
                ".npz to keep them");
    Samples uneven = small_buffer();
    uneven.spp = 0;
    EXPECT_SAYS(error_of([&] { write_sample_file(uneven, folder / "b.tlfr", {}, ctx); }),
                "has the same number of samples in every pixel, in this buffer it varies");
    EXPECT_FALSE(std::filesystem::exists(folder / "b.tlfr"));
    EXPECT_FALSE(std::filesystem::exists(folder / "b.tlfr.header"));
}

// As the published code writes it: no motion model, 6 decimals, a comma after the last value.
const std::string published_header =
    "Version 1.3\nWidth 2\nHeight 1\nSamples per pixel 1\n"
    "CoC coefficients (coc radius = C0/w+C1): -35.084953,4.079645\nEncoding = text\n"
    "x,y,z/w,w,u,v,t,r,g,b,a,mv_x,mv_y,mv_w,dwdx,dwdy\n";
const std::string published_records =
    "0.500000,0.250000,0.900000,8.600000,0.125000,-0.250000,0.500000,0.100000,0.200000,0.300000,"
    "0.300000,1.000000,2.000000,3.000000,0.000000,0.000000,\n"
    "1.500000,0.750000,0.900000,10000000000.000000,0.0,0.0,0.250000,1.0,1.0,1.0,1.0,0,0,0,0,0,\n";

TEST(Tlfr, text_with_the_header_in_front_is_read) {
    const TemporaryFolder folder;
    put_bytes(folder / "a.txt", published_header + published_records);
    const Samples s = read_file(folder / "a.txt");
    EXPECT_EQ(s.width, 2);
    EXPECT_EQ(s.spp, 1);
    EXPECT_EQ(s.lens->c0, -35.084953f);
    EXPECT_EQ(s.z()[0], 8.6f);
    EXPECT_EQ(s.z()[1], inf);
    EXPECT_EQ(s.uv()[1], -0.25f);
    EXPECT_EQ(s.motion()[2], 3);
    EXPECT_EQ(s.rgb()[2], 0.3f);
    EXPECT_FALSE(s.find("z_gradient"));
    EXPECT_FALSE(s.find("alpha"));  // of no meaning in these files
    put_bytes(folder / "b.txt", published_records);
    put_bytes(folder / "b.txt.header", published_header);
    expect_equal(s, read_file(folder / "b.txt"));
    std::string windows = published_header + published_records;
    for (size_t at = 0; (at = windows.find('\n', at)) != std::string::npos; at += 2)
        windows.insert(at, 1, '\r');
    put_bytes(folder / "c.txt", windows);
    expect_equal(s, read_file(folder / "c.txt"));
}

struct BrokenRecords : ::testing::Test {
    const TemporaryFolder folder;
    std::string says(const std::string& text) {
        put_bytes(folder / "a.txt", text);
        return error_reading(folder / "a.txt");
    }
    static std::string with(std::string text, const std::string& from, const std::string& to) {
        return text.replace(text.find(from), from.size(), to);
    }
};

TEST_F(BrokenRecords, headers) {
    const std::string& good = published_header;
    EXPECT_SAYS(says(with(good, "1.3", "1.4")),
                "a.txt:1: version 1.4; this program reads TLFR 1.3 and ILFR 2.2");
    EXPECT_SAYS(says(with(good, "Version 1.3", "Version 2.0")), "version 2.0");
    EXPECT_SAYS(says(with(good, "Width 2", "Width 0")),
                "a.txt:2: Width is '0'; expected a whole number from 1");
    EXPECT_SAYS(says(with(good, "Height", "Depth")), "a.txt:3: 'Depth 1'; expected 'Height ...'");
    EXPECT_SAYS(says(with(good, "Samples per pixel 1", "Samples per pixel -1")),
                "a.txt:4: Samples per pixel is '-1'");
    EXPECT_SAYS(says(with(good, ",4.079645", "")),
                "a.txt:5: 'CoC coefficients (coc radius = C0/w+C1):' needs 2 numbers");
    EXPECT_SAYS(says(with(good, "= text", "= morse")),
                "a.txt:6: encoding 'morse'; expected text or binary");
    EXPECT_SAYS(says(with(good, "x,y,", "")), "expected the names of the fields");
    EXPECT_SAYS(
        says(with(with(good, "Width 2", "Width 2000000000"), "Height 1", "Height 2000000000")),
        "are more than any file holds");
    EXPECT_SAYS(says(with(good, "= text", "= binary")),
                "a header of binary data with no data beside it");
    EXPECT_SAYS(says("Version "), "a.txt:1: version ;");
}

TEST_F(BrokenRecords, text) {
    const std::string good = published_header + published_records;
    const std::string first = published_records.substr(0, published_records.find('\n') + 1);
    EXPECT_SAYS(says(published_header),
                "0 bytes of text cannot hold 2 records of 16 numbers: the file is cut short");
    EXPECT_SAYS(says(published_header + first + std::string(40, ' ')),
                "a.txt:9: the text ends after 1 of 2 records");
    EXPECT_SAYS(says(published_header + published_records.substr(0, 200)), "a.txt:9: ");
    EXPECT_SAYS(says(good + published_records),
                "a.txt:10: more lines than the 2 records of the header");
    EXPECT_SAYS(says(with(good, "0.250000,", "a quarter,")),
                "a.txt:8: 1 numbers, then 'a quarter,0.900000,8");
    EXPECT_SAYS(says(with(good, "0,0,0,\n", "0,0,0,7\n")), "a.txt:9: more than 16 numbers");
    EXPECT_SAYS(says(with(good, "Width 2", "Width 1000000")),
                "cannot hold 1000000 records of 16 numbers");
}

TEST_F(BrokenRecords, binary_of_the_wrong_length) {
    PlainContext ctx;
    write_sample_file(small_buffer(), folder / "a.tlfr", {}, ctx);
    const std::string whole = bytes_in(folder / "a.tlfr");
    put_bytes(folder / "a.tlfr", whole.substr(0, whole.size() - 4));
    EXPECT_SAYS(error_reading(folder / "a.tlfr"),
                "a.tlfr: 1532 bytes; 4 x 3 pixels of 2 samples of 64 bytes make 1536: the file is "
                "cut short");
    put_bytes(folder / "a.tlfr", whole + "1234");
    EXPECT_SAYS(error_reading(folder / "a.tlfr"), "make 1536: the file is not of this header");
    std::filesystem::remove(folder / "a.tlfr.header");
    EXPECT_SAYS(error_reading(folder / "a.tlfr"), "(data of the last two have their header in");
}

TEST_F(BrokenRecords, values_are_checked) {
    const std::string good = published_header + published_records;
    put_bytes(folder / "a.txt", with(good, "8.600000", "nan"));
    PlainContext ctx;
    const Samples s = read_sample_file(map_file(folder / "a.txt"), {.tolerate = 1}, ctx);
    EXPECT_EQ(s.size(), 1u);
    EXPECT_SAYS(
        ctx.warnings.at(0),
        "z: depth is NaN or not above 0 in 1 sample; first: pixel (0, 0), sample 0, z = nan");
    EXPECT_SAYS(says(with(good, "-0.250000,", "-1.5,")),
                "lens position lies outside the unit disk");
}

TEST(Ilfr, a_buffer_in_pixels_comes_back) {
    const TemporaryFolder folder;
    Samples s = small_buffer();
    std::vector<float> albedo(3 * s.size(), 0.1f), direct(3 * s.size(), 0.7f);
    s.add("albedo", 3, albedo);
    s.add("direct", 3, direct);
    for (const bool text : {false, true}) {
        PlainContext ctx;
        write_sample_file(s, folder / "a.ilfr", {.text = text}, ctx);
        EXPECT_TRUE(ctx.warnings.empty());
        Samples back = read_file(folder / "a.ilfr", {.channels = {"albedo", "direct"}});
        expect_equal(s, back);
    }
}

// A camera 8.6 units from its plane in focus, which pixels see from -0.75 to 0.75, looking along
// -z.
std::string camera_file(const TemporaryFolder& folder) {
    RecordHeader header;
    header.kind = RecordKind::ilfr;
    header.width = 4;
    header.height = 2;
    header.spp = 1;
    header.c0 = -35;
    header.c1 = 4;
    header.pixel_to_camera = {0.375f, 0, 0, -0.75f, 0, -0.375f, 0, 0.375f,
                              0,      0, 0, -8.6f,  0, 0,       0, 1};
    PlainContext ctx;
    write_records(folder / "a.ilfr", header, ctx, [&](size_t i, std::span<float> record) {
        for (size_t k = 0; k < record.size(); ++k) record[k] = float(k) / 64;
        record[0] = float(i % 4) + 0.5f;
        record[1] = float(i / 4) + 0.5f;
        // A hit at twice the distance of the plane in focus, seen at pixel (3, 1) from the lens
        // centre.
        record[18] = 0.75f;
        record[19] = 0;
        record[20] = -17.2f;
        record[24] = 0.375f;  // moves one pixel's width at the plane in focus
        record[25] = 0;
        record[26] = 0;
    });
    return folder / "a.ilfr";
}

TEST(Ilfr, depth_and_motion_come_from_the_primary_hit) {
    const TemporaryFolder folder;
    const std::string path = camera_file(folder);
    const Samples basic = read_file(path, {});
    EXPECT_EQ(basic.channels.size(), 6u);
    EXPECT_FLOAT_EQ(basic.z()[0], 17.2f);
    EXPECT_FLOAT_EQ(basic.motion()[0], 8.6f);
    EXPECT_NEAR(basic.motion()[1], 0, 1e-6);
    EXPECT_NEAR(basic.motion()[2], 0, 1e-6);
    // Its place in pixels, by the matrix that meta carries.
    const Json* rows = basic.meta.find("camera")->find("camera_to_pixel");
    double p[3];
    for (size_t i = 0; i < 3; ++i) {
        const auto& row = rows->items[i].items;
        p[i] = row[0].number * 0.75 + row[2].number * -17.2f;
    }
    EXPECT_NEAR(p[0] / p[2], 3, 1e-5);
    EXPECT_NEAR(p[1] / p[2], 1, 1e-5);
    EXPECT_NEAR(p[2], 17.2, 1e-5);
}

TEST(Ilfr, all_39_columns_are_kept) {
    const TemporaryFolder folder;
    const std::string path = camera_file(folder);
    const Samples all = read_file(path);
    EXPECT_EQ(all.find("normal")->values[0], 12.0f / 64);
    EXPECT_EQ(all.find("normal")->role, Role::feature);
    EXPECT_EQ(all.find("secondary_direct")->values[2], 38.0f / 64);
    PlainContext ctx;
    write_sample_file(all, folder / "b.ilfr", {}, ctx);
    EXPECT_TRUE(ctx.warnings.empty());
    EXPECT_EQ(bytes_in(path), bytes_in(folder / "b.ilfr"));
    EXPECT_EQ(bytes_in(path + ".header"), bytes_in(folder / "b.ilfr.header"));
    write_sample_file(all, folder / "c.npz", {}, ctx);  // and through the native file
    write_sample_file(read_file(folder / "c.npz"), folder / "d.ilfr", {.text = true}, ctx);
    write_sample_file(read_file(folder / "d.ilfr"), folder / "e.ilfr", {}, ctx);
    EXPECT_EQ(bytes_in(path), bytes_in(folder / "e.ilfr"));
}

TEST(Ilfr, a_matrix_that_shows_no_depth_is_refused) {
    const TemporaryFolder folder;
    const std::string path = camera_file(folder);
    std::string header = bytes_in(path + ".header");
    const size_t at = header.find("0.375,0,0,-0.75");
    put_bytes(path + ".header", header.replace(at, 15, "0,0,0,0"));
    EXPECT_SAYS(error_reading(path),
                "pixel-to-camera matrix does not take pixels to a plane before the camera");
}

TEST(Formats, are_told_by_content) {
    const TemporaryFolder folder;
    PlainContext ctx;
    const Samples s = small_buffer();
    write_sample_file(s, folder / "a", {.format = SampleFormat::npz}, ctx);
    write_sample_file(s, folder / "b.npz", {.format = SampleFormat::deep_exr}, ctx);
    write_sample_file(s, folder / "c.exr", {.format = SampleFormat::tlfr}, ctx);
    for (const char* name : {"a", "b.npz", "c.exr"}) expect_equal(s, read_file(folder / name));
    EXPECT_EQ(format_of(map_file(folder / "b.npz")), SampleFormat::deep_exr);
    EXPECT_EQ(name_of(*format_of(map_file(folder / "c.exr"))), "TLFR 1.3");
    EXPECT_SAYS(
        error_of([&] { write_sample_file(s, folder / "a.b/c", {}, ctx); }),
        "does not say which format to write; name it .npz, .exr, .tlfr or .ilfr, or set 'format'");
}

}  // namespace
}  // namespace weft::testing
