#include "samples/sample_meta.h"

#include <fmt/format.h>

#include <cmath>

#include "graph/error.h"
#include "runtime/context.h"

namespace weft {
namespace {

class Meta {
  public:
    Meta(const Json& object, const std::string& file) : object_(object), file_(file) {}

    [[noreturn]] void fail(const std::string& message) const {
        throw Error(fmt::format("{}: meta: {}", file_, message));
    }
    // A member that is there and not null.
    const Json* find(const Json& object, std::string_view key) const {
        const Json* value = object.find(key);
        return value && !value->is(Json::Kind::null) ? value : nullptr;
    }
    int positive(std::string_view key) const {
        const Json* value = find(object_, key);
        if (!value) fail(fmt::format("no '{}'", key));
        return positive(key, *value);
    }
    int positive(std::string_view key, const Json& value) const {
        if (!value.is_integer || value.is_unsigned || value.integer < 1 || value.integer > 1 << 30)
            fail(fmt::format("'{}' is {}; expected a whole number from 1", key, value.dump()));
        return int(value.integer);
    }
    std::string text(std::string_view key, std::string fallback) const {
        const Json* value = find(object_, key);
        if (!value) return fallback;
        if (!value->is(Json::Kind::text))
            fail(fmt::format("'{}' is {}; expected text", key, value->dump()));
        return value->text;
    }
    float number(const Json& object, std::string_view key, float fallback) const {
        const Json* value = find(object, key);
        return value ? number(key, *value) : fallback;
    }
    float number(std::string_view key, const Json& value) const {
        if (!value.is(Json::Kind::number) || !std::isfinite(float(value.number)))
            fail(fmt::format("'{}' is {}; expected a number", key, value.dump()));
        return float(value.number);
    }
    std::optional<Lens> lens() const {
        const Json* value = find(object_, "lens");
        if (!value) return std::nullopt;
        if (!value->is(Json::Kind::object))
            fail(fmt::format("'lens' is {}; expected an object", value->dump()));
        const Json* coc = find(*value, "coc");
        if (!coc || !coc->is(Json::Kind::list) || coc->items.size() != 2)
            fail("'lens' has no 'coc'; expected [C0, C1]");
        Lens lens;
        lens.c0 = number("coc", coc->items[0]);
        lens.c1 = number("coc", coc->items[1]);
        lens.aspect = number(*value, "aspect", 1);
        if (!(lens.aspect > 0)) fail(fmt::format("'aspect' is {}; expected above 0", lens.aspect));
        lens.rotation = number(*value, "rotation", 0);
        const float blades = number(*value, "blades", 0);
        if (blades != std::floor(blades) || blades < 0 || blades > 1024 ||
            (blades > 0 && blades < 3))
            fail(fmt::format("'blades' is {}; expected 0 (round) or 3 and more", blades));
        lens.blades = int(blades);
        return lens;
    }

  private:
    const Json& object_;
    const std::string& file_;
};

}  // namespace

void read_meta(std::string_view text, const std::string& file, Samples& samples) {
    samples.meta = parse_json_or_throw(text, file + ": meta");
    const Meta meta(samples.meta, file);
    if (!samples.meta.is(Json::Kind::object))
        meta.fail(fmt::format("is {}; expected an object", name_of(samples.meta.kind)));
    const Json* version = meta.find(samples.meta, "weft_samples");
    if (!version) meta.fail("no 'weft_samples'; expected {\"weft_samples\": 1, ...}");
    if (!version->is_integer || version->integer != 1)
        meta.fail(fmt::format("format version {}; this program reads version 1", version->dump()));
    samples.width = meta.positive("width");
    samples.height = meta.positive("height");
    const Json* spp = meta.find(samples.meta, "spp");
    samples.spp = spp ? meta.positive("spp", *spp) : 0;
    samples.color_space = meta.text("color_space", "lin_rec709");
    samples.domain = meta.text("domain", "camera");
    if (samples.domain != "camera" && samples.domain != "light")
        meta.fail(fmt::format("'domain' is '{}'; expected 'camera' or 'light'", samples.domain));
    samples.lens = meta.lens();
    if (const Json* roles = meta.find(samples.meta, "roles");
        roles && !roles->is(Json::Kind::object))
        meta.fail(fmt::format("'roles' is {}; expected an object", roles->dump()));
}

Role role_in_meta(const Json& meta, const std::string& file, std::string_view channel) {
    const Json* roles = meta.find("roles");
    const Json* role = roles ? roles->find(channel) : nullptr;
    if (!role) return standard_role(channel);
    for (Role known : {Role::none, Role::position, Role::random, Role::feature, Role::radiance})
        if (role->is(Json::Kind::text) && role->text == name_of(known)) return known;
    throw Error(
        fmt::format("{}: meta: role of '{}' is {}; expected position, random, feature, "
                    "radiance or none",
                    file, channel, role->dump()));
}

Json meta_to_write(const Samples& samples, const Context& ctx) {
    Json meta = samples.meta_object();
    const Provenance& run = ctx.provenance();
    if (!run.graph.empty()) meta.set("weft:graph", run.graph);
    if (!run.inputs.empty()) meta.set("weft:inputs", run.inputs);
    if (!run.version.empty()) meta.set("weft:version", run.version);
    return meta;
}

}  // namespace weft
