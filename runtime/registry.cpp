#include "runtime/registry.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace weft {
namespace {

std::map<std::string, Saver, std::less<>>& savers() {
    static std::map<std::string, Saver, std::less<>> table;
    return table;
}

}  // namespace

Registry& Registry::instance() {
    static Registry registry;
    return registry;
}

const NodeType* Registry::type(std::string_view type) const {
    const auto found = types_.find(type);
    return found == types_.end() ? nullptr : found->second.get();
}

const NodeDecl* Registry::find(std::string_view name) const {
    const NodeType* found = type(name);
    return found ? &found->decl() : nullptr;
}

std::vector<const NodeDecl*> Registry::all() const {
    std::vector<const NodeDecl*> decls;
    for (const auto& [name, type] : types_) decls.push_back(&type->decl());
    std::stable_sort(decls.begin(), decls.end(),
                     [](const NodeDecl* a, const NodeDecl* b) { return a->family < b->family; });
    return decls;
}

std::string_view Registry::option_of(std::string_view name) const {
    const auto found = options_.find(name);
    return found == options_.end() ? std::string_view() : found->second;
}

bool Registry::note_option(const std::string& option, const std::vector<std::string>& types) {
    for (const std::string& name : types) options_.emplace(name, option);
    return true;
}

const TypeInfo* Registry::type_info(std::string_view name) const {
    const auto found = infos_.find(name);
    return found == infos_.end() ? nullptr : found->second;
}

bool Registry::add(std::unique_ptr<NodeType> type) {
    const std::string name = type->decl().type;
    const auto [place, added] = types_.emplace(name, std::move(type));
    if (!added) conflicts_.push_back(fmt::format("two node types are called '{}'; the first is used", name));
    return added;
}

bool Registry::add(std::unique_ptr<FusionType> type) {
    const auto place = std::upper_bound(fusions_.begin(), fusions_.end(), type, [](const auto& a, const auto& b) {
        return a->decl().name < b->decl().name;
    });
    fusions_.insert(place, std::move(type));
    return true;
}

void Registry::note(const TypeInfo& info) { infos_.emplace(std::string(info.name), &info); }

bool register_fusion(std::unique_ptr<FusionType> type) { return Registry::instance().add(std::move(type)); }

bool register_node(std::unique_ptr<NodeType> type) { return Registry::instance().add(std::move(type)); }

void load_node_libraries(const std::string& folder) {
    namespace fs = std::filesystem;
    std::error_code error;
    if (!fs::is_directory(folder, error))
        throw Error(fmt::format("{}: no such folder of node libraries (--nodes, WEFT_NODES)", folder));
    std::vector<fs::path> libraries;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        if (entry.path().extension() == ".so") libraries.push_back(entry.path());
    std::sort(libraries.begin(), libraries.end());
    for (const fs::path& library : libraries)
        if (!dlopen(fs::absolute(library).c_str(), RTLD_NOW | RTLD_GLOBAL)) {
            const char* reason = dlerror();
            throw Error(fmt::format("{}: cannot load this node library: {}", library.string(),
                                    reason ? reason : "unknown reason"));
        }
}

bool register_saver(std::string_view type, Saver saver) {
    return savers().emplace(std::string(type), saver).second;
}

Saver saver_of(std::string_view type) {
    const auto found = savers().find(type);
    return found == savers().end() ? nullptr : found->second;
}

}  // namespace weft
