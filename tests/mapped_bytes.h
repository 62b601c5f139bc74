// Memory of this process that mapped files make up, bytes; below 0 where the system does not tell.
#pragma once
#include <fstream>
#include <string>

namespace weft {

inline double mapped_bytes() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("RssFile:")) return std::stod(line.substr(8)) * 1024;
    return -1;
}

}  // namespace weft
