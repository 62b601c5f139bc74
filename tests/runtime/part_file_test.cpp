// Part files: what was put in comes out, and damage is found wherever it is.
#include "runtime/part_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace weft {
namespace {

class PartFiles : public testing::Test {
  protected:
    PartFiles() : path((std::filesystem::path(testing::TempDir()) / "weft-a.part").string()) {
        PartWriter part(path);
        ByteWriter bytes;
        bytes.put_text("seven");
        part.add(0, 1, 7, bytes.bytes());
        bytes.clear();
        bytes.put_all(std::vector<float>{1, 2, 3});
        part.add(0, 0, 2, bytes.bytes());
        PartHeader header;
        header.shard = {3, 5};
        header.key = "abc";
        header.isa = "v2";
        header.provenance = {"{}", "[]", "0"};
        header.graph_name = "g.json";
        header.files["out"] = "a \"quoted\".exr";
        header.shapes["a.b"] = {4, 5, 6, 7, 8};
        header.tasks = {{"source", "source ... sink", {100, 50}, 8, {"sink", "other"}}};
        part.finish(header);
    }
    ~PartFiles() override { std::filesystem::remove(path); }
    std::string bytes() const {
        std::ifstream file(path, std::ios::binary);
        std::stringstream text;
        text << file.rdbuf();
        return text.str();
    }
    void put(const std::string& text) { std::ofstream(path, std::ios::binary) << text; }
    std::string path;
};

TEST_F(PartFiles, GiveBackWhatWasPutIn) {
    const PartFile part(path);
    EXPECT_EQ(part.header().shard, (Shard{3, 5}));
    EXPECT_EQ(part.header().files.at("out"), "a \"quoted\".exr");
    EXPECT_EQ(part.header().shapes.at("a.b").records, 7);
    ASSERT_EQ(part.header().tasks.size(), 1u);
    EXPECT_EQ(part.header().tasks[0].sinks, (std::vector<std::string>{"sink", "other"}));
    EXPECT_EQ(part.read(0, 1, 7).take_text(), "seven");
    ByteReader numbers = part.read(0, 0, 2);
    std::vector<float> three(3);
    numbers.fill(three);
    EXPECT_EQ(three, (std::vector<float>{1, 2, 3}));
    EXPECT_EQ(numbers.left(), 0u);
    EXPECT_THROW(part.read(0, 0, 3), Error);
}

TEST_F(PartFiles, EveryCutAndEveryFlippedByteIsFoundOrChangesNothing) {
    const std::string whole = bytes();
    for (size_t size = 0; size < whole.size(); ++size) {
        put(whole.substr(0, size));
        EXPECT_THROW(PartFile{path}, Error) << size;
    }
    for (size_t at = 0; at < whole.size(); ++at) {
        std::string wrong = whole;
        wrong[at] = char(wrong[at] ^ 0x5a);
        put(wrong);
        EXPECT_THROW(
            {
                const PartFile part(path);
                part.read(0, 1, 7);
                part.read(0, 0, 2);
            },
            Error)
            << at;
    }
}

TEST(Bytes, ThatDoNotFitAreAnError) {
    const auto reader = [](const ByteWriter& bytes) {
        return ByteReader({bytes.bytes().begin(), bytes.bytes().end()});
    };
    ByteWriter bytes;
    bytes.put(std::uint64_t{1} << 62);  // an array without end
    EXPECT_THROW(reader(bytes).take_all<double>(), Error);
    EXPECT_THROW(reader(bytes).take_text(), Error);
    std::vector<float> two(2);
    EXPECT_THROW(reader(bytes).fill(two), Error);
    bytes.clear();
    bytes.put_all(std::vector<float>{1});
    EXPECT_THROW(reader(bytes).fill(two), Error);
    EXPECT_THROW(ByteReader({}).take<int>(), Error);
}

}  // namespace
}  // namespace weft
