#include "graph/declaration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace weft {
namespace {

// The shorter of 0.0001 and 1e-4, of 1000 and 1e3.
std::string limit_text(double value, Kind kind) {
    std::string plain = fmt::format("{}", value);
    if (kind == Kind::integer) return fmt::format("{:.0f}", value);
    std::string scientific = fmt::format("{:e}", value);  // "1.000000e-04"
    const size_t e = scientific.find('e');
    if (e == std::string::npos) return plain;
    int exponent = std::stoi(scientific.substr(e + 1));
    // The mantissa with as few digits as read back.
    for (int digits = 0; digits <= 16; ++digits) {
        std::string trial = fmt::format("{:.{}e}", value, digits);
        if (std::stod(trial) != value) continue;
        exponent = std::stoi(trial.substr(trial.find('e') + 1));
        scientific = fmt::format("{}e{}", trial.substr(0, trial.find('e')), exponent);
        break;
    }
    return scientific.size() < plain.size() ? scientific : plain;
}

std::string range_text(const ParamDecl& decl) {
    const bool low = std::isfinite(decl.minimum), high = std::isfinite(decl.maximum);
    const std::string unit = decl.unit.empty() ? "" : fmt::format(" ({})", decl.unit);
    if (low && high)
        return fmt::format("{} to {}{}", limit_text(decl.minimum, decl.kind),
                           limit_text(decl.maximum, decl.kind), unit);
    if (low) return fmt::format("at least {}{}", limit_text(decl.minimum, decl.kind), unit);
    return fmt::format("at most {}{}", limit_text(decl.maximum, decl.kind), unit);
}

// As the user wrote it, where that can be known.
std::string shown(const Json& value) {
    std::string text;
    const Place& place = value.place;
    if (value.is(Json::Kind::number) && place.source && place.end <= place.source->text.size() &&
        place.begin < place.end)
        text = place.source->text.substr(place.begin, place.end - place.begin);
    else
        text = value.dump();
    constexpr size_t most = 60;
    if (text.size() > most) text = text.substr(0, most) + "...";
    return text;
}

bool fits_kind(Kind kind, const Json& value) {
    switch (kind) {
        case Kind::number:
            return value.is(Json::Kind::number) && std::isfinite(value.number);
        case Kind::integer:
            return value.is(Json::Kind::number) && value.is_integer;
        case Kind::boolean:
            return value.is(Json::Kind::boolean);
        case Kind::text:
        case Kind::choice:
        case Kind::file:
            return value.is(Json::Kind::text);
        case Kind::color:
            return value.is(Json::Kind::list) && value.items.size() == 3 &&
                   std::all_of(value.items.begin(), value.items.end(),
                               [](const Json& item) { return item.is(Json::Kind::number); });
        case Kind::list:
            return value.is(Json::Kind::list);
        case Kind::object:
            return value.is(Json::Kind::object);
    }
    return false;
}

std::string_view expected(Kind kind) {
    switch (kind) {
        case Kind::number:
            return "a number";
        case Kind::integer:
            return "a whole number";
        case Kind::boolean:
            return "true or false";
        case Kind::text:
            return "a text";
        case Kind::choice:
            return "a text";
        case Kind::file:
            return "a file name";
        case Kind::color:
            return "a list of three numbers, [r, g, b]";
        case Kind::list:
            return "a list";
        case Kind::object:
            return "an object";
    }
    return "";
}

int index_of(const std::vector<PortDecl>& ports, std::string_view name) {
    for (size_t i = 0; i < ports.size(); ++i)
        if (ports[i].name == name) return int(i);
    return -1;
}

}  // namespace

std::string_view name_of(Kind kind) {
    switch (kind) {
        case Kind::number:
            return "number";
        case Kind::integer:
            return "integer";
        case Kind::boolean:
            return "boolean";
        case Kind::text:
            return "text";
        case Kind::choice:
            return "choice";
        case Kind::file:
            return "file";
        case Kind::color:
            return "color";
        case Kind::list:
            return "list";
        case Kind::object:
            return "object";
    }
    return "";
}

const ParamDecl* NodeDecl::find_param(std::string_view name) const {
    for (const ParamDecl& param : params)
        if (param.name == name) return &param;
    return nullptr;
}

int NodeDecl::find_input(std::string_view name) const {
    return index_of(inputs, name);
}
int NodeDecl::find_output(std::string_view name) const {
    return index_of(outputs, name);
}

std::string mismatch(const ParamDecl& decl, const Json& value) {
    if (decl.kind == Kind::choice && !decl.choices.empty()) {
        const bool known =
            value.is(Json::Kind::text) &&
            std::find(decl.choices.begin(), decl.choices.end(), value.text) != decl.choices.end();
        if (known) return "";
        return fmt::format("{} is {}; expected {}'{}'", decl.name, shown(value),
                           decl.choices.size() > 1 ? "one of " : "",
                           fmt::join(decl.choices, "', '"));
    }
    if (!fits_kind(decl.kind, value)) {
        const bool ranged = decl.kind == Kind::number || decl.kind == Kind::integer;
        const bool limited = ranged && (std::isfinite(decl.minimum) || std::isfinite(decl.maximum));
        return fmt::format("{} is {}; expected {}{}", decl.name, shown(value), expected(decl.kind),
                           limited ? ", " + range_text(decl) : "");
    }
    if (decl.kind == Kind::number || decl.kind == Kind::integer)
        if (value.number < decl.minimum || value.number > decl.maximum)
            return fmt::format("{} is {}; expected {}", decl.name, shown(value), range_text(decl));
    if (decl.kind == Kind::file && value.text.empty() && !decl.optional_file)
        return fmt::format("{} is empty; expected a file name", decl.name);
    if (decl.kind == Kind::file && value.text.find('\0') != std::string::npos)
        return fmt::format("{} holds a zero byte; expected a file name", decl.name);
    return "";
}

}  // namespace weft
