#include "image/other_formats.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <mutex>

#include "graph/error.h"

namespace weft {
namespace {

constexpr const char* module_name = "weft_oiio.so";

std::vector<std::string> places() {
    std::vector<std::string> folders;
    if (const char* set = std::getenv("WEFT_MODULES")) folders.emplace_back(set);
    const auto add = [&](const std::filesystem::path& folder) {
        folders.push_back(folder.string());
        folders.push_back((folder / "weft").string());
    };
    // A function of the shared library weft_types: modules are put beside it.
    Dl_info here = {};
    const auto library =
        reinterpret_cast<const void*>(static_cast<Image (*)(const Image&)>(&Image::like));
    if (dladdr(library, &here) && here.dli_fname)
        add(std::filesystem::path(here.dli_fname).parent_path());
    std::error_code none;
    const auto program = std::filesystem::read_symlink("/proc/self/exe", none);
    if (!none) {
        add(program.parent_path());
        add(program.parent_path() / "lib");
        add(program.parent_path().parent_path() / "lib");
    }
    return folders;
}

}  // namespace

const std::vector<std::string>& other_extensions() {
    static const std::vector<std::string> names = {"bmp", "hdr", "jpeg", "jpg", "ppm",
                                                   "tga", "tif", "tiff", "webp"};
    return names;
}

void* oiio_entry(const std::string& what, const char* name) {
    static std::mutex lock;
    static void* library = nullptr;
    static std::string path;
    const std::lock_guard guard(lock);
    if (!library) {
        const std::vector<std::string> folders = places();
        for (const std::string& folder : folders) {
            path = (std::filesystem::path(folder) / module_name).string();
            if (!std::filesystem::exists(path)) continue;
            library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
            if (!library)
                throw Error(
                    fmt::format("{}: the module {} cannot be loaded: {}", what, path, dlerror()));
            break;
        }
        if (!library)
            throw Error(
                fmt::format("{}: textures, and formats other than EXR, PNG and PFM, need "
                            "the module {}, which is not in {}; set WEFT_MODULES to its "
                            "folder",
                            what, module_name, fmt::join(folders, ", ")));
    }
    void* entry = dlsym(library, name);
    if (!entry) throw Error(fmt::format("{}: {} is not a module of this program", what, path));
    return entry;
}

const OtherFormats& other_formats(const std::string& what) {
    static const OtherFormats* const formats =
        reinterpret_cast<const OtherFormats* (*)()>(oiio_entry(what, "weft_other_formats"))();
    return *formats;
}

}  // namespace weft
