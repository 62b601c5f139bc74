#include "samples/samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "graph/error.h"

namespace weft {
namespace {

struct Standard {
    std::string_view name;
    int components;
    Role role;
};

// The names of docs/formats.md.
constexpr std::array standard_channels = {
    Standard{"xy", 2, Role::position},        Standard{"uv", 2, Role::random},
    Standard{"t", 1, Role::random},           Standard{"z", 1, Role::none},
    Standard{"motion", 3, Role::none},        Standard{"z_gradient", 2, Role::none},
    Standard{"rgb", 3, Role::radiance},       Standard{"alpha", 1, Role::none},
    Standard{"weight", 1, Role::none},        Standard{"light_uv", 2, Role::random},
    Standard{"bounce", 0, Role::random},      Standard{"position", 3, Role::feature},
    Standard{"normal", 3, Role::feature},     Standard{"geometric_normal", 3, Role::none},
    Standard{"albedo", 3, Role::feature},     Standard{"roughness", 1, Role::none},
    Standard{"emission", 3, Role::radiance},  Standard{"id", 1, Role::none},
    Standard{"direct", 3, Role::radiance},    Standard{"direct_unshadowed", 3, Role::radiance},
    Standard{"light_index", 1, Role::none},   Standard{"diffuse", 3, Role::radiance},
    Standard{"specular", 3, Role::radiance},  Standard{"position2", 3, Role::feature},
    Standard{"normal2", 3, Role::feature},    Standard{"albedo2", 3, Role::feature},
    Standard{"shadow_hit", 3, Role::none},    Standard{"shadow_normal", 3, Role::none},
    Standard{"shadow_motion", 3, Role::none}, Standard{"light_point", 3, Role::none},
};

const Standard* find_standard(std::string_view channel) {
    for (const Standard& s : standard_channels)
        if (s.name == channel) return &s;
    return nullptr;
}

// The shortest number that reads back as this float.
Json short_number(float value) {
    return Json(std::stod(fmt::format("{}", value)));
}

Json lens_json(const Lens& lens) {
    Json object = Json::object();
    object.set("coc", Json::list({short_number(lens.c0), short_number(lens.c1)}));
    object.set("aspect", short_number(lens.aspect));
    object.set("blades", lens.blades);
    object.set("rotation", short_number(lens.rotation));
    return object;
}

}  // namespace

std::string_view name_of(Role role) {
    switch (role) {
        case Role::position:
            return "position";
        case Role::random:
            return "random";
        case Role::feature:
            return "feature";
        case Role::radiance:
            return "radiance";
        case Role::none:
            break;
    }
    return "none";
}

Role standard_role(std::string_view channel) {
    const Standard* s = find_standard(channel);
    return s ? s->role : Role::none;
}

bool is_standard_channel(std::string_view channel) {
    return find_standard(channel) != nullptr;
}

int standard_components(std::string_view channel) {
    const Standard* s = find_standard(channel);
    return s ? s->components : 0;
}

const Channel* Samples::find(std::string_view channel) const {
    for (const Channel& c : channels)
        if (c.name == channel) return &c;
    return nullptr;
}

std::span<const float> Samples::values(std::string_view channel) const {
    const Channel* c = find(channel);
    return c ? c->values.view() : std::span<const float>();
}

void Samples::add(Channel channel) {
    if (channels.empty() && size_ == 0) {
        const size_t values = channel.whole() ? channel.ids.size() : channel.values.size();
        size_ = values / size_t(std::max(channel.components, 1));
    }
    for (Channel& c : channels)
        if (c.name == channel.name) {
            c = std::move(channel);
            return;
        }
    channels.push_back(std::move(channel));
}

void Samples::add(std::string name, int components, std::vector<float> values) {
    const Role role = standard_role(name);
    add(Channel{std::move(name), components, role, Array<float>(std::move(values)), {}});
}

void Samples::add_ids(std::string name, std::vector<std::uint32_t> ids) {
    const Role role = standard_role(name);
    add(Channel{std::move(name), 1, role, {}, Array<std::uint32_t>(std::move(ids))});
}

Json Samples::meta_object() const {
    Json object = meta.is(Json::Kind::object) ? meta : Json::object();
    object.set("weft_samples", 1);
    object.set("width", width);
    object.set("height", height);
    object.set("spp", spp > 0 ? Json(spp) : Json());
    object.set("color_space", color_space);
    object.set("domain", domain);
    object.set("lens", lens ? lens_json(*lens) : Json());
    const Json* old = object.find("roles");
    Json roles = old && old->is(Json::Kind::object) ? *old : Json::object();
    for (const Channel& c : channels)
        if (c.role != standard_role(c.name) || roles.find(c.name))
            roles.set(c.name, name_of(c.role));
    object.set("roles", std::move(roles));
    return object;
}

void Samples::require(std::string_view who, std::initializer_list<std::string_view> wanted) const {
    std::vector<std::string_view> missing, have;
    for (std::string_view name : wanted)
        if (!find(name)) missing.push_back(name);
    if (missing.empty()) return;
    for (const Channel& c : channels) have.push_back(c.name);
    throw Error(fmt::format(
        "'{}' needs {}, this buffer has {}; render with {}, or list {} in "
        "'channels' of read-samples if the file has {}",
        who, fmt::join(missing, ", "), fmt::join(have, ", "), missing.size() > 1 ? "them" : "it",
        missing.size() > 1 ? "them" : "it", missing.size() > 1 ? "them" : "it"));
}

size_t Samples::bytes() const {
    size_t sum = first.size() * sizeof(std::uint64_t);
    for (const Channel& c : channels)
        sum += c.values.size() * sizeof(float) + c.ids.size() * sizeof(std::uint32_t);
    return sum;
}

void Samples::count(Items& items) const {
    items.add("samples", size_);
}

void Samples::describe(FieldVisitor& visitor) const {
    for (const Channel& c : channels) {
        if (c.whole())
            visitor.field(c.name, c.ids.view(), c.components);
        else
            visitor.field(c.name, c.values.view(), c.components);
    }
}

}  // namespace weft
