// The part of Connector that follows a link: through nodes, graphs and what is bypassed.
#include <algorithm>

#include "graph/connect.h"

namespace weft::loading {

Target Connector::follow(Scope& s, const LinkText& link, std::string_view wanted, bool tell) {
    Target broken;
    broken.state = Target::broken;
    const auto found = s.by_name.find(link.node);
    if (found == s.by_name.end()) {
        std::vector<std::string> names;
        for (const Entity& entity : s.entities) names.push_back(entity.name);
        if (tell)
            findings_.error(link.place, "no node '{}'{}", link.node, suggestion(link.node, names));
        // The one that was meant is not unread as well.
        if (const auto near = s.by_name.find(nearest_name(link.node, names));
            near != s.by_name.end())
            near->second->read = true;
        return broken;
    }
    Entity& entity = *found->second;
    entity.read = true;
    if (entity.broken) return broken;
    if (entity.input) {
        if (link.port.empty()) return through(entity);
        if (tell)
            findings_.error(link.place,
                            "'{0}' is an input of this graph and has no ports; write \"{0}\"",
                            link.node);
        return broken;
    }
    return choose(entity, link, wanted, tell);
}

Target Connector::choose(Entity& entity, const LinkText& link, std::string_view wanted, bool tell) {
    Target broken;
    broken.state = Target::broken;
    const std::vector<View> views = outputs_of(entity);
    if (!link.port.empty()) {
        for (const View& view : views)
            if (view.name == link.port) return view.target;
    } else if (views.size() == 1) {
        return views[0].target;
    } else {
        const View* fits = nullptr;
        int count = 0;
        for (const View& view : views) {
            if (view.target.state == Target::broken) return broken;
            if (view.type != wanted) continue;
            fits = &view;
            ++count;
        }
        if (count == 1) return fits->target;
    }
    if (entity.bypass && views.empty()) return broken;  // told at the bypass
    return unfitting(entity, link, wanted, views, tell);
}

Target Connector::unfitting(Entity& entity, const LinkText& link, std::string_view wanted,
                            const std::vector<View>& views, bool tell) {
    Target broken;
    broken.state = Target::broken;
    std::string offered;
    std::vector<std::string> names;
    for (const View& view : views) {
        names.emplace_back(view.name);
        offered += fmt::format("{}'{}.{}' ({})", offered.empty() ? "" : ", ", entity.name,
                               view.name, view.type);
    }
    if (offered.empty()) offered = "no outputs";
    if (entity.swap) {
        // The new type may call the same thing by another name.
        std::string_view type = wanted;
        if (entity.swapped_from) {
            const auto& old = entity.swapped_from->outputs;
            const int port = entity.swapped_from->find_output(link.port);
            if (port >= 0)
                type = old[size_t(port)].type;
            else if (link.port.empty() && old.size() == 1)
                type = old[0].type;
        }
        const View* fits = nullptr;
        int count = 0;
        for (const View& view : views)
            if (view.type == type) {
                fits = &view;
                ++count;
            }
        if (count == 1) return fits->target;
        if (tell)
            findings_.error(entity.swap->place, "'{}' has nothing for the link '{}'{}; it has {}",
                            type_name(entity), link.text(),
                            type.empty() ? "" : fmt::format(" ({})", type), offered);
        return broken;
    }
    if (!tell) return broken;
    const Place& place = entity.bypass && entity.bypass_place.source != link.place.source
                             ? entity.bypass_place
                             : link.place;
    if (entity.bypass)
        findings_.error(place, "{} is bypassed, which leaves {}; '{}' is not there", called(entity),
                        offered, link.text());
    else if (views.empty())
        findings_.error(place, "{} has no outputs", called(entity));
    else if (!link.port.empty())
        findings_.error(place, "{} has no output '{}'{}", called(entity), link.port,
                        suggestion(link.port, names));
    else
        ambiguous(entity, link, wanted, views);
    return broken;
}

void Connector::ambiguous(const Entity& entity, const LinkText& link, std::string_view wanted,
                          const std::vector<View>& views) {
    std::string all, fitting;
    for (const View& view : views) {
        const std::string text = fmt::format("'{}.{}' ({})", entity.name, view.name, view.type);
        all += (all.empty() ? "" : ", ") + text;
        if (view.type == wanted) fitting += (fitting.empty() ? "" : ", ") + text;
    }
    if (!fitting.empty())
        findings_.error(link.place, "{} has several outputs that fit; expected one of {}",
                        called(entity), fitting);
    else if (!wanted.empty())
        findings_.error(link.place, "no output of {} is {}; it has {}", called(entity), wanted,
                        all);
    else
        findings_.error(link.place, "{} has several outputs; expected one of {}", called(entity),
                        all);
}

std::vector<Connector::View> Connector::own_outputs(Entity& entity) {
    std::vector<View> out;
    if (entity.decl) {
        for (size_t i = 0; i < entity.decl->outputs.size(); ++i) {
            const PortDecl& port = entity.decl->outputs[i];
            out.push_back(
                {port.name, port.type, {Target::found, {entity.flat, int(i)}, port.type}});
        }
    } else if (entity.inner) {
        Scope& inner = *entity.inner;
        inner.outputs.resize(inner.document->outputs.size());
        for (size_t i = 0; i < inner.outputs.size(); ++i) {
            const Target target = output_target(inner, i);
            out.push_back({inner.document->outputs[i].name.text, target.type, target});
        }
    }
    return out;
}

std::vector<Connector::View> Connector::outputs_of(Entity& entity) {
    std::vector<View> own = own_outputs(entity);
    if (!entity.bypass) return own;
    const std::string_view type = first_input_type(entity);
    if (type.empty()) return {};
    const InputText* input = first_input(entity);
    if (!input || input->links.size() != 1) return {};
    const View* passing = nullptr;
    for (const View& view : own)
        if (view.type == type && (!passing || view.name == input->port.text)) passing = &view;
    if (!passing) return {};
    return {{passing->name, type, through(entity)}};
}

std::string_view Connector::first_input_type(const Entity& entity) const {
    if (entity.decl)
        return entity.decl->inputs.empty() ? std::string_view() : entity.decl->inputs[0].type;
    const auto& inputs = entity.inner->document->inputs;
    return inputs.empty() ? std::string_view() : inputs[0].type.text;
}

const InputText* Connector::first_input(const Entity& entity) const {
    const std::string& name =
        entity.decl ? entity.decl->inputs[0].name : entity.inner->document->inputs[0].name.text;
    for (const InputText* input : entity.inputs)
        if (input->port.text == name) return input;
    return nullptr;
}

Target Connector::through(Entity& entity) {
    Target& passed = entity.passed;
    if (passed.state == Target::trying) {
        findings_.error(entity.place,
                        "'{}' leads back to itself: there are only inputs and outputs of graphs "
                        "and bypassed nodes on "
                        "the way",
                        entity.name);
        passed.state = Target::broken;
        return passed;
    }
    if (passed.state != Target::untried) return passed;
    passed.state = Target::trying;

    Target result;
    result.state = Target::broken;
    std::string_view type;
    if (entity.input) {
        type = entity.input->type.text;
        const Entity* around = entity.scope->entity;
        if (!around) {
            result = {for_run_ && entity.input->optional ? Target::open : Target::found,
                      {entity.flat, 0},
                      type};
        } else {
            const InputText* given = nullptr;
            for (const InputText* input : around->inputs)
                if (input->port.text == entity.name) given = input;
            if (!given)
                result = {entity.input->optional ? Target::open : Target::broken, {}, type};
            else if (given->links.size() == 1)
                result = follow(*around->scope, given->links[0], type, false);
        }
    } else {
        type = first_input_type(entity);
        result = follow(*entity.scope, first_input(entity)->links[0], type, false);
    }
    if (result.type != type) result.state = Target::broken;  // told where the link is
    result.type = type;
    passed = result;
    return passed;
}

Target Connector::output_target(Scope& s, size_t index) {
    const LinkText& link = s.document->outputs[index].link;
    if (s.outputs[index].state == Target::trying) {
        findings_.error(link.place,
                        "'{}' leads back to itself: there are only inputs and outputs of graphs "
                        "and bypassed nodes on "
                        "the way",
                        link.text());
        s.outputs[index].state = Target::broken;
        return s.outputs[index];
    }
    if (s.outputs[index].state != Target::untried) return s.outputs[index];
    s.outputs[index].state = Target::trying;
    const Target target = follow(s, link, "", true);
    s.outputs[index] = target;
    return target;
}

}  // namespace weft::loading
