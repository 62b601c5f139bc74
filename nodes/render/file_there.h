// Whether a scene's name for a file is that of one. A name that no file can have (too long, say) is
// not, where the standard library's plain question throws.
#pragma once
#include <filesystem>

namespace weft {

inline bool file_there(const std::filesystem::path& path) {
    std::error_code none;
    return std::filesystem::is_regular_file(path, none);
}

}  // namespace weft
