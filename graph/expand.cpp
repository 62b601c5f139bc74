#include "graph/expand.h"

#include <algorithm>
#include <filesystem>

namespace weft::loading {
namespace {

constexpr size_t most_nodes = 100000;

std::string kind_text(const ParamDecl& decl) {
    return decl.unit.empty() ? std::string(name_of(decl.kind))
                             : fmt::format("{}, {}", name_of(decl.kind), decl.unit);
}

}  // namespace

const ParamDecl* Expander::Owner::find(std::string_view param) const {
    for (const ParamDecl* decl : params)
        if (decl->name == param) return decl;
    return nullptr;
}

std::vector<std::string> Expander::Owner::names() const {
    std::vector<std::string> out;
    for (const ParamDecl* decl : params) out.push_back(decl->name);
    return out;
}

void Expander::run(const Document& top) {
    table_.top = std::make_unique<Scope>();
    table_.top->document = &top;
    top_parameters(*table_.top);
    graph_inputs(*table_.top);
    unfold(*table_.top);
    unused_options();
}

void Expander::top_parameters(Scope& scope) {
    for (const ParameterText& text : scope.document->parameters) {
        Bound bound;
        bound.expression = Json(fmt::format("${}", text.decl.name));
        bound.known = text.decl.fallback.has_value();
        if (bound.known) bound.value = *text.decl.fallback;
        if (const SetOption* option = options_.set_of("", text.decl.name))
            override_by(*option, text.decl, bound);
        else if (!bound.known && for_run_)
            findings_.error(
                text.place,
                "parameter '{0}' ({1}) has no default and was not set; give --set {0}=VALUE",
                text.decl.name, kind_text(text.decl));
        table_.parameters.push_back({text.decl, bound.value});
        scope.parameters[text.decl.name] = std::move(bound);
    }
}

// The top document's inputs are fed by nobody: stand-ins make their types known.
void Expander::graph_inputs(Scope& scope) {
    for (const GraphInput& input : scope.document->inputs) {
        Entity& entity = scope.entities.emplace_back();
        entity.name = input.name.text;
        entity.place = input.name.place;
        entity.scope = &scope;
        entity.input = &input;
        scope.by_name.emplace(entity.name, &entity);
        const auto type = table_.types.find(input.type.text);
        if (type == table_.types.end()) {
            entity.broken = true;
            std::vector<std::string> names;
            for (const auto& [name, stream] : table_.types) names.push_back(name);
            if (!input.type.text.empty())
                findings_.error(input.type.place, "no type '{}'{}", input.type.text,
                                suggestion(input.type.text, names));
            continue;
        }
        if (scope.entity) continue;
        NodeDecl& decl = table_.stand_ins.emplace_back();
        decl.type = "input";
        decl.outputs.push_back({input.name.text, "", type->first, type->second});
        FlatNode& flat = table_.nodes.emplace_back();
        flat.name = input.name.text;
        flat.type = &decl;
        flat.entity = &entity;
        flat.place = input.name.place;
        flat.stand_in = true;
        entity.flat = int(table_.nodes.size()) - 1;
        if (for_run_ && !input.optional)
            findings_.error(
                input.name.place,
                "input '{}' is not connected: this graph is a part of others, run one that uses it",
                input.name.text);
    }
}

void Expander::unfold(Scope& scope) {
    for (const NodeText& text : scope.document->nodes)
        if (text.each)
            repeat(scope, text);
        else
            node(scope, text);
}

// A node for each value of a list, NAME-1 to NAME-n, each with what it carries from the one before;
// a link to NAME leads to the last.
void Expander::repeat(Scope& scope, const NodeText& text) {
    const Bound list = substitute(text.each->value, lookup_in(scope));
    const bool any = list.value.is(Json::Kind::list) && !list.value.items.empty();
    if (!list.known || !any) {
        if (list.known)
            findings_.error(span(text.each->value),
                            "'each' is {}; expected a list with a value for each node",
                            list.value.is(Json::Kind::list) ? "an empty list"
                                                            : list.value.dump());
        Entity& entity = scope.entities.emplace_back();
        entity.name = text.name.text;
        entity.place = text.name.place;
        entity.scope = &scope;
        entity.text = &text;
        entity.broken = true;
        scope.by_name.emplace(text.name.text, &entity);
        return;
    }
    std::string before;
    for (const Json& value : list.value.items) {
        NodeText& one = scope.repeated.emplace_back(text);
        one.name.text = fmt::format("{}-{}", text.name.text, &value - &list.value.items[0] + 1);
        std::erase_if(one.settings, [&](const Setting& setting) {
            return setting.name.text == text.each->name.text;
        });
        one.settings.push_back({text.each->name, escaped(value)});
        for (const CarryText& carry : text.carry)
            for (InputText& in : one.inputs)
                if (!before.empty() && in.port.text == carry.input.text)
                    in.links = {{before, carry.output.text, carry.output.place}}, in.is_list = false;
        node(scope, one);
        before = one.name.text;
    }
    if (!scope.entities.empty()) scope.by_name.emplace(text.name.text, &scope.entities.back());
}

void Expander::node(Scope& scope, const NodeText& text) {
    if (paths_.size() >= most_nodes) {
        if (!too_many_)
            findings_.error(text.name.place, "the graph has more than {} nodes", most_nodes);
        too_many_ = true;
        return;
    }
    Entity& entity = scope.entities.emplace_back();
    entity.name = text.name.text;
    entity.place = text.name.place;
    entity.scope = &scope;
    entity.text = &text;
    scope.by_name.emplace(entity.name, &entity);
    const std::string path = scope.prefix + entity.name;
    paths_.push_back(path);

    Word type = type_of(scope, text);
    int pin = text.pin;
    entity.bypass = text.bypass;
    entity.bypass_place = text.bypass_place;
    for (const InputText& in : text.inputs) entity.inputs.push_back(&in);
    apply_options(entity, path, type, pin);

    if (type.text.empty())
        entity.broken = true;
    else if (is_graph_file(type.text))
        graph(entity, path, type);
    else
        leaf(entity, path, type, pin);
}

Lookup Expander::lookup_in(const Scope& scope) {
    return [&scope](std::string_view name) -> const Bound* {
        const auto found = scope.parameters.find(name);
        return found == scope.parameters.end() ? nullptr : &found->second;
    };
}

// A type may name parameters, as "parts/rpf-${preset}.json".
Word Expander::type_of(const Scope& scope, const NodeText& text) {
    if (text.type.text.find('$') == std::string::npos) return text.type;
    const Bound bound = substitute(Json(text.type.text), lookup_in(scope));
    if (bound.known && bound.value.is(Json::Kind::text)) return {bound.value.text, text.type.place};
    // What is amiss with a parameter itself was complained of already.
    for (const Piece& piece : take_apart(text.type.text).list) {
        const ParameterText* named = piece.parameter ? scope.document->find_parameter(piece.text) : nullptr;
        if (named && (!named->decl.fallback || !named->decl.fallback->is(Json::Kind::text)))
            findings_.error(text.type.place, "'{}' stands in a type; expected a text or choice with a default", piece.text);
    }
    return {"", text.type.place};
}

void Expander::apply_options(Entity& entity, const std::string& path, Word& type, int& pin) {
    if (const SwapOption* swap = options_.swap_of(path)) {
        entity.swap = swap;
        entity.swapped_from = table_.catalog->find(type.text);
        type = swap->type;
        pin = swap->pin;
    }
    if (const BypassOption* bypass = options_.bypass_of(path)) {
        entity.bypass = true;
        entity.bypass_place = bypass->place;
    }
}

void Expander::leaf(Entity& entity, const std::string& path, const Word& type, int pin) {
    const NodeDecl* decl = table_.catalog->find(type.text);
    if (!decl) {
        entity.broken = true;
        std::vector<std::string> names;
        for (const NodeDecl* known : table_.catalog->all()) names.push_back(known->type);
        std::string hint = nearest_name(type.text, names);
        if (const std::string_view option = table_.catalog->option_of(type.text); !option.empty())
            hint = fmt::format("this build was made without it; configure with -D{}=ON", option);
        else if (!hint.empty())
            hint = fmt::format("did you mean '{}'?", hint);
        else if (type.text.find('/') != std::string::npos)
            hint = "a graph used as a node ends in '.json'";
        else
            hint = "'weft nodes' lists them";
        findings_.error(type.place, "no node type '{}'; {}", type.text, hint);
        return;
    }
    entity.decl = decl;
    if (const std::string problem = pin_problem(*decl, pin); !problem.empty())
        findings_.error(type.place, "{}", problem);
    if (entity.swap)  // what the new type does not have is dropped
        std::erase_if(entity.inputs,
                      [&](const InputText* in) { return decl->find_input(in->port.text) < 0; });

    entity.flat = int(table_.nodes.size());
    table_.nodes.emplace_back();
    FlatNode flat;
    flat.name = path;
    flat.type = decl;
    flat.entity = &entity;
    flat.place = entity.place;
    flat.removed = entity.bypass || entity.scope->removed;
    flat.inputs.resize(decl->inputs.size());
    if (!flat_names_.insert(path).second)
        findings_.error(entity.place,
                        "there are two nodes '{}' once sub-graphs are flattened; rename one", path);

    Owner owner{decl->type, {}};
    for (const ParamDecl& param : decl->params) owner.params.push_back(&param);
    const std::vector<Bound> bound = bind(entity, path, owner);
    for (size_t i = 0; i < bound.size(); ++i) {
        flat.params.push_back(bound[i].known ? bound[i].value : Json());
        const bool kept = decl->params[i].use == FileUse::write || !bound[i].known;
        flat.expressions.push_back(kept ? bound[i].expression : Json());
    }
    table_.nodes[size_t(entity.flat)] = std::move(flat);
}

const Document* Expander::find_graph(const Entity& entity, const Word& type) {
    namespace fs = std::filesystem;
    const fs::path folder = entity.scope->document->folder;
    const std::string beside = (folder / type.text).lexically_normal().string();
    std::string problem;
    // An option's path is the user's own, from where the program was started.
    std::error_code code;
    const bool own = entity.swap && fs::exists(type.text, code);
    const std::string path = own ? fs::path(type.text).lexically_normal().string() : beside;
    const Document* document = library_.file(path, problem);
    if (!document) findings_.error(type.place, "cannot read '{}': {}", path, problem);
    return document;
}

bool Expander::is_within_itself(const Scope& scope, const Document& document, const Word& type) {
    std::string chain;
    for (const Scope* s = &scope; s; s = s->outer()) {
        chain = fmt::format("{}{}{}",
                            std::filesystem::path(s->document->source->name).filename().string(),
                            chain.empty() ? "" : " -> ", chain);
        if (s->document->canonical != document.canonical) continue;
        findings_.error(type.place, "a graph cannot be a node of itself: {} -> {}", chain,
                        std::filesystem::path(document.source->name).filename().string());
        return true;
    }
    return false;
}

void Expander::graph(Entity& entity, const std::string& path, const Word& type) {
    const Document* document = find_graph(entity, type);
    entity.broken =
        !document || !document->readable || is_within_itself(*entity.scope, *document, type);
    if (entity.broken) return;
    if (entity.swap)
        std::erase_if(entity.inputs, [&](const InputText* in) {
            return std::none_of(document->inputs.begin(), document->inputs.end(),
                                [&](const GraphInput& g) { return g.name.text == in->port.text; });
        });

    entity.inner = std::make_unique<Scope>();
    Scope& inner = *entity.inner;
    inner.document = document;
    inner.entity = &entity;
    inner.prefix = path + "/";
    inner.removed = entity.bypass || entity.scope->removed;
    inner.outputs.resize(document->outputs.size());

    Owner owner{type.text, {}};
    for (const ParameterText& p : document->parameters) owner.params.push_back(&p.decl);
    std::vector<Bound> bound = bind(entity, path, owner);
    for (size_t i = 0; i < bound.size(); ++i)
        inner.parameters[document->parameters[i].decl.name] = std::move(bound[i]);
    graph_inputs(inner);
    unfold(inner);
}

const Setting* Expander::setting_of(const Entity& entity, std::string_view name) const {
    for (const Setting& setting : entity.text->settings)
        if (setting.name.text == name) return &setting;
    return nullptr;
}

std::vector<Bound> Expander::bind(Entity& entity, const std::string& path, const Owner& owner) {
    unknown_settings(entity, path, owner);
    std::vector<Bound> out;
    for (const ParamDecl* decl : owner.params) {
        Bound bound;
        bound.known = false;
        bool given = false;
        if (const Setting* setting = setting_of(entity, decl->name)) {
            bound = from_text(entity, path, *decl, *setting);
            given = true;
        } else if (decl->fallback && mismatch(*decl, *decl->fallback).empty()) {
            bound = {*decl->fallback, true, escaped(*decl->fallback)};
            given = true;
        }
        if (entity.swap)
            for (const SetOption& option : entity.swap->settings)
                if (option.name.text == decl->name) {
                    override_by(option, *decl, bound);
                    given = true;
                }
        if (const SetOption* option = options_.set_of(path, decl->name)) {
            override_by(*option, *decl, bound);
            given = true;
        }
        if (!given && !entity.bypass && !misspelt(entity, owner, decl->name))
            findings_.error(entity.swap ? entity.swap->place : entity.place,
                            "'{}' needs parameter '{}' ({}): '{}' has no default for it",
                            entity.name, decl->name, kind_text(*decl), owner.name);
        out.push_back(std::move(bound));
    }
    return out;
}

// Whether some unknown setting was meant for this parameter: one complaint is enough.
bool Expander::misspelt(const Entity& entity, const Owner& owner, const std::string& param) const {
    return std::any_of(entity.text->settings.begin(), entity.text->settings.end(),
                       [&](const Setting& setting) {
                           return !owner.find(setting.name.text) &&
                                  nearest_name(setting.name.text, owner.names()) == param;
                       });
}

// The value a document gives, with parameters of its graph filled in.
Bound Expander::from_text(Entity& entity, const std::string& path, const ParamDecl& decl,
                          const Setting& setting) {
    const Scope& scope = *entity.scope;
    Bound bound = substitute(setting.value, lookup_in(scope));
    if (setting.value.is(Json::Kind::text)) {
        const Pieces pieces = take_apart(setting.value.text);
        if (!pieces.problem.empty()) return bound;
        const ParameterText* from =
            pieces.whole ? scope.document->find_parameter(pieces.list[0].text) : nullptr;
        const std::string problem = from ? kind_problem(from->decl, decl) : "";
        if (!problem.empty()) {
            findings_.error(setting.value.place, "{}", problem);
            bound.known = false;
        }
        for (const Piece& piece : pieces.list) {
            const ParameterText* within =
                piece.parameter ? scope.document->find_parameter(piece.text) : nullptr;
            if (pieces.whole || !within) continue;
            const Kind kind = within->decl.kind;
            if (kind == Kind::list || kind == Kind::object || kind == Kind::color)
                findings_.error(setting.value.place,
                                "parameter '{}' is of type {}; it cannot stand within a text",
                                piece.text, name_of(kind));
        }
    }
    if (!bound.known) return bound;
    const std::string problem = mismatch(decl, bound.value);
    if (problem.empty()) return bound;
    const Place& place = bound.value.place;
    const bool own = !place.source || (place.source == setting.value.place.source &&
                                       place.begin == setting.value.place.begin);
    if (own)
        findings_.error(span(setting.value), "{}", problem);
    else
        findings_.error(span(bound.value), "{} ('{}' of '{}')", problem, decl.name, path);
    bound.known = false;
    return bound;
}

void Expander::override_by(const SetOption& option, const ParamDecl& decl, Bound& bound) {
    bound.value = option_value(option.value, decl.kind);
    const std::string problem = mismatch(decl, bound.value);
    bound.known = problem.empty();
    if (!bound.known) findings_.error(option.place, "{}", problem);
}

void Expander::unknown_settings(Entity& entity, const std::string& path, const Owner& owner) {
    const auto complain = [&](const Place& place, const std::string& name) {
        if (owner.params.empty())
            findings_.error(place, "'{}' has no parameters", owner.name);
        else
            findings_.error(place, "'{}' has no parameter '{}'{}", owner.name, name,
                            suggestion(name, owner.names()));
    };
    if (!entity.swap)  // else what the new type does not have is dropped
        for (const Setting& setting : entity.text->settings)
            if (!owner.find(setting.name.text)) complain(setting.name.place, setting.name.text);
    if (entity.swap)
        for (const SetOption& option : entity.swap->settings)
            if (!owner.find(option.name.text)) complain(option.place, option.name.text);
    for (SetOption& option : options_.set)
        if (option.node == path && !owner.find(option.name.text)) {
            option.used = true;
            complain(option.place, option.name.text);
        }
}

void Expander::unused_options() {
    const auto no_node = [&](const Place& place, const std::string& node) {
        // A node whose type is not known takes no settings: that was said already.
        if (std::find(paths_.begin(), paths_.end(), node) == paths_.end())
            findings_.error(place, "no node '{}'{}", node, suggestion(node, paths_));
    };
    for (const SwapOption& option : options_.swap)
        if (!option.used) no_node(option.place, option.node);
    for (const BypassOption& option : options_.bypass)
        if (!option.used) no_node(option.place, option.node);
    for (const SetOption& option : options_.set) {
        if (option.used) continue;
        if (!option.node.empty()) {
            no_node(option.place, option.node);
            continue;
        }
        std::vector<std::string> names;
        for (const GraphParameter& p : table_.parameters) names.push_back(p.decl.name);
        std::string hint = suggestion(option.name.text, names);
        if (names.empty()) hint = "; it has none, a node's is set as NODE.PARAMETER=VALUE";
        findings_.error(option.place, "the graph has no parameter '{}'{}", option.name.text, hint);
    }
}

std::string pin_problem(const NodeDecl& decl, int pin) {
    if (pin == 0 || pin == decl.version) return "";
    return fmt::format(
        "'{0}' is pinned to version {1}; this program has version {2}: '{0}@{2}' may give other "
        "pictures",
        decl.type, pin, decl.version);
}

}  // namespace weft::loading
