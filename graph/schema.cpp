// The JSON Schema of graph documents: for editors, and for checking documents by other programs. It
// accepts every document the checker accepts; what depends on other parts of a text (links, names
// of parameters, sub-graphs) only the checker can see.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/graph.h"

namespace weft {
namespace {

Json object(std::initializer_list<std::pair<const char*, Json>> members) {
    Json out = Json::object();
    for (const auto& [key, value] : members) out.set(key, value);
    return out;
}

Json defined(const std::string& name) {
    return object({{"$ref", "#/$defs/" + name}});
}

Json any_of(std::vector<Json> choices) {
    return object({{"anyOf", Json::list(std::move(choices))}});
}

Json texts(const std::vector<std::string>& list) {
    return Json::list(std::vector<Json>(list.begin(), list.end()));
}

// An object with these members and no other.
Json closed(Json properties, const std::vector<std::string>& required = {}) {
    Json out = object({{"type", "object"},
                       {"properties", std::move(properties)},
                       {"additionalProperties", false}});
    if (!required.empty()) out.set("required", texts(required));
    return out;
}

// An object with names of the user's own.
Json named(const char* pattern, Json value) {
    return object({{"type", "object"},
                   {"propertyNames", object({{"pattern", pattern}})},
                   {"additionalProperties", std::move(value)}});
}

Json kind_schema(Kind kind) {
    switch (kind) {
        case Kind::number:
            return object({{"type", "number"}});
        case Kind::integer:
            return object({{"type", "integer"}});
        case Kind::boolean:
            return object({{"type", "boolean"}});
        case Kind::text:
        case Kind::choice:
        case Kind::file:
            return object({{"type", "string"}});
        case Kind::color:
            return object({{"type", "array"},
                           {"items", any_of({object({{"type", "number"}}), defined("reference")})},
                           {"minItems", 3},
                           {"maxItems", 3}});
        case Kind::list:
            return object({{"type", "array"}});
        case Kind::object:
            return object({{"type", "object"}});
    }
    return true;
}

bool has_default(const ParamDecl& decl) {
    return decl.fallback && mismatch(decl, *decl.fallback).empty();
}

// A value given to a node's parameter: of its kind, or made of parameters of the graph.
Json value_schema(const ParamDecl& decl) {
    Json value = kind_schema(decl.kind);
    if (std::isfinite(decl.minimum)) value.set("minimum", decl.minimum);
    if (std::isfinite(decl.maximum)) value.set("maximum", decl.maximum);
    if (decl.kind == Kind::file && !decl.optional_file) value.set("minLength", 1);
    if (!decl.choices.empty()) value.set("enum", texts(decl.choices));
    const bool textual = decl.kind == Kind::text || decl.kind == Kind::file;
    Json out = textual ? value
                       : any_of({std::move(value),
                                 defined(decl.kind == Kind::choice ? "made-text" : "reference")});
    std::string about = decl.about;
    if (!decl.unit.empty()) about += fmt::format("{}({})", about.empty() ? "" : " ", decl.unit);
    if (!about.empty()) out.set("description", about);
    if (has_default(decl)) out.set("default", *decl.fallback);
    return out;
}

Json node_schema(const NodeDecl& decl) {
    Json inputs = Json::object(), params = Json::object();
    std::vector<std::string> needed_inputs, needed_params;
    for (const PortDecl& port : decl.inputs) {
        Json link =
            port.need == Need::variadic
                ? any_of({defined("link"),
                          object({{"type", "array"}, {"items", defined("link")}, {"minItems", 1}})})
                : defined("link");
        link.set("description",
                 fmt::format("{}{}{}", port.type, port.about.empty() ? "" : ": ", port.about));
        inputs.set(port.name, std::move(link));
        if (port.need != Need::optional) needed_inputs.push_back(port.name);
    }
    for (const ParamDecl& param : decl.params) {
        params.set(param.name, value_schema(param));
        if (!has_default(param)) needed_params.push_back(param.name);
    }
    Json out =
        object({{"description", decl.about},
                {"properties",
                 object({{"in", closed(std::move(inputs))}, {"set", closed(std::move(params))}})}});
    if (needed_inputs.empty() && needed_params.empty()) return out;
    // A bypassed node needs nothing; a repeated one has a parameter from its list.
    Json needs = object({{"properties", Json::object()}});
    std::vector<std::string> parts;
    const auto need = [&](const char* part, const std::vector<std::string>& names) {
        if (names.empty()) return;
        parts.emplace_back(part);
        needs.find("properties")->set(part, object({{"required", texts(names)}}));
    };
    need("in", needed_inputs);
    need("set", needed_params);
    needs.set("required", texts(parts));
    out.set("if", any_of({object({{"properties", object({{"bypass", object({{"const", true}})}})},
                                  {"required", texts({"bypass"})}}),
                          object({{"required", texts({"each"})}})}));
    out.set("else", std::move(needs));
    return out;
}

Json parameter_schema() {
    std::vector<std::string> kinds;
    std::vector<Json> rules;
    for (const Kind kind : {Kind::number, Kind::integer, Kind::boolean, Kind::text, Kind::choice,
                            Kind::file, Kind::color, Kind::list, Kind::object}) {
        const std::string name(name_of(kind));
        kinds.push_back(name);
        Json value = kind_schema(kind);
        if (kind == Kind::color) value.set("items", object({{"type", "number"}}));
        Json then = object({{"properties", object({{"default", std::move(value)}})}});
        Json& properties = *then.find("properties");
        if (kind != Kind::number && kind != Kind::integer) {
            properties.set("minimum", false);
            properties.set("maximum", false);
        }
        if (kind == Kind::choice)
            then.set("required", texts({"choices"}));
        else
            properties.set("choices", false);
        rules.push_back(
            object({{"if", object({{"properties", object({{"type", object({{"const", name}})}})}})},
                    {"then", std::move(then)}}));
    }
    Json out = closed(object({{"type", object({{"enum", texts(kinds)}})},
                              {"default", true},
                              {"minimum", object({{"type", "number"}})},
                              {"maximum", object({{"type", "number"}})},
                              {"choices", object({{"type", "array"},
                                                  {"items", object({{"type", "string"}})},
                                                  {"minItems", 1}})},
                              {"unit", object({{"type", "string"}})},
                              {"about", object({{"type", "string"}})}}),
                      {"type"});
    out.set("allOf", Json::list(std::move(rules)));
    return out;
}

constexpr const char* name_pattern = "^[a-z0-9_-]+$";
constexpr const char* path_pattern = "^[a-z0-9_-]+(/[a-z0-9_-]+)*$";

}  // namespace

Json graph_schema(const Catalog& catalog) {
    Json definitions = Json::object();
    definitions.set(
        "link",
        object({{"type", "string"},
                {"pattern", "^[^.]+(\\.[^.]+)?$"},
                {"description", "'node.port', or 'node' where it has one output that fits"}}));
    definitions.set("reference", object({{"type", "string"},
                                         {"pattern", "^\\$[a-z0-9_-]+$"},
                                         {"description", "a parameter of the graph"}}));
    definitions.set("made-text",
                    object({{"type", "string"},
                            {"pattern", "^\\$[a-z0-9_-]+$|\\$\\{[a-z0-9_-]+(\\.stem)?\\}"},
                            {"description", "a text with parameters of the graph"}}));
    definitions.set("parameter", parameter_schema());

    std::vector<Json> types, rules;
    for (const NodeDecl* decl : catalog.all()) {
        const std::vector<std::string> names{decl->type,
                                             fmt::format("{}@{}", decl->type, decl->version)};
        for (const std::string& name : names) types.emplace_back(name);
        definitions.set("node:" + decl->type, node_schema(*decl));
        rules.push_back(object(
            {{"if", object({{"properties", object({{"type", object({{"enum", texts(names)}})}})},
                            {"required", texts({"type"})}})},
             {"then", defined("node:" + decl->type)}}));
    }
    Json type = any_of(
        {object({{"enum", Json::list(std::move(types))}}),
         object(
             {{"type", "string"}, {"pattern", "\\.json$"}, {"description", "a graph as a node"}})});
    Json links = object(
        {{"type", "object"},
         {"additionalProperties",
          any_of({defined("link"), object({{"type", "array"}, {"items", defined("link")}})})}});
    Json node = closed(object({{"type", std::move(type)},
                               {"in", std::move(links)},
                               {"set", object({{"type", "object"}})},
                               {"each", object({{"type", "object"},
                                                {"minProperties", 1},
                                                {"maxProperties", 1},
                                                {"additionalProperties",
                                                 any_of({object({{"type", "array"}}),
                                                         defined("reference")})}})},
                               {"carry", object({{"type", "object"},
                                                 {"additionalProperties",
                                                  object({{"type", "string"}})}})},
                               {"bypass", object({{"type", "boolean"}})},
                               {"about", object({{"type", "string"}})}}),
                       {"type"});
    if (!rules.empty()) node.set("allOf", Json::list(std::move(rules)));
    definitions.set("node", std::move(node));

    std::vector<std::string> port_types;
    for (const NodeDecl* decl : catalog.all())
        for (const auto* ports : {&decl->inputs, &decl->outputs})
            for (const PortDecl& port : *ports)
                if (std::find(port_types.begin(), port_types.end(), port.type) == port_types.end())
                    port_types.push_back(port.type);
    std::sort(port_types.begin(), port_types.end());
    definitions.set("input", closed(object({{"type", object({{"enum", texts(port_types)}})},
                                            {"optional", object({{"type", "boolean"}})},
                                            {"about", object({{"type", "string"}})}}),
                                    {"type"}));

    Json out = object(
        {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "Weft graph"}});
    Json document = closed(object({{"$schema", object({{"type", "string"}})},
                                   {"weft", object({{"const", document_version}})},
                                   {"about", object({{"type", "string"}})},
                                   {"parameters", named(name_pattern, defined("parameter"))},
                                   {"inputs", named(name_pattern, defined("input"))},
                                   {"outputs", named(name_pattern, defined("link"))},
                                   {"nodes", named(path_pattern, defined("node"))},
                                   {"layout", true}}),
                           {"weft", "nodes"});
    for (JsonMember& member : document.members) out.set(member.key, std::move(member.value));
    out.set("$defs", std::move(definitions));
    return out;
}

}  // namespace weft
