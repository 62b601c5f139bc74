// Document: the text of a graph, read and checked for its form; names are not yet looked up.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "graph/declaration.h"
#include "graph/findings.h"

namespace weft::loading {

struct Word {
    std::string text;
    Place place;
};

struct LinkText {
    std::string node, port;  // port "": the node alone
    Place place;
    std::string text() const { return port.empty() ? node : node + "." + port; }
};

struct InputText {
    Word port;
    std::vector<LinkText> links;
    bool is_list = false;
};

struct Setting {
    Word name;
    Json value;
};

// An input of a repeated node that takes an output of the one before it.
struct CarryText {
    Word input, output;
};

struct NodeText {
    Word name;
    Word type;    // without its version; "" if it could not be read
    int pin = 0;  // of "type@version"; 0: none
    std::vector<InputText> inputs;
    std::vector<Setting> settings;
    std::optional<Setting> each;  // a parameter and the list of its values: one node for each
    std::vector<CarryText> carry;
    bool bypass = false;
    Place bypass_place;
};

struct GraphInput {
    Word name, type;
    bool optional = false;
};

struct GraphOutput {
    Word name;
    LinkText link;
};

struct ParameterText {
    ParamDecl decl;
    Place place;  // its name
    bool used = false;
};

struct Document {
    SourcePtr source;
    std::string folder;     // where its sub-graphs are looked for
    std::string canonical;  // tells files apart
    std::string about;
    std::vector<ParameterText> parameters;
    std::vector<GraphInput> inputs;
    std::vector<GraphOutput> outputs;
    std::vector<NodeText> nodes;
    bool readable = false;  // it is JSON, an object, and of a version we know

    const ParameterText* find_parameter(std::string_view name) const;
};

Document read_document(const SourcePtr& source, Findings& findings);

// What to underline of a value: an object or list over many lines is shown by its first character.
Place span(const Json& value);

// "type@3" -> 3 (0: none, -1: no number); `type` loses the pin.
int take_pin(std::string& type);
bool is_graph_file(std::string_view type);  // ends in .json

// "node.port" or "node"; false if it is neither.
bool split_link(std::string_view text, LinkText& link);

}  // namespace weft::loading
