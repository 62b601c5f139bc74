// The tables that the passes of loading work on: scopes (a document as it is used in one place),
// their entities (the names a link may start with), and the flat nodes that come of them.
#pragma once
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "graph/document.h"
#include "graph/graph.h"
#include "graph/overrides.h"
#include "graph/substitution.h"

namespace weft::loading {

// What a link leads to.
struct Target {
    enum State { untried, trying, found, open, broken };
    State state = untried;  // open: an optional input of the graph that nobody connected;
                            // broken: an error was told elsewhere
    Link link;
    std::string_view type;
};

struct Scope;

// A node of a document, or one of its inputs.
struct Entity {
    std::string name;
    Place place;
    Scope* scope = nullptr;

    const NodeText* text = nullptr;  // null: an input of the graph
    const GraphInput* input = nullptr;
    const NodeDecl* decl = nullptr;        // of a node type
    std::unique_ptr<Scope> inner;          // of a graph used as a node
    std::vector<const InputText*> inputs;  // those that count, after a swap

    bool broken = false;  // its type is not known: nothing more is said of it
    bool bypass = false;
    Place bypass_place;
    const SwapOption* swap = nullptr;
    const NodeDecl* swapped_from = nullptr;

    int flat = -1;
    bool read = false;  // some link names it
    Target passed;      // what it passes through: a graph's input, a bypassed node
};

struct Scope {
    const Document* document = nullptr;
    Entity* entity = nullptr;  // what it is in the scope around it; null: the top
    std::string prefix;        // "pass-1/"
    std::deque<Entity> entities;
    std::deque<NodeText> repeated;  // nodes of the document that stand here several times
    std::unordered_map<std::string_view, Entity*> by_name;
    std::unordered_map<std::string_view, Bound> parameters;
    std::vector<Target> outputs;  // as document->outputs
    bool removed = false;         // within a bypassed node

    Scope* outer() const { return entity ? entity->scope : nullptr; }
};

struct FlatLink {
    Link link;
    Place place;
};

struct FlatNode {
    std::string name;
    const NodeDecl* type = nullptr;
    Entity* entity = nullptr;
    std::vector<Json> params, expressions;
    std::vector<std::vector<FlatLink>> inputs;
    Place place;
    bool removed = false;   // bypassed, or within a bypassed graph
    bool stand_in = false;  // for an input of the top document
};

// Types of ports by name: whether they are streams.
using PortTypes = std::map<std::string, bool, std::less<>>;

struct NodeTable {
    const Catalog* catalog = nullptr;
    PortTypes types;
    std::deque<Document> documents;
    std::deque<NodeDecl> stand_ins;
    std::unique_ptr<Scope> top;
    std::vector<FlatNode> nodes;
    std::vector<GraphParameter> parameters;
    std::map<std::string, Link> outputs;
};

// The passes after Expander, in order.

// Follows every link to the node it comes from; checks ports and types.
void connect(NodeTable& table, bool for_run, Findings& findings);
// Nodes after those they read from; empty if there is a cycle.
std::vector<int> order(const NodeTable& table, Findings& findings);
// Nodes that are there for nothing.
void find_unread(const NodeTable& table, Findings& findings);
// Streams meet only streams of their source and their selection of records.
void check_streams(const NodeTable& table, const std::vector<int>& order, Findings& findings);

// "'write-image' is version 2 ..." or "".
std::string pin_problem(const NodeDecl& decl, int pin);

}  // namespace weft::loading
