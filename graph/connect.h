// Connector: follows every link to the node it comes from, through graphs used as nodes, their
// inputs and outputs, and bypassed nodes.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "graph/table.h"

namespace weft::loading {

class Connector {
  public:
    Connector(NodeTable& table, bool for_run, Findings& findings)
        : table_(table), for_run_(for_run), findings_(findings) {}
    void run();

  private:
    // An output as a link sees it.
    struct View {
        std::string_view name, type;
        Target target;
    };

    void scope(Scope& scope);
    void node(Entity& entity);
    void leaf_input(Entity& entity, const InputText& input, int port);
    void graph_input(Entity& entity, const InputText& input, const GraphInput& declared);
    void left_open(const Entity& entity, const LinkText& link, const std::string& port);
    void missing_inputs(const Entity& entity);
    void bypassed(Entity& entity);
    void top_outputs(Scope& scope);

    // Errors of the link itself are told; those of what lies behind it are told where they are.
    Target follow(Scope& scope, const LinkText& link, std::string_view wanted, bool tell);
    Target choose(Entity& entity, const LinkText& link, std::string_view wanted, bool tell);
    Target unfitting(Entity& entity, const LinkText& link, std::string_view wanted,
                     const std::vector<View>& views, bool tell);
    void ambiguous(const Entity& entity, const LinkText& link, std::string_view wanted,
                   const std::vector<View>& views);
    std::vector<View> outputs_of(Entity& entity);
    std::vector<View> own_outputs(Entity& entity);
    std::string_view first_input_type(const Entity& entity) const;
    const InputText* first_input(const Entity& entity) const;
    Target through(Entity& entity);
    Target output_target(Scope& scope, size_t index);

    // "'cluster'", or with its type where that says more.
    static std::string called(const Entity& entity);
    static std::string type_name(const Entity& entity);

    NodeTable& table_;
    bool for_run_;
    Findings& findings_;
};

}  // namespace weft::loading
