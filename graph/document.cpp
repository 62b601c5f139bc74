#include "graph/document.h"

#include <cmath>
#include <initializer_list>

#include "graph/graph.h"
#include "graph/substitution.h"

namespace weft::loading {
namespace {

bool name_characters(std::string_view name, bool slashes) {
    if (name.empty()) return false;
    for (size_t i = 0; i < name.size(); ++i) {
        const char c = name[i];
        const bool inner = i > 0 && i + 1 < name.size() && name[i - 1] != '/';
        if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_') continue;
        if (c == '/' && slashes && inner) continue;
        return false;
    }
    return true;
}

// The parts of a document, each read where it stands; what is wrong is noted and left out.
class Reader {
  public:
    Reader(Document& document, Findings& findings) : document_(document), findings_(findings) {}

    void read(const Json& root) {
        if (!expect(root, Json::Kind::object, "the document")) return;
        if (!version(root)) return;
        document_.readable = true;
        keys(root,
             {"weft", "about", "parameters", "inputs", "outputs", "nodes", "layout", "$schema"});
        if (const Json* about = text(root, "about")) document_.about = about->text;
        text(root, "$schema");
        each(root, "parameters", [&](const JsonMember& m) { parameter(m); });
        each(root, "inputs", [&](const JsonMember& m) { input(m); });
        each(root, "nodes", [&](const JsonMember& m) { node(m); });
        each(root, "outputs", [&](const JsonMember& m) { output(m); });
        if (!root.find("nodes"))
            findings_.error(span(root), "the document has no 'nodes'; expected \"nodes\": {{...}}");
        for (const ParameterText& p : document_.parameters)
            if (!p.used)
                findings_.error(
                    p.place,
                    "no node uses parameter '{}'; write \"${}\" where it is meant, or remove it",
                    p.decl.name, p.decl.name);
    }

  private:
    bool expect(const Json& value, Json::Kind kind, const std::string& what) {
        if (value.is(kind)) return true;
        findings_.error(span(value), "{} is {}; expected {}", what, name_of(value.kind),
                        name_of(kind));
        return false;
    }
    void keys(const Json& object, std::initializer_list<const char*> known) {
        const std::vector<std::string> names(known.begin(), known.end());
        for (const JsonMember& member : object.members)
            if (std::find(names.begin(), names.end(), member.key) == names.end())
                findings_.error(member.key_place, "unknown key '{}'{}", member.key,
                                suggestion(member.key, names));
    }
    const Json* member(const Json& object, std::string_view key, Json::Kind kind) {
        const Json* value = object.find(key);
        return value && expect(*value, kind, fmt::format("'{}'", key)) ? value : nullptr;
    }
    const Json* text(const Json& object, std::string_view key) {
        return member(object, key, Json::Kind::text);
    }
    bool flag(const Json& object, std::string_view key) {
        const Json* value = member(object, key, Json::Kind::boolean);
        return value && value->boolean;
    }
    template <class Read>
    void each(const Json& root, std::string_view key, Read&& read) {
        if (const Json* object = member(root, key, Json::Kind::object))
            for (const JsonMember& m : object->members) read(m);
    }
    bool name(const JsonMember& m, std::string_view what, bool slashes = false) {
        if (name_characters(m.key, slashes)) return true;
        findings_.error(m.key_place,
                        "'{}' cannot be the name of {}; expected a-z, 0-9, '-' and '_'", m.key,
                        what);
        return false;
    }

    bool version(const Json& root) {
        const Json* weft = root.find("weft");
        if (!weft) {
            findings_.error(span(root),
                            "the document does not say its version; expected \"weft\": {}",
                            document_version);
            return true;  // the rest is worth reading
        }
        if (!weft->is(Json::Kind::number) || !weft->is_integer || weft->integer < 1) {
            findings_.error(span(*weft), "'weft' is the document's version; expected {}",
                            document_version);
            return true;
        }
        if (weft->number > document_version) {
            findings_.error(
                weft->place,
                "this is a document of version {}; this program reads up to version {}, a newer "
                "one is needed",
                weft->dump(), document_version);
            return false;
        }
        return true;
    }

    void parameter(const JsonMember& m) {
        name(m, "a parameter");
        if (!expect(m.value, Json::Kind::object, fmt::format("parameter '{}'", m.key))) return;
        ParameterText p;
        ParamDecl& decl = p.decl;
        decl.name = m.key;
        p.place = m.key_place;
        p.used = !name_characters(m.key, false);  // one complaint is enough
        keys(m.value, {"type", "default", "minimum", "maximum", "choices", "unit", "about"});
        if (const Json* about = text(m.value, "about")) decl.about = about->text;
        if (const Json* unit = text(m.value, "unit")) decl.unit = unit->text;
        if (!kind(m, decl)) {
            p.used = true;
            p.decl.kind = Kind::object;
            unreadable_.push_back(m.key);
            return;
        }
        limits(m, decl);
        choices(m, decl);
        if (const Json* value = m.value.find("default")) {
            const std::string problem = mismatch(decl, *value);
            if (problem.empty())
                decl.fallback = *value;
            else
                findings_.error(span(*value), "{}", problem);
        }
        document_.parameters.push_back(std::move(p));
    }
    bool kind(const JsonMember& m, ParamDecl& decl) {
        std::vector<std::string> names;
        const Json* type = m.value.find("type");
        if (!type) {
            findings_.error(
                m.key_place,
                "parameter '{}' has no 'type'; expected number, integer, boolean, text, "
                "choice, file, color, list or object",
                m.key);
            return false;
        }
        if (!expect(*type, Json::Kind::text, "'type'")) return false;
        for (const Kind k : {Kind::number, Kind::integer, Kind::boolean, Kind::text, Kind::choice,
                             Kind::file, Kind::color, Kind::list, Kind::object}) {
            if (name_of(k) == type->text) {
                decl.kind = k;
                return true;
            }
            names.emplace_back(name_of(k));
        }
        findings_.error(type->place, "no parameter type '{}'{}", type->text,
                        suggestion(type->text, names));
        return false;
    }
    void limits(const JsonMember& m, ParamDecl& decl) {
        const bool ranged = decl.kind == Kind::number || decl.kind == Kind::integer;
        for (const std::string_view key : {"minimum", "maximum"}) {
            const Json* value = m.value.find(key);
            if (!value) continue;
            if (!ranged) {
                findings_.error(span(*value),
                                "'{}' is for numbers and integers; '{}' is of type {}", key, m.key,
                                name_of(decl.kind));
            } else if (expect(*value, Json::Kind::number, fmt::format("'{}'", key))) {
                (key == "minimum" ? decl.minimum : decl.maximum) = value->number;
            }
        }
        if (decl.minimum > decl.maximum) {
            findings_.error(m.value.find("maximum")->place,
                            "the maximum of '{}' is below its minimum", m.key);
            decl.maximum = std::numeric_limits<double>::infinity();
        }
    }
    void choices(const JsonMember& m, ParamDecl& decl) {
        const Json* value = m.value.find("choices");
        if (!value) {
            if (decl.kind == Kind::choice)
                findings_.error(m.key_place,
                                "parameter '{}' is a choice, of nothing; expected "
                                "\"choices\": [\"...\"]",
                                m.key);
            return;
        }
        if (decl.kind != Kind::choice) {
            findings_.error(span(*value),
                            "'choices' are for parameters of type choice; '{}' is of type {}",
                            m.key, name_of(decl.kind));
            return;
        }
        if (!expect(*value, Json::Kind::list, "'choices'")) return;
        if (value->items.empty()) findings_.error(value->place, "'choices' is empty");
        for (const Json& item : value->items)
            if (expect(item, Json::Kind::text, "a choice")) decl.choices.push_back(item.text);
    }

    void input(const JsonMember& m) {
        name(m, "an input");
        if (!expect(m.value, Json::Kind::object, fmt::format("input '{}'", m.key))) return;
        keys(m.value, {"type", "optional", "about"});
        text(m.value, "about");
        GraphInput in;
        in.name = {m.key, m.key_place};
        in.optional = flag(m.value, "optional");
        if (const Json* type = text(m.value, "type"))
            in.type = {type->text, type->place};
        else if (!m.value.find("type"))
            findings_.error(m.key_place, "input '{}' has no 'type'; expected one as \"Samples\"",
                            m.key);
        document_.inputs.push_back(std::move(in));
    }

    void output(const JsonMember& m) {
        name(m, "an output");
        if (!expect(m.value, Json::Kind::text, fmt::format("output '{}'", m.key))) return;
        GraphOutput out;
        out.name = {m.key, m.key_place};
        if (link(m.value, out.link)) document_.outputs.push_back(std::move(out));
    }

    bool link(const Json& value, LinkText& link) {
        if (!expect(value, Json::Kind::text, "a link")) return false;
        link.place = value.place;
        if (split_link(value.text, link)) return true;
        findings_.error(value.place, "'{}' is no link; expected 'node' or 'node.port'", value.text);
        return false;
    }

    void node(const JsonMember& m) {
        NodeText node;
        node.name = {m.key, m.key_place};
        name(m, "a node", true);
        if (!expect(m.value, Json::Kind::object, fmt::format("node '{}'", m.key))) {
            document_.nodes.push_back(std::move(node));  // links to it lead somewhere
            return;
        }
        keys(m.value, {"type", "in", "set", "each", "carry", "bypass", "about"});
        text(m.value, "about");
        for (const GraphInput& in : document_.inputs)
            if (in.name.text == m.key)
                findings_.error(
                    m.key_place,
                    "'{}' is an input of this graph already; give the node another name", m.key);
        type(m, node);
        if (const Json* in = member(m.value, "in", Json::Kind::object))
            for (const JsonMember& port : in->members) node_input(port, node);
        if (const Json* set = member(m.value, "set", Json::Kind::object))
            for (const JsonMember& value : set->members) setting(value, node);
        repeat(m.value, node);
        node.bypass = flag(m.value, "bypass");
        if (const Json* bypass = m.value.find("bypass")) node.bypass_place = bypass->place;
        document_.nodes.push_back(std::move(node));
    }
    void type(const JsonMember& m, NodeText& node) {
        const Json* type = text(m.value, "type");
        if (!type) {
            if (!m.value.find("type"))
                findings_.error(m.key_place, "node '{}' has no 'type'", m.key);
            return;
        }
        references(*type);
        node.type = {type->text, type->place};
        node.pin = take_pin(node.type.text);
        if (node.pin < 0) {
            findings_.error(type->place, "'{}' pins no version; expected a number after '@'",
                            type->text);
            node.pin = 0;
        }
    }
    void node_input(const JsonMember& m, NodeText& node) {
        InputText in;
        in.port = {m.key, m.key_place};
        in.is_list = m.value.is(Json::Kind::list);
        if (!in.is_list && !m.value.is(Json::Kind::text)) {
            findings_.error(span(m.value),
                            "'{}' is {}; expected a link as \"node.port\", or a list of them",
                            m.key, name_of(m.value.kind));
            unread_input(node, std::move(in));
            return;
        }
        LinkText one;
        if (!in.is_list) {
            if (link(m.value, one)) in.links.push_back(one);
        } else {
            for (const Json& item : m.value.items)
                if (link(item, one)) in.links.push_back(one);
        }
        node.inputs.push_back(std::move(in));
    }
    void repeat(const Json& value, NodeText& node) {
        if (const Json* each = member(value, "each", Json::Kind::object)) {
            if (each->members.size() != 1) {
                findings_.error(span(*each),
                                "'each' names {} parameters; expected one, and the list of its "
                                "values",
                                each->members.size());
            } else {
                const JsonMember& m = each->members[0];
                references(m.value);
                node.each = Setting{{m.key, m.key_place}, m.value};
            }
        }
        const Json* carry = member(value, "carry", Json::Kind::object);
        if (!carry) return;
        if (!value.find("each"))
            findings_.error(span(*carry), "'carry' is for a node with 'each'");
        for (const JsonMember& m : carry->members) {
            if (!expect(m.value, Json::Kind::text, "an output")) continue;
            const bool linked =
                std::any_of(node.inputs.begin(), node.inputs.end(),
                            [&](const InputText& in) { return in.port.text == m.key; });
            if (linked)
                node.carry.push_back({{m.key, m.key_place}, {m.value.text, m.value.place}});
            else
                findings_.error(m.key_place,
                                "'carry' names input '{}', which is not linked; the first node "
                                "takes it from 'in'",
                                m.key);
        }
    }
    // Kept, so that it does not look missing as well.
    static void unread_input(NodeText& node, InputText in) { node.inputs.push_back(std::move(in)); }

    // Parameters that a value names are used, and must be there.
    void references(const Json& value) {
        for_each_reference(
            value,
            [&](const std::string& parameter, const Place& place) {
                std::vector<std::string> names;
                for (ParameterText& p : document_.parameters) {
                    if (p.decl.name == parameter) {
                        p.used = true;
                        return;
                    }
                    names.push_back(p.decl.name);
                }
                if (std::find(unreadable_.begin(), unreadable_.end(), parameter) !=
                    unreadable_.end())
                    return;
                const std::string hint = suggestion(parameter, names);
                findings_.error(place, "this graph has no parameter '{}'{}", parameter, hint);
                // Not unused as well, if it was meant.
                const std::string near = nearest_name(parameter, names);
                for (ParameterText& p : document_.parameters)
                    if (p.decl.name == near) p.used = true;
            },
            [&](const std::string& problem, const Place& place) {
                findings_.error(place, "{}", problem);
            });
    }

    void setting(const JsonMember& m, NodeText& node) {
        references(m.value);
        node.settings.push_back({{m.key, m.key_place}, m.value});
    }

    Document& document_;
    Findings& findings_;
    std::vector<std::string> unreadable_;  // parameters that have been complained of
};

}  // namespace

const ParameterText* Document::find_parameter(std::string_view name) const {
    for (const ParameterText& p : parameters)
        if (p.decl.name == name) return &p;
    return nullptr;
}

Place span(const Json& value) {
    Place place = value.place;
    if (value.is(Json::Kind::object) || value.is(Json::Kind::list))
        place.end = std::min(place.end, place.begin + 1);
    return place;
}

int take_pin(std::string& type) {
    const size_t at = type.rfind('@');
    if (at == std::string::npos) return 0;
    const std::string digits = type.substr(at + 1);
    type.resize(at);
    if (digits.empty() || digits.size() > 6 ||
        digits.find_first_not_of("0123456789") != std::string::npos)
        return -1;
    return std::stoi(digits) > 0 ? std::stoi(digits) : -1;
}

bool is_graph_file(std::string_view type) {
    return type.ends_with(".json");
}

bool split_link(std::string_view text, LinkText& link) {
    const size_t dot = text.find('.');
    link.node = std::string(text.substr(0, dot));
    link.port = dot == std::string_view::npos ? "" : std::string(text.substr(dot + 1));
    return !link.node.empty() && (dot == std::string_view::npos || !link.port.empty());
}

Document read_document(const SourcePtr& source, Findings& findings) {
    Document document;
    document.source = source;
    findings.add_source(source);
    bool whole = false;
    const Json root = parse_json(source, findings.list(), &whole);
    // After a syntax error the rest of the text is not known: nothing more can be said of it.
    if (whole) Reader(document, findings).read(root);
    return document;
}

}  // namespace weft::loading
