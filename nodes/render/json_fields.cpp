#include "render/json_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/error.h"

namespace weft {

JsonFields::JsonFields(const Json* object, std::string what, std::vector<Diagnostic>& findings)
    : object_(object), what_(std::move(what)), findings_(findings) {
    if (object_ && !object_->is(Json::Kind::object)) {
        finding(object_,
                fmt::format("{} is {}; expected an object", what_, name_of(object_->kind)));
        object_ = nullptr;
    }
}

void JsonFields::finding(const Json* at, std::string message) const {
    findings_.push_back({Diagnostic::Level::error, std::move(message), at ? at->place : Place{}});
}

const Json* JsonFields::any(std::string_view key) {
    asked_.emplace_back(key);
    return object_ ? object_->find(key) : nullptr;
}

namespace {

std::string wrong(std::string_view key, const Json& value, std::string_view expected) {
    return fmt::format("'{}' is {}; expected {}", key, name_of(value.kind), expected);
}

}  // namespace

const Json* JsonFields::list(std::string_view key) {
    const Json* v = any(key);
    if (!v || v->is(Json::Kind::list)) return v;
    finding(v, wrong(key, *v, "a list"));
    return nullptr;
}

const Json* JsonFields::object(std::string_view key) {
    const Json* v = any(key);
    if (!v || v->is(Json::Kind::object)) return v;
    finding(v, wrong(key, *v, "an object"));
    return nullptr;
}

float JsonFields::number(std::string_view key, float fallback, double low, double high) {
    const Json* v = any(key);
    if (!v) return fallback;
    if (!v->is(Json::Kind::number)) {
        finding(v, wrong(key, *v, "a number"));
        return fallback;
    }
    if (!(v->number >= low && v->number <= high)) {
        finding(v, fmt::format("'{}' is {}; expected {} to {}", key, v->number, low, high));
        return fallback;
    }
    return float(v->number);
}

bool JsonFields::flag(std::string_view key, bool fallback) {
    const Json* v = any(key);
    if (!v) return fallback;
    if (!v->is(Json::Kind::boolean)) finding(v, wrong(key, *v, "true or false"));
    return v->is(Json::Kind::boolean) ? v->boolean : fallback;
}

std::string JsonFields::text(std::string_view key, const std::string& fallback) {
    const Json* v = any(key);
    if (!v) return fallback;
    if (!v->is(Json::Kind::text)) finding(v, wrong(key, *v, "a text"));
    return v->is(Json::Kind::text) ? v->text : fallback;
}

std::vector<float> JsonFields::numbers(std::string_view key, size_t least, size_t most) {
    const Json* v = list(key);
    if (!v) return {};
    std::vector<float> all;
    for (const Json& item : v->items)
        if (item.is(Json::Kind::number) && std::fabs(item.number) <= 1e30)
            all.push_back(float(item.number));
    if (all.size() == v->items.size() && all.size() >= least && all.size() <= most) return all;
    finding(v, least == most
                   ? fmt::format("'{}' is not a list of {} numbers", key, least)
                   : fmt::format("'{}' is not a list of {} to {} numbers", key, least, most));
    return {};
}

Vec3 JsonFields::vector(std::string_view key, Vec3 fallback) {
    const std::vector<float> v = numbers(key, 3, 3);
    return v.empty() ? fallback : Vec3{v[0], v[1], v[2]};
}

Vec3 JsonFields::color(std::string_view key, Vec3 fallback, double high) {
    const Json* v = object_ ? object_->find(key) : nullptr;
    Vec3 c = fallback;
    if (v && v->is(Json::Kind::number)) {
        const float grey = number(key, 0, 0, high);
        return {grey, grey, grey};
    }
    c = vector(key, fallback);
    if (v && (std::min({c.x, c.y, c.z}) < 0 || std::max({c.x, c.y, c.z}) > high)) {
        finding(v, fmt::format("'{}' has a number outside 0 to {}", key, high));
        return fallback;
    }
    return c;
}

size_t JsonFields::choice(std::string_view key, const std::vector<std::string>& names,
                          size_t fallback) {
    const Json* v = any(key);
    if (!v) return fallback;
    if (v->is(Json::Kind::text)) {
        const auto found = std::find(names.begin(), names.end(), v->text);
        if (found != names.end()) return size_t(found - names.begin());
        finding(v, fmt::format("no {} '{}'{}", key, v->text, suggestion(v->text, names)));
    } else {
        finding(v, wrong(key, *v, "a text"));
    }
    return fallback;
}

Affine JsonFields::placed() {
    const Vec3 angles = vector("rotate", {});
    Vec3 size{1, 1, 1};
    const Json* v = object_ ? object_->find("scale") : nullptr;
    if (v && v->is(Json::Kind::number))
        size = Vec3{1, 1, 1} * number("scale", 1);
    else
        size = vector("scale", size);
    if (size.x == 0 || size.y == 0 || size.z == 0) {
        finding(v, "'scale' is 0; expected another number");
        size = {1, 1, 1};
    }
    Affine at = rotate({0, 0, 1}, radians(angles.z)) * rotate({0, 1, 0}, radians(angles.y)) *
                rotate({1, 0, 0}, radians(angles.x)) * weft::scale(size);
    at.origin = vector("at", {});
    return at;
}

void JsonFields::end() {
    if (!object_) return;
    for (const JsonMember& member : object_->members)
        if (std::find(asked_.begin(), asked_.end(), member.key) == asked_.end())
            findings_.push_back(
                {Diagnostic::Level::error,
                 fmt::format("{} has no '{}'{}", what_, member.key, suggestion(member.key, asked_)),
                 member.key_place});
}

void throw_findings(const std::vector<Diagnostic>& findings) {
    std::vector<std::string> lines;  // a part that stands in many places is told once
    for (const Diagnostic& f : findings) {
        if (f.level != Diagnostic::Level::error) continue;
        const std::string at = where(f.place);
        std::string line = fmt::format("{}{}{}", at, at.empty() ? "" : ": ", f.message);
        if (std::find(lines.begin(), lines.end(), line) == lines.end())
            lines.push_back(std::move(line));
    }
    constexpr size_t most = 20;
    if (lines.size() > most) {
        const size_t more = lines.size() - most;
        lines.resize(most);
        lines.push_back(fmt::format("{} more", more));
    }
    if (!lines.empty()) throw Error(fmt::format("{}", fmt::join(lines, "\n")));
}

}  // namespace weft
