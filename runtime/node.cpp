#include "runtime/node.h"

#include <fmt/format.h>

#include <cstring>

#include "runtime/registry.h"

namespace weft {

void Items::add(std::string_view name, std::uint64_t count) {
    for (size_t i = 0; i < used_; ++i)
        if (items_[i].name == name) {
            items_[i].count += count;
            return;
        }
    if (used_ < std::size(items_)) items_[used_++] = {name, count};
}

const std::vector<std::string>& Inputs::names(std::string_view port) const {
    static const std::vector<std::string> none;
    for (const auto& [name, nodes] : linked)
        if (name == port) return nodes;
    return none;
}

// Reaching these is a mistake in a node, not in the user's graph: the checker has seen to links.
void Inputs::missing(std::string_view port) {
    throw Error(fmt::format("input '{}' is read but neither declared nor linked", port));
}
void Outputs::missing(std::string_view port) {
    throw Error(fmt::format("output '{}' is filled but neither declared nor read", port));
}

std::string family_of(std::string_view file) {
    const size_t name = file.rfind('/');
    if (name == std::string_view::npos || name == 0) return "other";
    const size_t folder = file.rfind('/', name - 1);
    return std::string(file.substr(folder == std::string_view::npos ? 0 : folder + 1,
                                   name - (folder == std::string_view::npos ? 0 : folder + 1)));
}

namespace detail {

void note_type(const TypeInfo& info) { Registry::instance().note(info); }

void read(const Json& value, float& to) { to = float(value.number); }
void read(const Json& value, double& to) { to = value.number; }
void read(const Json& value, int& to) { to = int(value.integer); }
void read(const Json& value, std::uint64_t& to) { to = std::uint64_t(value.integer); }
void read(const Json& value, bool& to) { to = value.boolean; }
void read(const Json& value, std::string& to) { to = value.text; }
void read(const Json& value, InputFile& to) { to.path = value.text; }
void read(const Json& value, OutputFile& to) { to.path = value.text; }
void read(const Json& value, std::array<float, 3>& to) {
    for (size_t i = 0; i < 3 && i < value.items.size(); ++i) to[i] = float(value.items[i].number);
}
void read(const Json& value, std::vector<float>& to) {
    to.clear();
    for (const Json& item : value.items) to.push_back(float(item.number));
}
void read(const Json& value, std::vector<std::string>& to) {
    to.clear();
    for (const Json& item : value.items) to.push_back(item.text);
}
void read(const Json& value, Json& to) { to = value; }

namespace {

ParamDecl with(Kind kind, Json fallback) {
    ParamDecl p;
    p.kind = kind;
    p.fallback = std::move(fallback);
    return p;
}

// The shortest decimal that reads back as this float: 0.1, not 0.10000000149.
Json shortest(float value) { return Json(std::stod(fmt::format("{}", value))); }

}  // namespace

ParamDecl declare(float value) { return with(Kind::number, shortest(value)); }
ParamDecl declare(double value) { return with(Kind::number, Json(value)); }
ParamDecl declare(int value) { return with(Kind::integer, Json(value)); }
ParamDecl declare(std::uint64_t value) {
    ParamDecl p = with(Kind::integer, Json(value));
    p.minimum = 0;
    return p;
}
ParamDecl declare(bool value) { return with(Kind::boolean, Json(value)); }
ParamDecl declare(const std::string& value) { return with(Kind::text, Json(value)); }
ParamDecl declare(const InputFile& value) {
    ParamDecl p = with(Kind::file, Json(value.path));
    p.use = FileUse::read;
    return p;
}
ParamDecl declare(const OutputFile& value) {
    ParamDecl p = with(Kind::file, Json(value.path));
    p.use = FileUse::write;
    return p;
}
ParamDecl declare(const std::array<float, 3>& value) {
    return with(Kind::color, Json::list({shortest(value[0]), shortest(value[1]), shortest(value[2])}));
}
ParamDecl declare(const std::vector<float>& value) {
    Json list = Json::list();
    for (float v : value) list.items.push_back(shortest(v));
    return with(Kind::list, std::move(list));
}
ParamDecl declare(const std::vector<std::string>& value) {
    Json list = Json::list();
    for (const std::string& v : value) list.items.push_back(Json(v));
    return with(Kind::list, std::move(list));
}
ParamDecl declare(const Json& value) { return with(Kind::object, value.is(Json::Kind::object) ? value : Json::object()); }

}  // namespace detail
}  // namespace weft
