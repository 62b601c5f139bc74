// FileBytes: what a file holds, where it lies. A file on disk is mapped, so that nothing is read
// before it is looked at and what is looked at is no memory of ours; tests and fuzzers bring bytes.
// A file that somebody cuts short while it is mapped ends the program (SIGBUS), as with any
// mapping; files that Weft writes are replaced whole and never cut.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace weft {

struct FileBytes {
    std::string name;  // for messages; where readers look for a sibling
    std::span<const std::uint8_t> bytes;
    std::shared_ptr<const void> owner;  // keeps `bytes` there; null: the caller does
    bool on_disk = false;               // `name` is a path

    std::string_view text() const {
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
};

// Throws Error naming the path and the system's reason.
FileBytes map_file(const std::string& path);

// The pages that lie wholly in these bytes, where they are of a mapped file: they are no more of
// the process's memory until they are looked at again. All else stays as it is. Safe while others
// read.
void forget_pages(std::span<const std::uint8_t> bytes);
inline void forget_pages(std::span<const float> values) {
    forget_pages(
        std::span(reinterpret_cast<const std::uint8_t*>(values.data()), values.size_bytes()));
}

}  // namespace weft
