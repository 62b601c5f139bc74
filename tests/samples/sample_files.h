// What the tests of sample files share: a folder that goes away, small buffers, files made by hand.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include "graph/error.h"
#include "runtime/context.h"
#include "samples/npy.h"
#include "samples/sample_file.h"
#include "samples/samples.h"
#include "samples/zip_writer.h"

namespace weft::testing {

class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::string pattern =
            (std::filesystem::temp_directory_path() / "weft-samples-XXXXXX").string();
        if (!::mkdtemp(pattern.data())) throw Error("no temporary folder");
        path_ = pattern;
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    std::string operator/(const std::string& name) const { return path_ + "/" + name; }
    const std::string& path() const { return path_; }

  private:
    std::string path_;
};

inline std::string bytes_in(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}
inline void put_bytes(const std::string& path, std::string_view bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

// A file that is only in memory; `bytes` must outlive it.
inline FileBytes file_of(const std::string& bytes, std::string name = "a") {
    return {std::move(name),
            {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()},
            nullptr,
            false};
}

constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// Good samples: positions in their pixels, lens positions in the disk, some background.
inline Samples small_buffer(int width = 4, int height = 3, int spp = 2) {
    Samples s;
    s.width = width;
    s.height = height;
    s.spp = spp;
    s.lens = Lens{.c0 = -35.0849527f, .c1 = 4.07964549f};
    const size_t n = size_t(width) * size_t(height) * size_t(spp);
    s.set_size(n);
    std::vector<float> xy, uv, t, z, motion, rgb;
    std::uint32_t state = 1;
    const auto random = [&] {
        state = state * 1664525u + 1013904223u;
        return float(state >> 8) * 0x1p-24f;
    };
    for (size_t i = 0; i < n; ++i) {
        const size_t pixel = i / size_t(spp);
        xy.insert(xy.end(), {float(pixel % size_t(width)) + random(),
                             float(pixel / size_t(width)) + random()});
        uv.insert(uv.end(), {1.4f * random() - 0.7f, 1.4f * random() - 0.7f});
        t.push_back(random());
        z.push_back(i % 5 == 4 ? inf : 1 + 9 * random());
        for (int k = 0; k < 3; ++k) motion.push_back(i % 5 == 4 ? 0 : 20 * random() - 10);
        for (int k = 0; k < 3; ++k) rgb.push_back(4 * random() * random());
    }
    s.add("xy", 2, xy);
    s.add("uv", 2, uv);
    s.add("t", 1, t);
    s.add("z", 1, z);
    s.add("motion", 3, motion);
    s.add("rgb", 3, rgb);
    return s;
}

// Everything a buffer can have.
inline Samples rich_buffer() {
    Samples s = small_buffer();
    std::vector<float> alpha, weight, albedo, thing;
    std::vector<std::uint32_t> id;
    for (size_t i = 0; i < s.size(); ++i) {
        alpha.push_back(std::isinf(s.z()[i]) ? 0.0f : 1.0f);
        weight.push_back(0.5f + float(i));
        for (int k = 0; k < 3; ++k) albedo.push_back(float(i + size_t(k)) / 30);
        for (int k = 0; k < 5; ++k) thing.push_back(float(i) - float(k));
        id.push_back(0xfffffff0u + std::uint32_t(i % 8));
    }
    s.add("alpha", 1, alpha);
    s.add("weight", 1, weight);
    s.add("z_gradient", 2, std::vector<float>(2 * s.size(), 0.25f));
    s.add("albedo", 3, albedo);
    s.add("five_things", 5, thing);
    s.add_ids("id", id);
    s.meta = Json::object();
    s.meta.set("source", "made by a test");
    s.meta.set("shutter", Json::list({Json(0.0), Json(0.5)}));
    s.channels.back().role = Role::feature;  // id, against its standard
    return s;
}

inline Samples read_file(const std::string& path,
                         const ReadOptions& options = {.channels = {"*"}}) {
    PlainContext ctx;
    Samples s = read_sample_file(map_file(path), options, ctx);
    EXPECT_TRUE(ctx.warnings.empty()) << ctx.warnings[0];
    return s;
}

// Bit for bit; channels in any order.
inline void expect_equal(const Samples& a, const Samples& b) {
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.height, b.height);
    EXPECT_EQ(a.spp, b.spp);
    EXPECT_EQ(a.size(), b.size());
    EXPECT_EQ(a.color_space, b.color_space);
    EXPECT_EQ(a.domain, b.domain);
    EXPECT_EQ(a.lens, b.lens);
    EXPECT_TRUE(std::ranges::equal(a.first.view(), b.first.view()));
    EXPECT_EQ(a.channels.size(), b.channels.size());
    for (const Channel& c : a.channels) {
        const Channel* d = b.find(c.name);
        ASSERT_TRUE(d) << c.name;
        EXPECT_EQ(c.components, d->components) << c.name;
        EXPECT_EQ(c.role, d->role) << c.name;
        ASSERT_EQ(c.values.size(), d->values.size()) << c.name;
        EXPECT_TRUE(c.values.empty() ||
                    0 == std::memcmp(c.values.view().data(), d->values.view().data(),
                                     c.values.view().size_bytes()))
            << c.name;
        EXPECT_TRUE(std::ranges::equal(c.ids.view(), d->ids.view())) << c.name;
    }
}

// The message of the Error that `action` throws; "" with a failure if it throws none.
template <class Action>
std::string error_of(Action&& action) {
    try {
        action();
    } catch (const Error& error) {
        return error.what();
    }
    ADD_FAILURE() << "no error";
    return "";
}
inline std::string error_reading(const std::string& path, const ReadOptions& options = {}) {
    PlainContext ctx;
    return error_of([&] { read_sample_file(map_file(path), options, ctx); });
}

// Every byte of `good` turned over, one at a time: the reader may take it or refuse it.
inline void read_with_damaged_bytes(const std::string& good) {
    for (size_t at = 0; at < good.size(); ++at) {
        std::string bytes = good;
        bytes[at] = char(bytes[at] ^ 0xff);
        PlainContext ctx;
        try {
            read_sample_file(file_of(bytes), {}, ctx);
        } catch (const Error&) {
        }
    }
}
// Every beginning of `good` is refused.
inline void expect_cuts_refused(const std::string& good) {
    for (size_t size = 0; size < good.size(); ++size) {
        const std::string bytes = good.substr(0, size);
        PlainContext ctx;
        EXPECT_THROW(read_sample_file(file_of(bytes), {}, ctx), Error) << size;
    }
}

#define EXPECT_SAYS(text, part) \
    EXPECT_NE(std::string(text).find(part), std::string::npos) << "says: " << (text)

// An .npz by hand: each member is a header and its bytes.
struct Member {
    std::string name, descr;
    std::vector<std::uint64_t> shape;
    std::string bytes;
};
template <class T>
std::string raw(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}
inline Member member(std::string name, int components, const std::vector<float>& values) {
    std::vector<std::uint64_t> shape{values.size() / size_t(components)};
    if (components > 1) shape.push_back(size_t(components));
    return {std::move(name), "<f4", shape, raw(values)};
}
inline Member meta_member(const std::string& text) {
    return {"meta", "|u1", {text.size()}, text};
}
inline void put_npz(const std::string& path, const std::vector<Member>& members,
                    bool deflate = false, std::uint64_t zip64_from = 0xffffffff) {
    ZipWriter zip(path, zip64_from);
    for (const Member& m : members) {
        ZipPiece piece{m.name + ".npy",
                       npy_header(m.descr, m.shape),
                       {reinterpret_cast<const std::uint8_t*>(m.bytes.data()), m.bytes.size()},
                       {},
                       0};
        finish(piece, deflate);
        zip.add(piece);
    }
    zip.close();
}

}  // namespace weft::testing
