// Registry: the node types of this process, and the types of values and streams they speak of.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "runtime/fusion.h"
#include "runtime/node.h"

namespace weft {

class Registry final : public Catalog {
  public:
    static Registry& instance();

    const NodeDecl* find(std::string_view type) const override;
    std::vector<const NodeDecl*> all() const override;
    std::string_view option_of(std::string_view type) const override;

    const NodeType* type(std::string_view type) const;
    const TypeInfo* type_info(std::string_view name) const;  // of a value or stream

    // Node types registered under a name that was taken: "'x' of libmine.so: the name is taken".
    const std::vector<std::string>& conflicts() const { return conflicts_; }

    // In the order of their names.
    const std::vector<std::unique_ptr<FusionType>>& fusions() const { return fusions_; }

    bool add(std::unique_ptr<NodeType> type);
    bool add(std::unique_ptr<FusionType> type);
    void note(const TypeInfo& info);
    // Says that node types come with an option of the build, whether they are there or not.
    bool note_option(const std::string& option, const std::vector<std::string>& types);

  private:
    std::map<std::string, std::unique_ptr<NodeType>, std::less<>> types_;
    std::map<std::string, const TypeInfo*, std::less<>> infos_;
    std::map<std::string, std::string, std::less<>> options_;  // of a node type
    std::vector<std::unique_ptr<FusionType>> fusions_;
    std::vector<std::string> conflicts_;
};

// Loads every shared library (*.so) of a folder, by name; each registers its nodes. A folder or library that
// cannot be loaded throws Error naming it and the loader's reason. Libraries stay loaded.
void load_node_libraries(const std::string& folder);

// How a value of a type is written to a file when it is tapped: families say it for their types.
// Without one the arrays that describe() shows are written as JSON.
using Saver = void (*)(const void* value, const std::string& path, Context& ctx);
bool register_saver(std::string_view type, Saver saver);
Saver saver_of(std::string_view type);  // or null

}  // namespace weft
