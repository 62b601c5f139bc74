// Expander: unfolds a document and the graphs it uses into scopes and flat nodes, with every
// parameter's value.
#pragma once
#include <set>
#include <string>
#include <vector>

#include "graph/library.h"
#include "graph/table.h"

namespace weft::loading {

class Expander {
  public:
    Expander(NodeTable& table, Library& library, Options& options, bool for_run, Findings& findings)
        : table_(table),
          library_(library),
          options_(options),
          for_run_(for_run),
          findings_(findings) {}

    void run(const Document& top);

  private:
    // A parameter that may be set, and what it was called by.
    struct Owner {
        std::string name;  // of the type
        std::vector<const ParamDecl*> params;
        const ParamDecl* find(std::string_view param) const;
        std::vector<std::string> names() const;
    };

    void top_parameters(Scope& scope);
    void graph_inputs(Scope& scope);
    void unfold(Scope& scope);
    void node(Scope& scope, const NodeText& text);
    void repeat(Scope& scope, const NodeText& text);
    static Lookup lookup_in(const Scope& scope);
    Word type_of(const Scope& scope, const NodeText& text);
    void apply_options(Entity& entity, const std::string& path, Word& type, int& pin);
    void leaf(Entity& entity, const std::string& path, const Word& type, int pin);
    void graph(Entity& entity, const std::string& path, const Word& type);
    const Document* find_graph(const Entity& entity, const Word& type);
    bool is_within_itself(const Scope& scope, const Document& document, const Word& type);

    std::vector<Bound> bind(Entity& entity, const std::string& path, const Owner& owner);
    const Setting* setting_of(const Entity& entity, std::string_view name) const;
    bool misspelt(const Entity& entity, const Owner& owner, const std::string& param) const;
    Bound from_text(Entity& entity, const std::string& path, const ParamDecl& decl,
                    const Setting& setting);
    void override_by(const SetOption& option, const ParamDecl& decl, Bound& bound);
    void unknown_settings(Entity& entity, const std::string& path, const Owner& owner);
    void unused_options();

    NodeTable& table_;
    Library& library_;
    Options& options_;
    bool for_run_;
    Findings& findings_;
    std::vector<std::string> paths_;
    std::set<std::string> flat_names_;
    bool too_many_ = false;
};

}  // namespace weft::loading
