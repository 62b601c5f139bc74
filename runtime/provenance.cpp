#include "runtime/provenance.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

namespace weft {

const char* const program_version = WEFT_VERSION;

namespace {

// Offset of a zip's central directory, or -1: read from the end record (and its 64-bit form).
std::int64_t zip_directory(std::ifstream& file, std::uint64_t size) {
    char head[4] = {};
    file.read(head, 4);
    if (file.gcount() != 4 || std::memcmp(head, "PK\3\4", 4) != 0) return -1;
    const std::uint64_t tail = std::min<std::uint64_t>(size, 65557);
    std::vector<unsigned char> end(tail);
    file.seekg(std::streamoff(size - tail));
    file.read(reinterpret_cast<char*>(end.data()), std::streamsize(tail));
    if (std::uint64_t(file.gcount()) != tail) return -1;
    for (size_t i = tail < 22 ? 0 : tail - 22 + 1; i-- > 0;) {
        if (std::memcmp(&end[i], "PK\5\6", 4) != 0) continue;
        std::uint32_t offset;
        std::memcpy(&offset, &end[i + 16], 4);
        if (offset != 0xffffffffu) return offset < size ? std::int64_t(offset) : -1;
        // 64-bit: the last megabyte holds any directory's end that we hash; start at its own record.
        return std::int64_t(size - tail);
    }
    return -1;
}

}  // namespace

std::string content_hash(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw Error(fmt::format("{}: cannot open it to read", path));
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(path, error);
    const std::int64_t start = error ? -1 : zip_directory(file, size);
    file.clear();
    file.seekg(start > 0 ? std::streamoff(start) : 0);
    XXH3_state_t* state = XXH3_createState();
    XXH3_64bits_reset(state);
    std::vector<char> block(1 << 16);
    while (file.read(block.data(), std::streamsize(block.size())) || file.gcount() > 0)
        XXH3_64bits_update(state, block.data(), size_t(file.gcount()));
    const std::uint64_t hash = XXH3_64bits_digest(state);
    XXH3_freeState(state);
    return fmt::format("{:016x}", hash);
}

std::vector<std::string> files_of(const Plan& plan, int node) {
    const GraphNode& n = plan.graph->nodes[size_t(node)];
    std::vector<std::string> files;
    for (size_t p = 0; p < n.params.size(); ++p)
        if (n.type->params[p].use == FileUse::read && !n.params[p].text.empty()) files.push_back(n.params[p].text);
    if (const auto& instance = plan.instances[size_t(node)])
        for (std::string& more : instance->reads()) files.push_back(std::move(more));
    return files;
}

FilesRead files_read(const Plan& plan) {
    FilesRead files;
    for (size_t n = 0; n < plan.graph->nodes.size(); ++n)
        for (const std::string& path : files_of(plan, int(n))) {
            if (files.count(path)) continue;
            FileContent& content = files[path];
            std::error_code error;
            if (const std::uint64_t size = std::filesystem::file_size(path, error); !error) content = {size, content_hash(path)};
        }
    return files;
}

Provenance make_provenance(const Plan& plan, const FilesRead& files) {
    Provenance provenance;
    provenance.graph = plan.graph->flattened().dump(false);
    provenance.version = program_version;
    Json inputs = Json::list();
    for (const auto& [path, content] : files) {
        Json one = Json::object();
        one.set("path", path);
        if (!content.hash.empty()) {
            one.set("size", content.size);
            one.set("xxh3", content.hash);
        }
        inputs.items.push_back(std::move(one));
    }
    provenance.inputs = inputs.dump(false);
    return provenance;
}

}  // namespace weft
