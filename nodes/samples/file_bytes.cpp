#include "samples/file_bytes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>

#include "graph/error.h"

namespace weft {
namespace {

// The mappings that there are: where each begins, and how long it is.
struct Mappings {
    std::mutex mutex;
    std::map<std::uintptr_t, size_t> size_of;
};
Mappings& mappings() {
    static Mappings& all = *new Mappings;  // outlives whatever is still mapped at the end
    return all;
}

std::shared_ptr<const void> kept(void* where, size_t size) {
    const auto from = reinterpret_cast<std::uintptr_t>(where);
    {
        const std::lock_guard lock(mappings().mutex);
        mappings().size_of[from] = size;
    }
    return {where, [from, size](const void* p) {
                const std::lock_guard lock(mappings().mutex);
                mappings().size_of.erase(from);
                ::munmap(const_cast<void*>(p), size);
            }};
}

}  // namespace

FileBytes map_file(const std::string& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) throw Error(fmt::format("cannot open '{}': {}", path, std::strerror(errno)));
    struct Closer {
        int fd;
        ~Closer() { ::close(fd); }
    } closer{fd};
    struct stat info {};
    if (::fstat(fd, &info) != 0)
        throw Error(fmt::format("cannot read '{}': {}", path, std::strerror(errno)));
    if (S_ISDIR(info.st_mode)) throw Error(fmt::format("'{}' is a folder; expected a file", path));
    if (!S_ISREG(info.st_mode))
        throw Error(fmt::format("'{}' is not a plain file; copy it to one first", path));
    FileBytes file{path, {}, nullptr, true};
    const auto size = size_t(info.st_size);
    if (size == 0) return file;
    void* where = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (where == MAP_FAILED)
        throw Error(fmt::format("cannot map '{}': {}", path, std::strerror(errno)));
    file.owner = kept(where, size);
    file.bytes = {static_cast<const std::uint8_t*>(where), size};
    return file;
}

void forget_pages(std::span<const std::uint8_t> bytes) {
    const auto page = std::uintptr_t(::sysconf(_SC_PAGESIZE));
    const auto begin = reinterpret_cast<std::uintptr_t>(bytes.data()), end = begin + bytes.size();
    const std::uintptr_t first = (begin + page - 1) / page * page, last = end / page * page;
    if (first >= last) return;
    const std::lock_guard lock(mappings().mutex);
    auto mapping = mappings().size_of.upper_bound(begin);
    if (mapping == mappings().size_of.begin()) return;
    --mapping;
    if (end <= mapping->first + mapping->second)
        ::madvise(reinterpret_cast<void*>(first), last - first, MADV_DONTNEED);
}

}  // namespace weft
