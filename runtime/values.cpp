#include "runtime/values.h"

namespace weft {

// 'tlfr' for "tlfr/stages/picture", as seen from "compare".
std::string name_seen_from(const std::string& node, const std::string& other) {
    const size_t scope = node.rfind('/') == std::string::npos ? 0 : node.rfind('/') + 1;
    if (other.compare(0, scope, node, 0, scope) != 0) return other;  // from outside the sub-graph
    return other.substr(scope, other.find('/', scope) - scope);
}

Values::Values(const Plan& plan) : plan_(plan) {
    for (size_t n = 0; n < plan.graph->nodes.size(); ++n) {
        std::deque<Entry>& outputs = entries_.emplace_back();
        for (size_t p = 0; p < plan.graph->nodes[n].type->outputs.size(); ++p)
            outputs.emplace_back().readers = plan.readers[n][p];
    }
    for (const Tap& tap : plan.taps) at(tap.from).tapped = true;
}

bool Values::wanted(Link link) const { return plan_.readers_of(link) > 0 || at(link).tapped; }

const TypeInfo& Values::type(Link link) const {
    const PortDecl& port = plan_.graph->nodes[size_t(link.node)].type->outputs[size_t(link.port)];
    return *Registry::instance().type_info(port.type);
}

void* Values::make(Link link) {
    at(link).object = type(link).make();
    return at(link).object.get();
}

void Values::release(Link link) {
    if (--at(link).readers == 0 && !at(link).tapped) at(link).object.reset();
}

Inputs Values::inputs_of(int node) const {
    const GraphNode& n = plan_.graph->nodes[size_t(node)];
    Inputs in;
    for (size_t p = 0; p < n.inputs.size(); ++p) {
        const PortDecl& port = n.type->inputs[p];
        Slot slot;
        slot.port = port.name;
        slot.type = Registry::instance().type_info(port.type);
        std::vector<std::string> names;
        for (const Link& link : n.inputs[p]) {
            if (!port.stream) slot.more.push_back(get(link));
            names.push_back(name_seen_from(n.name, plan_.graph->nodes[size_t(link.node)].name));
        }
        if (!slot.more.empty()) slot.object = slot.more.front();
        in.slots.push_back(std::move(slot));
        in.linked.emplace_back(port.name, std::move(names));
    }
    return in;
}

Inputs Values::inputs_of(const StagePlan& stage) const {
    if (!stage.fusion) return inputs_of(stage.nodes[0]);
    Inputs in;
    for (const StagePlan::Port& port : stage.inputs) {
        const Inputs all = inputs_of(port.node);
        in.slots.push_back(all.slots[size_t(port.port)]);
        in.slots.back().port = port.name;
        in.linked.emplace_back(port.name, all.linked[size_t(port.port)].second);
    }
    return in;
}

Outputs Values::outputs_of(int node) {
    const GraphNode& n = plan_.graph->nodes[size_t(node)];
    Outputs out;
    for (size_t p = 0; p < n.type->outputs.size(); ++p) {
        const Link link{node, int(p)};
        Slot slot;
        slot.port = n.type->outputs[p].name;
        slot.type = &type(link);
        if (!n.type->outputs[p].stream && wanted(link)) slot.object = make(link);
        out.slots.push_back(std::move(slot));
    }
    return out;
}

}  // namespace weft
