// What a node type says of itself: ports, parameters, version. Data only, so that the checker, the
// schema, `weft node`, the documentation and the run all read the same table.
#pragma once
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "graph/json.h"

namespace weft {

enum class Kind { number, integer, boolean, text, choice, file, color, list, object };
std::string_view name_of(Kind kind);

enum class FileUse { none, read, write };

struct ParamDecl {
    std::string name, about;
    Kind kind = Kind::text;
    std::string unit;
    std::optional<Json> fallback;  // the default; none: the parameter must be set
    double minimum = -std::numeric_limits<double>::infinity();
    double maximum = std::numeric_limits<double>::infinity();
    std::vector<std::string> choices;
    FileUse use = FileUse::none;
    bool optional_file = false;  // "" is allowed and means: no file
};

enum class Need { required, optional, variadic };

struct PortDecl {
    std::string name, about;
    std::string type;  // "Samples", "Locations", ...
    bool stream = false;
    Need need = Need::required;
    // Streams. An output that `selects` passes on some of its input's records. An input that takes
    // a `branch` may carry a selection of the records of the node's first stream input, to be
    // merged. A `per_batch` stream holds no records of its own (it is shared by all records of a
    // batch).
    bool selects = false, branch = false, per_batch = false;
};

struct NodeDecl {
    std::string type, about, family;
    int version = 1;
    std::vector<PortDecl> inputs, outputs;
    std::vector<ParamDecl> params;
    bool writes = false;  // has an effect outside the graph: always run

    const ParamDecl* find_param(std::string_view name) const;
    int find_input(std::string_view name) const;  // index, or -1
    int find_output(std::string_view name) const;
};

// The node types there are. The registry of the runtime is one; tests bring their own.
class Catalog {
  public:
    virtual ~Catalog() = default;
    virtual const NodeDecl* find(std::string_view type) const = 0;
    virtual std::vector<const NodeDecl*> all() const = 0;  // sorted by family, then type
    // The option of a build that this type comes with; "" where it is in every build.
    virtual std::string_view option_of(std::string_view) const { return {}; }
};

// Checks `value` against `decl` (kind, range, choices); "" if it fits, else what is wrong, in the
// words of a finding: "sigma-range is -1; expected 1e-4 to 1e3 (guide)".
std::string mismatch(const ParamDecl& decl, const Json& value);

}  // namespace weft
