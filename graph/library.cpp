#include "graph/library.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

namespace weft::loading {
namespace fs = std::filesystem;

bool read_text_file(const std::string& path, std::string& text, std::string& problem) {
    constexpr std::uintmax_t largest = 64u << 20;  // a graph is text that people write
    std::error_code code;
    const fs::file_status status = fs::status(path, code);
    if (!fs::exists(status)) {
        problem = code && code != std::errc::no_such_file_or_directory ? code.message()
                                                                       : "there is no such file";
        return false;
    }
    if (!fs::is_regular_file(status)) {
        problem = fs::is_directory(status) ? "it is a folder" : "it is no plain file";
        return false;
    }
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                               &std::fclose);
    if (!file) {
        problem = std::strerror(errno);
        return false;
    }
    char buffer[1 << 16];
    text.clear();
    while (const size_t n = std::fread(buffer, 1, sizeof buffer, file.get())) {
        text.append(buffer, n);
        if (text.size() > largest) {
            problem = "it is larger than 64 MB";
            return false;
        }
    }
    if (std::ferror(file.get())) {
        problem = std::strerror(errno);
        return false;
    }
    return true;
}

const Document* Library::file(const std::string& path, std::string& problem) {
    std::error_code code;
    std::string canonical = fs::weakly_canonical(path, code).string();
    if (code) canonical = path;
    if (const auto known = read_.find(canonical); known != read_.end()) return known->second;
    std::string text;
    if (!read_text_file(path, text, problem)) return nullptr;
    return &add(std::move(text), path, canonical);
}

const Document& Library::text(std::string text, const std::string& name) {
    std::error_code code;
    std::string canonical = fs::weakly_canonical(name, code).string();
    return add(std::move(text), name, code ? name : canonical);
}

const Document& Library::add(std::string text, const std::string& name,
                             const std::string& canonical) {
    const auto source = std::make_shared<const Source>(Source{name, std::move(text)});
    Document& document = table_.documents.emplace_back(read_document(source, findings_));
    document.folder = fs::path(name).parent_path().string();
    document.canonical = canonical;
    read_[canonical] = &document;
    return document;
}

}  // namespace weft::loading
