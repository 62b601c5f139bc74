// What is said of .npz files that cannot be used.
#include "sample_files.h"
#include "samples/write_npz.h"
#include "samples/zip_reader.h"

namespace weft::testing {
namespace {

constexpr const char* meta_1x1 = R"({"weft_samples": 1, "width": 1, "height": 1, "spp": 1})";

struct BrokenNpz : ::testing::Test {
    const TemporaryFolder folder;
    const std::string path = folder / "a.npz";

    std::string good() {
        PlainContext ctx;
        write_npz(small_buffer(), path, false, ctx);
        return bytes_in(path);
    }
    std::string says(const std::vector<Member>& members, const ReadOptions& options = {}) {
        put_npz(path, members);
        return error_reading(path, options);
    }
    std::string says_of_bytes(const std::string& bytes) {
        put_bytes(path, bytes);
        return error_reading(path);
    }
    std::string says_of_meta(const std::string& meta) {
        return says({meta_member(meta), member("xy", 2, {.5f, .5f}), member("rgb", 3, {1, 1, 1})});
    }
};

TEST_F(BrokenNpz, missing_file_and_folder) {
    EXPECT_EQ(error_reading(folder / "no.npz"),
              "cannot open '" + (folder / "no.npz") + "': No such file or directory");
    EXPECT_SAYS(error_reading(folder.path()), "is a folder; expected a file");
}

TEST_F(BrokenNpz, empty_and_foreign_files) {
    EXPECT_SAYS(says_of_bytes(""), "a.npz: the file is empty");
    EXPECT_SAYS(says_of_bytes("hello"),
                "no sample file that this program knows; expected .npz, deep EXR");
}

TEST_F(BrokenNpz, every_cut_is_an_error) {
    const std::string whole = good();
    expect_cuts_refused(whole);
    EXPECT_SAYS(says_of_bytes(whole.substr(0, whole.size() / 2)),
                "a.npz: no zip directory at its end; the file is cut short");
}

TEST_F(BrokenNpz, a_flipped_bit_in_the_data_is_found) {
    std::string bytes = good();
    const FileBytes file = map_file(path);
    for (const ZipMember& m : zip_members(file))
        if (m.name == "rgb.npy") bytes[size_t(&m.packed.back() - file.bytes.data())] ^= 0x10;
    EXPECT_SAYS(says_of_bytes(bytes), "member 'rgb.npy' has checksum");
}

TEST_F(BrokenNpz, no_single_damaged_byte_brings_it_down) {
    read_with_damaged_bytes(good());  // padding and dates may be anything
}

TEST_F(BrokenNpz, members_that_must_be_there) {
    EXPECT_SAYS(says({}), "no member 'meta'");
    EXPECT_SAYS(says({meta_member(meta_1x1)}), "no member 'xy'");
    EXPECT_SAYS(says({meta_member(meta_1x1), member("xy", 2, {.5f, .5f})}),
                "no member 'rgb'; a sample file has meta, xy, rgb and more, this has meta, xy");
    EXPECT_SAYS(says({meta_member(meta_1x1), member("xy", 2, {.5f, .5f}),
                      member("xy", 2, {.5f, .5f}), member("rgb", 3, {1, 1, 1})}),
                "two members are called 'xy'");
}

TEST_F(BrokenNpz, meta_that_cannot_be_used) {
    EXPECT_SAYS(says_of_meta("{"), "a.npz: meta");
    EXPECT_SAYS(says_of_meta("[1]"), "meta: is a list; expected an object");
    EXPECT_SAYS(says_of_meta("{}"), "meta: no 'weft_samples'");
    EXPECT_SAYS(says_of_meta(R"({"weft_samples": 2})"),
                "format version 2; this program reads version 1");
    EXPECT_SAYS(says_of_meta(R"({"weft_samples": 1, "height": 1})"), "no 'width'");
    EXPECT_SAYS(says_of_meta(R"({"weft_samples": 1, "width": 0, "height": 1})"),
                "'width' is 0; expected a whole number from 1");
    EXPECT_SAYS(says_of_meta(R"({"weft_samples": 1, "width": 1, "height": 1.5})"),
                "'height' is 1.5");
    EXPECT_SAYS(says_of_meta(R"({"weft_samples": 1, "width": 1, "height": 1, "spp": -1})"),
                "'spp' is -1");
    EXPECT_SAYS(says_of_meta(R"({"weft_samples": 1, "width": 1, "height": 1})"),
                "'spp' is null, so samples a pixel vary; then a member 'count'");
    EXPECT_SAYS(
        says_of_meta(R"({"weft_samples":1,"width":1,"height":1,"spp":1,"lens":{"coc":[1]}})"),
        "'lens' has no 'coc'; expected [C0, C1]");
    EXPECT_SAYS(says_of_meta(R"({"weft_samples":1,"width":1,"height":1,"spp":1,"domain":"moon"})"),
                "'domain' is 'moon'; expected 'camera' or 'light'");
    EXPECT_SAYS(
        says_of_meta(R"({"weft_samples":1,"width":1,"height":1,"spp":1,"roles":{"xy":"king"}})"),
        "role of 'xy' is \"king\"; expected position, random, feature, radiance or none");
}

TEST_F(BrokenNpz, counts_that_do_not_add_up) {
    const Member xy = member("xy", 2, {.5f, .5f}), rgb = member("rgb", 3, {1, 1, 1, 1, 1, 1});
    EXPECT_SAYS(says({meta_member(meta_1x1), xy, rgb}),
                "'rgb' has 2 samples; 1 x 1 pixels of 1 samples make 1");
    const std::string vary = R"({"weft_samples": 1, "width": 2, "height": 1})";
    EXPECT_SAYS(
        says({meta_member(vary), {"count", "<u4", {1, 2}, raw<std::uint32_t>({1, 3})}, xy, rgb}),
        "'xy' has 1 samples; 'count' adds up to 4");
    EXPECT_SAYS(
        says({meta_member(vary), {"count", "<u4", {2, 1}, raw<std::uint32_t>({1, 3})}, xy, rgb}),
        "'count' is u4 (2, 1); expected u4 (1, 2)");
    EXPECT_SAYS(says({meta_member(vary), {"count", "<f4", {1, 2}, raw<float>({1, 3})}, xy, rgb}),
                "'count' is f4 (1, 2); expected u4 (1, 2)");
    EXPECT_SAYS(
        says({meta_member(meta_1x1), {"count", "<u4", {1, 1}, raw<std::uint32_t>({2})}, xy, rgb}),
        "meta says 1 samples in every pixel, 'count' says 2 in pixel (0, 0)");
    EXPECT_SAYS(says({meta_member(vary),
                      {"count", "<u4", {1, 2}, raw<std::uint32_t>({0, 0})},
                      {"xy", "<f4", {0, 2}, ""},
                      {"rgb", "<f4", {0, 3}, ""}}),
                "the buffer holds no samples");
}

TEST_F(BrokenNpz, shapes_and_types) {
    const Member xy = member("xy", 2, {.5f, .5f}), rgb = member("rgb", 3, {1, 1, 1});
    const auto with = [&](const Member& m) {
        return says({meta_member(meta_1x1), xy, rgb, m}, {.channels = {"*"}});
    };
    EXPECT_SAYS(says({meta_member(meta_1x1), member("xy", 3, {1, 1, 1}), rgb}),
                "'xy' has shape (1, 3); expected (N, 2)");
    EXPECT_SAYS(with({"z", "<f4", {1, 1, 1}, raw<float>({1})}),
                "'z' has shape (1, 1, 1); expected (N,)");
    EXPECT_SAYS(with({"z", ">f4", {1}, raw<float>({1})}),
                "'z' is big-endian ('>f4'); save it with .astype('<f4')");
    EXPECT_SAYS(with({"z", "|O", {1}, "12345678"}), "'z' is an array of Python objects");
    EXPECT_SAYS(with({"z", "<i8", {1}, "12345678"}),
                "'z' has type '<i8'; expected f2, f4, f8, u1, u2 or u4");
    EXPECT_SAYS(with({"z", "<f4", {2}, raw<float>({1})}),
                "'z' says it is (2,) numbers of 4 bytes but holds 4 bytes");
    EXPECT_SAYS(with({"id", "<f4", {1}, raw<float>({1})}),
                "'id' is of type f4; expected whole numbers");
}

TEST_F(BrokenNpz, huge_claims_allocate_nothing) {
    const Member rgb = member("rgb", 3, {1, 1, 1});
    const std::uint64_t huge = std::uint64_t(1) << 61;
    EXPECT_SAYS(says({meta_member(meta_1x1), {"xy", "<f4", {huge, 2}, "12345678"}, rgb}),
                "says it is (2305843009213693952, 2) numbers of 4 bytes but holds 8 bytes");
    EXPECT_SAYS(
        says({meta_member(
                  R"({"weft_samples":1,"width":1000000000,"height":1000000000,"spp":1000000000})"),
              member("xy", 2, {.5f, .5f}), rgb}),
        "are more than any file holds");
    EXPECT_SAYS(says({meta_member(R"({"weft_samples":1,"width":1000000,"height":1000000,"spp":1})"),
                      member("xy", 2, {.5f, .5f}), rgb}),
                "'xy' has 1 samples");
}

TEST_F(BrokenNpz, a_member_cannot_claim_more_than_its_bytes_can_hold) {
    const Samples s = small_buffer();
    std::vector<Member> members{meta_member(s.meta_object().dump())};
    for (const Channel& c : s.channels)
        members.push_back(member(c.name, c.components, std::vector<float>(c.values.size(), 0.5f)));
    put_npz(path, members, true);
    std::string bytes = bytes_in(path);
    const size_t central = bytes.rfind("rgb.npy") - 46;
    const std::uint32_t size = 0xfffffff0;
    std::memcpy(&bytes[central + 24], &size, 4);
    EXPECT_SAYS(says_of_bytes(bytes),
                "member 'rgb.npy' says that it holds 4294967280 bytes, which");
}

TEST_F(BrokenNpz, zips_of_other_kinds) {
    std::string bytes = good();
    const size_t central = bytes.rfind("meta.npy") - 46;
    std::string locked = bytes;
    locked[central + 8] |= 1;
    EXPECT_SAYS(says_of_bytes(locked), "member 'meta.npy' is encrypted");
    std::string other = bytes;
    other[central + 10] = 14;
    EXPECT_SAYS(says_of_bytes(other),
                "member 'meta.npy' is packed by method 14; expected stored or deflate");
    std::string part = bytes;
    part[bytes.size() - 18] = 1;
    EXPECT_SAYS(says_of_bytes(part), "one part of a zip over several files");
    std::string twice = bytes;  // two members on the same bytes
    const size_t xy = bytes.rfind("xy.npy") - 46, uv = bytes.rfind("uv.npy") - 46;
    std::memcpy(&twice[uv + 42], &bytes[xy + 42], 4);
    EXPECT_SAYS(says_of_bytes(twice), "member 'xy.npy' is called 'uv.npy' in the directory");
}

}  // namespace
}  // namespace weft::testing
