#include "graph/connect.h"

#include <algorithm>

namespace weft::loading {
std::string Connector::called(const Entity& entity) {
    return entity.decl && entity.decl->type != entity.name
               ? fmt::format("'{}' ({})", entity.name, entity.decl->type)
               : fmt::format("'{}'", entity.name);
}

std::string Connector::type_name(const Entity& entity) {
    return entity.decl   ? entity.decl->type
           : entity.swap ? entity.swap->type.text
                         : entity.text->type.text;
}

void Connector::run() {
    scope(*table_.top);
    top_outputs(*table_.top);
}

void Connector::scope(Scope& s) {
    s.outputs.resize(s.document->outputs.size());
    for (Entity& entity : s.entities)
        if (entity.text && !entity.broken) node(entity);
    // What a broken input, or one that a swap dropped, names is read all the same.
    for (Entity& entity : s.entities)
        if (entity.text)
            for (const InputText& input : entity.text->inputs)
                for (const LinkText& link : input.links)
                    if (const auto found = s.by_name.find(link.node); found != s.by_name.end())
                        found->second->read = true;
    for (size_t i = 0; i < s.outputs.size(); ++i) output_target(s, i);
    for (Entity& entity : s.entities)
        if (entity.inner) scope(*entity.inner);
}

void Connector::node(Entity& entity) {
    for (const InputText* input : entity.inputs) {
        const std::string& name = input->port.text;
        std::vector<std::string> known;
        if (entity.decl) {
            const int port = entity.decl->find_input(name);
            if (port >= 0) {
                leaf_input(entity, *input, port);
                continue;
            }
            for (const PortDecl& p : entity.decl->inputs) known.push_back(p.name);
        } else {
            const auto& declared = entity.inner->document->inputs;
            const auto found =
                std::find_if(declared.begin(), declared.end(),
                             [&](const GraphInput& g) { return g.name.text == name; });
            if (found != declared.end()) {
                graph_input(entity, *input, *found);
                continue;
            }
            for (const GraphInput& g : declared) known.push_back(g.name.text);
        }
        if (known.empty())
            findings_.error(input->port.place, "'{}' has no inputs", type_name(entity));
        else
            findings_.error(input->port.place, "'{}' has no input '{}'{}", type_name(entity), name,
                            suggestion(name, known));
    }
    if (entity.bypass)
        bypassed(entity);
    else
        missing_inputs(entity);
}

void Connector::leaf_input(Entity& entity, const InputText& input, int port) {
    const PortDecl& decl = entity.decl->inputs[size_t(port)];
    FlatNode& flat = table_.nodes[size_t(entity.flat)];
    const bool many = decl.need == Need::variadic;
    if (!many && input.is_list) {
        findings_.error(input.port.place, "'{}' takes one link, not a list", decl.name);
        return;
    }
    if (many && input.is_list && input.links.empty())
        findings_.error(input.port.place, "'{}' is an empty list; expected at least one link to {}",
                        decl.name, decl.type);
    for (const LinkText& link : input.links) {
        const Target target = follow(*entity.scope, link, decl.type, true);
        if (target.state == Target::open) {
            if (target.type != decl.type)
                findings_.error(link.place, "'{}' is {}; '{}' takes {}", link.text(), target.type,
                                decl.name, decl.type);
            else if (decl.need == Need::required && !entity.bypass)
                left_open(entity, link, decl.name);
        } else if (target.state == Target::found) {
            if (target.type == decl.type)
                flat.inputs[size_t(port)].push_back({target.link, link.place});
            else
                findings_.error(link.place, "'{}' is {}; '{}' takes {}", link.text(), target.type,
                                decl.name, decl.type);
        }
    }
}

void Connector::graph_input(Entity& entity, const InputText& input, const GraphInput& declared) {
    if (input.is_list) {
        findings_.error(input.port.place, "'{}' takes one link, not a list", declared.name.text);
        return;
    }
    if (table_.types.find(declared.type.text) == table_.types.end()) return;  // told there
    for (const LinkText& link : input.links) {
        const Target target = follow(*entity.scope, link, declared.type.text, true);
        if (target.state != Target::found && target.state != Target::open) continue;
        if (target.type != declared.type.text)
            findings_.error(link.place, "'{}' is {}; '{}' takes {}", link.text(), target.type,
                            declared.name.text, declared.type.text);
        else if (target.state == Target::open && !declared.optional)
            left_open(entity, link, declared.name.text);
    }
}

void Connector::left_open(const Entity& entity, const LinkText& link, const std::string& port) {
    const Entity* around = entity.scope->entity;
    findings_.error(link.place,
                    "'{}' must be connected, but the graph's optional input '{}' is left open{}",
                    port, link.node, around ? fmt::format(" by '{}'", around->name) : "");
}

void Connector::missing_inputs(const Entity& entity) {
    std::vector<std::string> known;
    if (entity.decl)
        for (const PortDecl& port : entity.decl->inputs) known.push_back(port.name);
    else
        for (const GraphInput& in : entity.inner->document->inputs) known.push_back(in.name.text);
    // A misspelt name has been told already.
    const auto is_given = [&](const std::string& name) {
        return std::any_of(entity.inputs.begin(), entity.inputs.end(), [&](const InputText* in) {
            return in->port.text == name ||
                   (std::find(known.begin(), known.end(), in->port.text) == known.end() &&
                    nearest_name(in->port.text, known) == name);
        });
    };
    const auto complain = [&](const std::string& name, const std::string& type) {
        if (entity.swap)
            findings_.error(entity.swap->place,
                            "'{}' needs input '{}' ({}), which '{}' is not given",
                            type_name(entity), name, type, entity.name);
        else
            findings_.error(entity.place, "{} needs input '{}' ({})", called(entity), name, type);
    };
    if (entity.decl) {
        for (const PortDecl& port : entity.decl->inputs)
            if (port.need != Need::optional && !is_given(port.name)) complain(port.name, port.type);
    } else {
        for (const GraphInput& in : entity.inner->document->inputs)
            if (!in.optional && !is_given(in.name.text)) complain(in.name.text, in.type.text);
    }
}

void Connector::bypassed(Entity& entity) {
    const std::string_view type = first_input_type(entity);
    if (type.empty()) {
        findings_.error(entity.bypass_place, "{} cannot be bypassed: it has no input to pass on",
                        called(entity));
        return;
    }
    const std::vector<View> own = own_outputs(entity);
    const bool unsure = std::any_of(own.begin(), own.end(),
                                    [](const View& v) { return v.target.state == Target::broken; });
    if (std::none_of(own.begin(), own.end(), [&](const View& v) { return v.type == type; })) {
        if (!unsure)
            findings_.error(entity.bypass_place,
                            "{} cannot be bypassed: its first input is {}, and no output is",
                            called(entity), type);
        return;
    }
    const InputText* input = first_input(entity);
    if (!input)
        findings_.error(entity.bypass_place,
                        "{} cannot be bypassed: its first input is not connected", called(entity));
    else if (input->links.size() > 1)
        findings_.error(entity.bypass_place,
                        "{} cannot be bypassed: its first input has several links", called(entity));
}

void Connector::top_outputs(Scope& s) {
    for (size_t i = 0; i < s.outputs.size(); ++i) {
        const Target target = output_target(s, i);
        const GraphOutput& output = s.document->outputs[i];
        if (target.state != Target::found) continue;
        const auto type = table_.types.find(target.type);
        if (for_run_ && type != table_.types.end() && type->second)
            findings_.error(
                output.link.place,
                "'{}' is a stream ({}); an output of a graph that is run must be a whole value",
                output.link.text(), target.type);
        table_.outputs[output.name.text] = target.link;
    }
}

void connect(NodeTable& table, bool for_run, Findings& findings) {
    Connector(table, for_run, findings).run();
}

}  // namespace weft::loading
