// A stored, aligned .npz is used where it lies: reading it is no memory of ours.
#include <sys/stat.h>
#include <sys/statvfs.h>

#include "sample_files.h"
#include "samples/write_npz.h"
#include "tests/mapped_bytes.h"

namespace weft::testing {
namespace {

// Anonymous memory of this process, bytes.
double anonymous_bytes() {
    std::ifstream status("/proc/self/status");
    std::string line;
    while (std::getline(status, line))
        if (line.starts_with("RssAnon:")) return std::stod(line.substr(8)) * 1024;
    return -1;
}

TEST(Memory, a_mapped_buffer_of_240_MB_adds_less_than_16_MB) {
    const TemporaryFolder folder;
    if (anonymous_bytes() < 0) GTEST_SKIP() << "no RssAnon in /proc/self/status";
    struct statvfs space {};
    if (::statvfs(folder.path().c_str(), &space) != 0 || space.f_bavail * space.f_frsize < 600e6)
        GTEST_SKIP() << "less than 600 MB free in the temporary folder";
    {
        // 12 floats a sample, 5.2 million samples; channels share memory with a plain pattern.
        const int width = 1024, height = 640, spp = 8;
        PlainContext ctx;
        write_npz(small_buffer(width, height, spp), folder / "a.npz", false, ctx);
    }
    struct stat info {};
    ASSERT_EQ(::stat((folder / "a.npz").c_str(), &info), 0);
    ASSERT_GT(info.st_size, 240e6);
    PlainContext ctx;
    const double before = anonymous_bytes();
    const Samples s = read_sample_file(map_file(folder / "a.npz"), {}, ctx);
    double added = anonymous_bytes() - before;
#ifdef __SANITIZE_ADDRESS__
    added -= double(info.st_size) / 8;  // its shadow of what is mapped
#endif
    EXPECT_EQ(s.size(), size_t(1024) * 640 * 8);
    EXPECT_LT(added, 16e6);
}

TEST(Memory, what_is_copied_from_a_mapped_file_is_there_once) {
    const TemporaryFolder folder;
    if (mapped_bytes() < 0) GTEST_SKIP() << "no RssFile in /proc/self/status";
    PlainContext ctx;
    write_npz(small_buffer(512, 320, 8), folder / "a.npz", false, ctx);
    std::string moved(1, 'x');
    moved += bytes_in(folder / "a.npz");
    put_bytes(folder / "odd.npz", moved);
    FileBytes odd = map_file(folder / "odd.npz");
    odd.bytes = odd.bytes.subspan(1);
    const double before = mapped_bytes();
    const Samples s = read_sample_file(odd, {}, ctx);
    EXPECT_EQ(s.size(), size_t(512) * 320 * 8);
    ASSERT_GT(double(odd.bytes.size()), 60e6);
    EXPECT_LT(mapped_bytes() - before, 0.1 * double(odd.bytes.size()));
}

}  // namespace
}  // namespace weft::testing
