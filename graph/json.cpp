#include "graph/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace weft {

Json::Json(double value) : kind(Kind::number), number(value) {
    constexpr double whole = 9007199254740992.0;  // 2^53: beyond it doubles skip integers
    if (std::abs(value) <= whole && value == std::trunc(value) &&
        !(value == 0 && std::signbit(value))) {
        is_integer = true;
        integer = std::int64_t(value);
    }
}

Json::Json(std::int64_t value)
    : kind(Kind::number), is_integer(true), integer(value), number(double(value)) {}

Json::Json(std::uint64_t value)
    : kind(Kind::number),
      is_integer(true),
      is_unsigned(value > std::uint64_t(INT64_MAX)),
      integer(std::int64_t(value)),
      number(double(value)) {}

Json Json::list() { return list(std::vector<Json>()); }

Json Json::list(std::vector<Json> items) {
    Json json;
    json.kind = Kind::list;
    json.items = std::move(items);
    return json;
}

Json Json::object() {
    Json json;
    json.kind = Kind::object;
    return json;
}

const Json* Json::find(std::string_view key) const {
    for (const JsonMember& member : members)
        if (member.key == key) return &member.value;
    return nullptr;
}

Json* Json::find(std::string_view key) {
    return const_cast<Json*>(std::as_const(*this).find(key));
}

Json& Json::set(std::string_view key, Json value) {
    if (Json* there = find(key)) return *there = std::move(value);
    members.push_back({std::string(key), {}, std::move(value)});
    return members.back().value;
}

bool Json::operator==(const Json& other) const {
    if (kind != other.kind) return false;
    switch (kind) {
        case Kind::null:
            return true;
        case Kind::boolean:
            return boolean == other.boolean;
        case Kind::number:
            if (is_integer != other.is_integer || is_unsigned != other.is_unsigned) return false;
            return is_integer ? integer == other.integer : number == other.number;
        case Kind::text:
            return text == other.text;
        case Kind::list:
            return items == other.items;
        case Kind::object:
            break;
    }
    return members.size() == other.members.size() &&
           std::all_of(members.begin(), members.end(), [&](const JsonMember& member) {
               const Json* value = other.find(member.key);
               return value && *value == member.value;
           });
}

std::string_view name_of(Json::Kind kind) {
    switch (kind) {
        case Json::Kind::null:
            return "null";
        case Json::Kind::boolean:
            return "true or false";
        case Json::Kind::number:
            return "a number";
        case Json::Kind::text:
            return "a text";
        case Json::Kind::list:
            return "a list";
        case Json::Kind::object:
            return "an object";
    }
    return "";
}

namespace {

void write_text(std::string_view text, std::string& out) {
    out += '"';
    for (const char c : text) {
        switch (c) {
            case '"':
                out += "\\\"";
                break;
            case '\\':
                out += "\\\\";
                break;
            case '\n':
                out += "\\n";
                break;
            case '\t':
                out += "\\t";
                break;
            case '\r':
                out += "\\r";
                break;
            default:
                if (static_cast<unsigned char>(c) < 0x20)
                    out += fmt::format("\\u{:04x}", int(c));
                else
                    out += c;
        }
    }
    out += '"';
}

void write_number(const Json& value, std::string& out) {
    if (value.is_unsigned)
        fmt::format_to(std::back_inserter(out), "{}", std::uint64_t(value.integer));
    else if (value.is_integer)
        fmt::format_to(std::back_inserter(out), "{}", value.integer);
    else if (value.number == 0)
        out += "-0.0";
    else if (std::isfinite(value.number))
        fmt::format_to(std::back_inserter(out), "{}", value.number);  // shortest that reads back
    else
        out += "null";  // JSON has no word for it
}

// `depth` < 0: on one line.
void write_json(const Json& value, int depth, std::string& out) {
    const auto new_line = [&](int d) {
        if (depth < 0) return;
        out += '\n';
        out.append(size_t(2 * d), ' ');
    };
    const int inner = depth < 0 ? -1 : depth + 1;
    const std::string_view comma = depth < 0 ? ", " : ",";
    switch (value.kind) {
        case Json::Kind::null:
            out += "null";
            break;
        case Json::Kind::boolean:
            out += value.boolean ? "true" : "false";
            break;
        case Json::Kind::number:
            write_number(value, out);
            break;
        case Json::Kind::text:
            write_text(value.text, out);
            break;
        case Json::Kind::list: {
            // Lists of plain values (a colour, sizes) stay on one line.
            const bool plain =
                std::none_of(value.items.begin(), value.items.end(), [](const Json& item) {
                    return item.is(Json::Kind::list) || item.is(Json::Kind::object);
                });
            out += '[';
            for (size_t i = 0; i < value.items.size(); ++i) {
                if (i) out += plain ? std::string_view(", ") : comma;
                if (!plain) new_line(inner);
                write_json(value.items[i], inner, out);
            }
            if (!plain) new_line(depth);
            out += ']';
            break;
        }
        case Json::Kind::object:
            out += '{';
            for (size_t i = 0; i < value.members.size(); ++i) {
                if (i) out += comma;
                new_line(inner);
                write_text(value.members[i].key, out);
                out += ": ";
                write_json(value.members[i].value, inner, out);
            }
            if (!value.members.empty()) new_line(depth);
            out += '}';
            break;
    }
}

}  // namespace

std::string Json::dump(bool indented) const {
    std::string out;
    write_json(*this, indented ? 0 : -1, out);
    return out;
}

}  // namespace weft
