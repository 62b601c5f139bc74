// AtomicFile: a file that is there whole or not at all. It is written under a temporary name beside
// its place ("out.exr.1234.part"), synced and renamed; if commit() is never reached, it is removed.
#pragma once
#include <string>
#include <string_view>

namespace weft {

class AtomicFile {
  public:
    // Makes missing folders. Throws Error naming the path and the system's reason.
    explicit AtomicFile(std::string path);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    const std::string& temporary() const { return temporary_; }  // write here
    const std::string& path() const { return path_; }
    void commit();  // sync, rename; throws Error (disk full, no permission ...)

  private:
    std::string path_, temporary_;
    bool done_ = false;
};

// A whole small file at once.
void write_file(const std::string& path, std::string_view bytes);

}  // namespace weft
