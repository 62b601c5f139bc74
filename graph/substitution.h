// Parameters of a graph put into the values its nodes are set to: "$name" is the whole value,
// "${name}" stands within a text, "${name.stem}" is a path without its extension, "$$" a dollar.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "graph/declaration.h"
#include "graph/findings.h"

namespace weft::loading {

// A value as a node gets it, and as a flattened document would write it.
struct Bound {
    Json value;
    bool known = true;  // false: a parameter without a value; some value of its kind
    Json expression;    // with "$name"s of the top document only; null: given by an option alone
};

struct Piece {
    std::string text;  // literal, or a parameter's name
    bool parameter = false;
    bool stem = false;
};

// A text in pieces. `whole`: "$name" and nothing else.
struct Pieces {
    std::vector<Piece> list;
    bool whole = false;
    std::string problem;  // not empty: what is wrong with it
};
Pieces take_apart(std::string_view text);

// Every parameter named in a value, and every text that cannot be read.
void for_each_reference(const Json& value,
                        const std::function<void(const std::string& name, const Place&)>& named,
                        const std::function<void(const std::string& problem, const Place&)>& wrong);

using Lookup = std::function<const Bound*(std::string_view name)>;
Bound substitute(const Json& value, const Lookup& lookup);

// A text that reads as itself: "$" doubled, in every text of the value.
Json escaped(const Json& value);

// "out/a.b.exr" -> "out/a.b"
std::string_view stem(std::string_view path);

// Whether a parameter of a graph can be given to a parameter of a node.
std::string kind_problem(const ParamDecl& from, const ParamDecl& to);

}  // namespace weft::loading
