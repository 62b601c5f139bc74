#include "samples/write_npz.h"

#include "sample_files.h"
#include "samples/zip_reader.h"

namespace weft::testing {
namespace {

void round_trip(const Samples& samples, bool deflate) {
    const TemporaryFolder folder;
    PlainContext ctx;
    write_npz(samples, folder / "a.npz", deflate, ctx);
    expect_equal(samples, read_file(folder / "a.npz"));
}

TEST(Npz, everything_comes_back_bit_for_bit) {
    round_trip(rich_buffer(), false);
    round_trip(rich_buffer(), true);
}

TEST(Npz, samples_a_pixel_may_vary) {
    Samples s = small_buffer(3, 2, 2);
    s.spp = 0;
    s.first = std::vector<std::uint64_t>{0, 2, 4, 6, 8, 10, 12};
    round_trip(s, false);
    Samples uneven;
    uneven.width = 2;
    uneven.height = 2;
    uneven.first = std::vector<std::uint64_t>{0, 3, 3, 4, 5};
    uneven.add("xy", 2, {.5f, .5f, .25f, .75f, .1f, .2f, .5f, 1.5f, 1.5f, 1.5f});
    uneven.add("rgb", 3, std::vector<float>(15, 0.5f));
    round_trip(uneven, true);
}

TEST(Npz, a_buffer_seen_from_a_light_has_no_pixels) {
    Samples s;
    s.width = s.height = 8;
    s.domain = "light";
    s.add("xy", 2, {-3, 4, 9, 9});
    s.add("uv", 2, {-1, 1, 1, -1});
    s.add("rgb", 3, std::vector<float>(6, 1));
    round_trip(s, false);
}

TEST(Npz, meta_keeps_what_it_does_not_know) {
    const TemporaryFolder folder;
    PlainContext ctx;
    ctx.written = {"{\"weft\": 1}", "[]", "1.2.3"};
    write_npz(rich_buffer(), folder / "a.npz", false, ctx);
    const Samples s = read_file(folder / "a.npz");
    EXPECT_EQ(s.meta.find("source")->text, "made by a test");
    EXPECT_EQ(s.meta.find("shutter")->items[1].number, 0.5);
    EXPECT_EQ(s.meta.find("weft:graph")->text, "{\"weft\": 1}");
    EXPECT_EQ(s.meta.find("weft:version")->text, "1.2.3");
    EXPECT_EQ(s.meta.find("roles")->find("id")->text, "feature");
}

TEST(Npz, the_same_buffer_gives_the_same_bytes) {
    const TemporaryFolder folder;
    PlainContext ctx;
    write_npz(rich_buffer(), folder / "a.npz", false, ctx);
    write_npz(rich_buffer(), folder / "b.npz", false, ctx);
    EXPECT_EQ(bytes_in(folder / "a.npz"), bytes_in(folder / "b.npz"));
}

TEST(Npz, stored_numbers_lie_at_multiples_of_64) {
    const TemporaryFolder folder;
    PlainContext ctx;
    write_npz(rich_buffer(), folder / "a.npz", false, ctx);
    const FileBytes file = map_file(folder / "a.npz");
    for (const ZipMember& m : zip_members(file)) {
        const Npy array = parse_npy(m.packed, m.name);
        EXPECT_EQ((array.data.data() - file.bytes.data()) % 64, 0) << m.name;
    }
}

TEST(Npz, stored_floats_are_used_where_they_lie) {
    const TemporaryFolder folder;
    PlainContext ctx;
    write_npz(small_buffer(), folder / "a.npz", false, ctx);
    const FileBytes file = map_file(folder / "a.npz");
    const Samples s = read_sample_file(file, {}, ctx);
    const auto* begin = reinterpret_cast<const float*>(file.bytes.data());
    for (const Channel& c : s.channels) {
        EXPECT_GE(c.values.view().data(), begin) << c.name;
        EXPECT_LT(c.values.view().data(), begin + file.bytes.size() / 4) << c.name;
    }
}

TEST(Npz, numbers_at_odd_addresses_are_copied) {
    const TemporaryFolder folder;
    PlainContext ctx;
    write_npz(small_buffer(), folder / "a.npz", false, ctx);
    std::string moved(1, 'x');
    moved += bytes_in(folder / "a.npz");
    const FileBytes odd{"odd.npz",
                        {reinterpret_cast<const std::uint8_t*>(moved.data()) + 1, moved.size() - 1},
                        nullptr,
                        false};
    expect_equal(small_buffer(), read_sample_file(odd, {}, ctx));
}

TEST(Npz, only_basic_channels_are_read_unless_asked) {
    const TemporaryFolder folder;
    PlainContext ctx;
    write_npz(rich_buffer(), folder / "a.npz", false, ctx);
    const Samples basic = read_file(folder / "a.npz", {});
    EXPECT_TRUE(basic.find("z_gradient"));
    EXPECT_FALSE(basic.find("albedo"));
    EXPECT_FALSE(basic.find("id"));
    const Samples more = read_file(folder / "a.npz", {.channels = {"albedo", "bounce"}});
    EXPECT_TRUE(more.find("albedo"));
    EXPECT_FALSE(more.find("id"));
    EXPECT_SAYS(error_reading(folder / "a.npz", {.channels = {"five_thing"}}),
                "no channel 'five_thing'; did you mean 'five_things'?");
}

TEST(Npz, damage_in_a_channel_that_is_not_read_does_no_harm) {
    const TemporaryFolder folder;
    PlainContext ctx;
    write_npz(rich_buffer(), folder / "a.npz", false, ctx);
    const FileBytes file = map_file(folder / "a.npz");
    std::string bytes(file.text());
    for (const ZipMember& m : zip_members(file))
        if (m.name == "albedo.npy") bytes[size_t(&m.packed.back() - file.bytes.data())] ^= 1;
    put_bytes(folder / "b.npz", bytes);
    EXPECT_FALSE(read_file(folder / "b.npz", {}).find("albedo"));
    EXPECT_SAYS(error_reading(folder / "b.npz", {.channels = {"albedo"}}),
                "'albedo.npy' has checksum");
}

TEST(Npz, sizes_of_64_bits_are_written_and_read) {
    const TemporaryFolder folder;
    const Samples s = small_buffer();
    std::vector<Member> members{meta_member(s.meta_object().dump())};
    for (const Channel& c : s.channels)
        members.push_back(
            member(c.name, c.components, {c.values.view().begin(), c.values.view().end()}));
    put_npz(folder / "a.npz", members, false,
            200);  // every member and offset over 200 bytes is "large"
    const std::string bytes = bytes_in(folder / "a.npz");
    EXPECT_NE(bytes.find("PK\x06\x06"), std::string::npos);
    expect_equal(s, read_file(folder / "a.npz"));
}

TEST(Npz, writing_makes_folders_and_leaves_no_half_file) {
    const TemporaryFolder folder;
    PlainContext ctx;
    write_npz(small_buffer(), folder / "deep/er/a.npz", false, ctx);
    EXPECT_TRUE(std::filesystem::exists(folder / "deep/er/a.npz"));
    ctx.stop = true;
    EXPECT_THROW(write_npz(small_buffer(), folder / "b.npz", false, ctx), Cancelled);
    size_t files = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path()))
        ++files;
    EXPECT_EQ(files, 1u);  // the folder "deep"
}

}  // namespace
}  // namespace weft::testing
