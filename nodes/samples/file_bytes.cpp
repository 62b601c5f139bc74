#include "samples/file_bytes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "graph/error.h"

namespace weft {

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
    file.owner = std::shared_ptr<const void>(
        where, [size](const void* p) { ::munmap(const_cast<void*>(p), size); });
    file.bytes = {static_cast<const std::uint8_t*>(where), size};
    return file;
}

}  // namespace weft
