#include "runtime/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "graph/error.h"

namespace weft {
namespace {

[[noreturn]] void fail(const std::string& path, const char* what, int error) {
    throw Error(fmt::format("{}: cannot {}: {}", path, what, std::strerror(error)));
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
    namespace fs = std::filesystem;
    if (path_.empty()) throw Error("no name given for a file to write");
    std::error_code error;
    if (fs::is_directory(path_, error)) throw Error(fmt::format("{}: is a folder; name a file in it", path_));
    if (const fs::path folder = fs::path(path_).parent_path(); !folder.empty()) {
        fs::create_directories(folder, error);
        if (error) fail(path_, "make its folder", error.value());
    }
    static std::atomic<unsigned> serial = 0;
    temporary_ = fmt::format("{}.{}.{}.part", path_, ::getpid(), ++serial);
    const int file = ::open(temporary_.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    if (file < 0) fail(path_, "write there", errno);
    ::close(file);
}

AtomicFile::~AtomicFile() {
    if (!done_) ::unlink(temporary_.c_str());
}

void AtomicFile::commit() {
    const int file = ::open(temporary_.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) fail(path_, "read back what was written", errno);
    const int synced = ::fsync(file) == 0 || errno == EINVAL ? 0 : errno;
    ::close(file);
    if (synced) fail(path_, "write it to the disk", synced);
    if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail(path_, "put it in place", errno);
    done_ = true;
}

void write_file(const std::string& path, std::string_view bytes) {
    AtomicFile file(path);
    const int out = ::open(file.temporary().c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC);
    if (out < 0) fail(path, "write it", errno);
    while (!bytes.empty()) {
        const ssize_t wrote = ::write(out, bytes.data(), bytes.size());
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote < 0) {
            const int error = errno;
            ::close(out);
            fail(path, "write it", error);
        }
        bytes.remove_prefix(size_t(wrote));
    }
    if (::close(out) != 0) fail(path, "write it", errno);
    file.commit();
}

}  // namespace weft
