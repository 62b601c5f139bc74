// A file is there whole or not at all.
#include "runtime/atomic_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "graph/error.h"

namespace weft {
namespace {
namespace fs = std::filesystem;

fs::path fresh_folder(const std::string& name) {
    const fs::path folder = fs::path(testing::TempDir()) / ("atomic_" + name);
    fs::remove_all(folder);
    fs::create_directories(folder);
    return folder;
}

size_t files_in(const fs::path& folder) { return size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator())); }

TEST(AtomicFile, AppearsOnCommitAndNotBefore) {
    const fs::path folder = fresh_folder("commit");
    AtomicFile file((folder / "new" / "a.txt").string());  // folders are made
    std::ofstream(file.temporary()) << "whole";
    EXPECT_FALSE(fs::exists(file.path()));
    file.commit();
    EXPECT_EQ(fs::file_size(file.path()), 5u);
    EXPECT_EQ(files_in(folder / "new"), 1u);
}

TEST(AtomicFile, LeavesNothingBehindWithoutCommit) {
    const fs::path folder = fresh_folder("abandon");
    std::ofstream(folder / "a.txt") << "old";
    {
        AtomicFile file((folder / "a.txt").string());
        std::ofstream(file.temporary()) << "half";
    }
    EXPECT_EQ(files_in(folder), 1u);
    EXPECT_EQ(fs::file_size(folder / "a.txt"), 3u);  // what was there stays
}

TEST(AtomicFile, SaysWhyAFileCannotBeWritten) {
    const fs::path folder = fresh_folder("refused");
    const auto message = [](const std::string& path) -> std::string {
        try {
            write_file(path, "x");
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(message(folder.string()), folder.string() + ": is a folder; name a file in it");
    std::ofstream(folder / "plain") << "x";
    EXPECT_NE(message((folder / "plain" / "a.txt").string()).find("cannot make its folder"), std::string::npos);
    EXPECT_EQ(message(""), "no name given for a file to write");
}

}  // namespace
}  // namespace weft
