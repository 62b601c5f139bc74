#include "graph/substitution.h"

#include <algorithm>
#include <cctype>

namespace weft::loading {
namespace {

// Wider than what a parameter can be called, so that "$Width" gets to hear of 'width'.
bool is_name(std::string_view text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_';
    });
}

std::string doubled(std::string_view text) {
    std::string out;
    for (const char c : text) out += c == '$' ? "$$" : std::string(1, c);
    return out;
}

// How a value reads inside a text; none for lists and objects.
std::optional<std::string> inner_text(const Json& value) {
    if (value.is(Json::Kind::text)) return value.text;
    if (value.is(Json::Kind::number) || value.is(Json::Kind::boolean)) return value.dump();
    return std::nullopt;
}

std::string written(const Piece& piece) {
    if (!piece.parameter) return doubled(piece.text);
    return fmt::format("${{{}{}}}", piece.text, piece.stem ? ".stem" : "");
}

// The expression of a text's stem, if it can be written down.
std::optional<std::string> stem_of_expression(const Json& expression) {
    Pieces pieces = take_apart(expression.text);
    if (pieces.list.empty()) return "";
    Piece& last = pieces.list.back();
    if (last.parameter) {
        if (last.stem) return std::nullopt;
        last.stem = true;
    } else {
        // The extension must lie in the literal end, or it depends on what stands before.
        const std::string_view cut = stem(last.text);
        const bool has_slash = last.text.find('/') != std::string::npos;
        if (cut.size() == last.text.size() && !has_slash && pieces.list.size() > 1)
            return std::nullopt;
        last.text = std::string(cut);
    }
    std::string out;
    for (const Piece& piece : pieces.list) out += written(piece);
    return out;
}

// One parameter within a text: as expression, or none.
std::optional<std::string> inner_expression(const Bound& bound, bool take_stem) {
    if (bound.expression.is(Json::Kind::null)) return std::nullopt;
    const std::optional<std::string> plain = inner_text(bound.expression);
    if (!plain) return std::nullopt;
    if (!bound.expression.is(Json::Kind::text)) return doubled(take_stem ? stem(*plain) : *plain);
    if (take_stem) {
        if (auto text = stem_of_expression(bound.expression)) return text;
        if (const auto value = inner_text(bound.value)) return doubled(stem(*value));
        return std::nullopt;
    }
    const Pieces pieces = take_apart(*plain);
    return pieces.whole ? fmt::format("${{{}}}", pieces.list[0].text) : *plain;
}

Bound substitute_text(const Json& value, const Lookup& lookup) {
    const Pieces pieces = take_apart(value.text);
    Bound out;
    out.value = value;
    if (!pieces.problem.empty()) {
        out.known = false;
        return out;
    }
    if (pieces.whole) {
        const Bound* bound = lookup(pieces.list[0].text);
        if (bound) return *bound;
        out.known = false;
        return out;
    }
    std::string text;
    std::optional<std::string> expression = "";
    for (const Piece& piece : pieces.list) {
        if (!piece.parameter) {
            text += piece.text;
            if (expression) *expression += doubled(piece.text);
            continue;
        }
        const Bound* bound = lookup(piece.text);
        const std::optional<std::string> inner =
            bound && bound->known ? inner_text(bound->value) : std::nullopt;
        if (inner)
            text += piece.stem ? std::string(stem(*inner)) : *inner;
        else
            out.known = false;
        const auto e = bound ? inner_expression(*bound, piece.stem) : std::nullopt;
        if (e && expression)
            *expression += *e;
        else
            expression.reset();
    }
    out.value.text = std::move(text);
    if (expression) out.expression = Json(*expression);
    return out;
}

}  // namespace

Pieces take_apart(std::string_view text) {
    Pieces out;
    if (text.size() > 1 && text[0] == '$' && is_name(text.substr(1))) {
        out.whole = true;
        out.list.push_back({std::string(text.substr(1)), true, false});
        return out;
    }
    std::string literal;
    const auto flush = [&] {
        if (!literal.empty()) out.list.push_back({std::move(literal), false, false});
        literal.clear();
    };
    for (size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '$') {
            literal += text[i];
        } else if (i + 1 < text.size() && text[i + 1] == '$') {
            literal += '$';
            ++i;
        } else if (i + 1 < text.size() && text[i + 1] == '{') {
            const size_t close = text.find('}', i);
            std::string_view name =
                text.substr(i + 2, close == std::string_view::npos ? 0 : close - i - 2);
            const size_t dot = name.find('.');
            const std::string_view part = dot == std::string_view::npos ? "" : name.substr(dot + 1);
            if (close == std::string_view::npos) {
                out.problem = "'${' is not closed; expected '}'";
                return out;
            }
            if (!is_name(name.substr(0, dot)) ||
                (dot != std::string_view::npos && part != "stem")) {
                out.problem = fmt::format(
                    "'${{{}}}' names no parameter; expected '${{name}}' or '${{name.stem}}'", name);
                return out;
            }
            flush();
            out.list.push_back({std::string(name.substr(0, dot)), true, part == "stem"});
            i = close;
        } else {
            const size_t stop = std::min(text.find_first_of("./ $", i + 1), text.size());
            const std::string_view name = text.substr(i + 1, stop - i - 1);
            out.problem = is_name(name)
                              ? fmt::format(
                                    "within a text a parameter is written '${{{0}}}', not "
                                    "'${0}'; a dollar is '$$'",
                                    name)
                              : "a '$' stands for a parameter; write '$$' for a dollar";
            return out;
        }
    }
    flush();
    return out;
}

void for_each_reference(
    const Json& value, const std::function<void(const std::string& name, const Place&)>& named,
    const std::function<void(const std::string& problem, const Place&)>& wrong) {
    if (value.is(Json::Kind::text)) {
        if (value.text.find('$') == std::string::npos) return;
        const Pieces pieces = take_apart(value.text);
        if (!pieces.problem.empty()) wrong(pieces.problem, value.place);
        for (const Piece& piece : pieces.list)
            if (piece.parameter) named(piece.text, value.place);
    }
    for (const Json& item : value.items) for_each_reference(item, named, wrong);
    for (const JsonMember& member : value.members) for_each_reference(member.value, named, wrong);
}

Bound substitute(const Json& value, const Lookup& lookup) {
    if (value.is(Json::Kind::text)) return substitute_text(value, lookup);
    Bound out;
    out.value = value;
    out.expression = value;
    const auto place = [&](const Json& inner, Json& v, Json& e) {
        Bound bound = substitute(inner, lookup);
        out.known = out.known && bound.known;
        v = std::move(bound.value);
        e = std::move(bound.expression);
    };
    for (size_t i = 0; i < value.items.size(); ++i)
        place(value.items[i], out.value.items[i], out.expression.items[i]);
    for (size_t i = 0; i < value.members.size(); ++i)
        place(value.members[i].value, out.value.members[i].value, out.expression.members[i].value);
    return out;
}

Json escaped(const Json& value) {
    Json out = value;
    if (out.is(Json::Kind::text)) out.text = doubled(out.text);
    for (Json& item : out.items) item = escaped(item);
    for (JsonMember& member : out.members) member.value = escaped(member.value);
    return out;
}

std::string_view stem(std::string_view path) {
    const size_t slash = path.rfind('/');
    const size_t name = slash == std::string_view::npos ? 0 : slash + 1;
    const size_t dot = path.rfind('.');
    return dot == std::string_view::npos || dot <= name ? path : path.substr(0, dot);
}

std::string kind_problem(const ParamDecl& from, const ParamDecl& to) {
    const auto is_text = [](Kind kind) { return kind == Kind::text || kind == Kind::file; };
    const bool fits = from.kind == to.kind ||
                      (from.kind == Kind::integer && to.kind == Kind::number) ||
                      (is_text(from.kind) && is_text(to.kind)) ||
                      (from.kind == Kind::choice && to.kind == Kind::text) ||
                      (from.kind == Kind::color && to.kind == Kind::list);
    if (!fits)
        return fmt::format("parameter '{}' is of type {}; '{}' takes {}", from.name,
                           name_of(from.kind), to.name, name_of(to.kind));
    if (from.kind == Kind::choice && to.kind == Kind::choice)
        for (const std::string& choice : from.choices)
            if (std::find(to.choices.begin(), to.choices.end(), choice) == to.choices.end())
                return fmt::format("parameter '{}' may be '{}', which '{}' does not know{}",
                                   from.name, choice, to.name, suggestion(choice, to.choices));
    return "";
}

}  // namespace weft::loading
