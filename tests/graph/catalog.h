// A catalog of node types for the tests of graphs: a small family of pictures and one of streams.
#pragma once
#include <algorithm>
#include <deque>

#include "graph/declaration.h"

namespace weft::test {

class TestCatalog : public Catalog {
  public:
    TestCatalog() {
        add("read-samples", "samples", 2, {}, {out("samples", "Samples")},
            {file("file", FileUse::read)});
        add("pixel-filter", "filters", 1, {in("samples", "Samples")}, {out("color", "Image")},
            {choice("filter", {"box", "tent", "gauss"}), number("width", 1.0, 0.1, 64, "px"),
             list("channels", Json::list({"rgb"}))});
        add("bilateral-filter", "filters", 1,
            {in("color", "Image"), in("guide", "Image", Need::optional)}, {out("color", "Image")},
            {number("sigma-space", 2.0, 0.1, 64, "px"),
             number("sigma-range", 0.1, 1e-4, 1e3, "guide"), integer("passes", 1, 1, 8),
             color("tint")});
        add("median-filter", "filters", 1, {in("color", "Image")}, {out("picture", "Image")},
            {integer("passes", 2, 1, 4)});
        add("split-image", "filters", 1, {in("color", "Image")},
            {out("low", "Image"), out("high", "Image"), out("error", "Table")}, {});
        add("contact-sheet", "image", 1, {in("pictures", "Image", Need::variadic)},
            {out("image", "Image")}, {text("title", "")});
        add("write-image", "image", 1, {in("image", "Image")}, {},
            {file("file", FileUse::write), boolean("half", true)});
        last().writes = true;
        add("write-table", "image", 3, {in("table", "Table")}, {},
            {file("file", FileUse::write, "out/table.json"), required("rows", Kind::integer)});
        last().writes = true;

        add("output-locations", "light-field", 1, {in("samples", "Samples")},
            {stream_out("locations", "Locations"), per_batch("slice", "Slice")},
            {integer("per-pixel", 128, 1, 65536)});
        add("reproject", "light-field", 1,
            {stream("locations", "Locations"), in("samples", "Samples")},
            {stream_out("candidates", "Candidates")}, {number("radius", 1.0, 0.1, 10, "px")});
        add("coverage", "light-field", 1,
            {stream("candidates", "Candidates"), stream("slice", "Slice", Need::optional)},
            {stream_out("colors", "Colors"), selection("undecided", "Locations")}, {});
        add("merge-colors", "light-field", 1,
            {stream("first", "Colors"), branch("again", "Colors"), branch("last", "Colors")},
            {stream_out("colors", "Colors")}, {});
        last().inputs[2].need = Need::optional;
        add("mix-colors", "light-field", 1, {stream("a", "Colors"), stream("b", "Colors")},
            {stream_out("colors", "Colors")}, {});
        add("tint-colors", "light-field", 1,
            {stream("colors", "Colors"), in("by", "Image", Need::optional)},
            {stream_out("colors", "Colors")}, {});
        add("accumulate", "light-field", 1, {stream("colors", "Colors")}, {out("image", "Image")},
            {});
    }

    const NodeDecl* find(std::string_view type) const override {
        for (const NodeDecl& decl : decls_)
            if (decl.type == type) return &decl;
        return nullptr;
    }
    std::string_view option_of(std::string_view type) const override {
        return type == "dependency-estimate" ? "WEFT_RPF" : "";
    }
    std::vector<const NodeDecl*> all() const override {
        std::vector<const NodeDecl*> out;
        for (const NodeDecl& decl : decls_) out.push_back(&decl);
        std::sort(out.begin(), out.end(), [](const NodeDecl* a, const NodeDecl* b) {
            return std::pair(a->family, a->type) < std::pair(b->family, b->type);
        });
        return out;
    }

  private:
    using Ports = std::vector<PortDecl>;
    using Params = std::vector<ParamDecl>;
    void add(std::string type, std::string family, int version, Ports in, Ports out,
             Params params) {
        NodeDecl& decl = decls_.emplace_back();
        decl.type = std::move(type);
        decl.about = "a node of the tests";
        decl.family = std::move(family);
        decl.version = version;
        decl.inputs = std::move(in);
        decl.outputs = std::move(out);
        decl.params = std::move(params);
    }
    NodeDecl& last() { return decls_.back(); }

    static PortDecl in(std::string name, std::string type, Need need = Need::required) {
        return {std::move(name), "what goes in", std::move(type), false, need};
    }
    static PortDecl out(std::string name, std::string type) {
        return in(std::move(name), std::move(type));
    }
    static PortDecl stream(std::string name, std::string type, Need need = Need::required) {
        PortDecl port = in(std::move(name), std::move(type), need);
        port.stream = true;
        return port;
    }
    static PortDecl stream_out(std::string name, std::string type) {
        return stream(std::move(name), std::move(type));
    }
    static PortDecl branch(std::string name, std::string type) {
        PortDecl port = stream(std::move(name), std::move(type));
        port.branch = true;
        return port;
    }
    static PortDecl selection(std::string name, std::string type) {
        PortDecl port = stream(std::move(name), std::move(type));
        port.selects = true;
        return port;
    }
    static PortDecl per_batch(std::string name, std::string type) {
        PortDecl port = stream(std::move(name), std::move(type));
        port.per_batch = true;
        return port;
    }

    static ParamDecl param(std::string name, Kind kind) {
        ParamDecl decl;
        decl.name = std::move(name);
        decl.about = "a parameter of the tests";
        decl.kind = kind;
        return decl;
    }
    static ParamDecl required(std::string name, Kind kind) { return param(std::move(name), kind); }
    static ParamDecl number(std::string name, double fallback, double low, double high,
                            std::string unit) {
        ParamDecl decl = param(std::move(name), Kind::number);
        decl.fallback = Json(fallback);
        decl.minimum = low;
        decl.maximum = high;
        decl.unit = std::move(unit);
        return decl;
    }
    static ParamDecl integer(std::string name, int fallback, double low, double high) {
        ParamDecl decl = number(std::move(name), fallback, low, high, "");
        decl.kind = Kind::integer;
        return decl;
    }
    static ParamDecl boolean(std::string name, bool fallback) {
        ParamDecl decl = param(std::move(name), Kind::boolean);
        decl.fallback = Json(fallback);
        return decl;
    }
    static ParamDecl text(std::string name, const char* fallback) {
        ParamDecl decl = param(std::move(name), Kind::text);
        decl.fallback = Json(fallback);
        return decl;
    }
    static ParamDecl list(std::string name, Json fallback) {
        ParamDecl decl = param(std::move(name), Kind::list);
        decl.fallback = std::move(fallback);
        return decl;
    }
    static ParamDecl color(std::string name) {
        ParamDecl decl = param(std::move(name), Kind::color);
        decl.fallback = Json::list({1, 1, 1});
        return decl;
    }
    static ParamDecl choice(std::string name, std::vector<std::string> choices) {
        ParamDecl decl = param(std::move(name), Kind::choice);
        decl.fallback = Json(choices[0]);
        decl.choices = std::move(choices);
        return decl;
    }
    static ParamDecl file(std::string name, FileUse use, const char* fallback = "") {
        ParamDecl decl = param(std::move(name), Kind::file);
        decl.use = use;
        decl.fallback = Json(fallback);
        return decl;
    }

    std::deque<NodeDecl> decls_;
};

}  // namespace weft::test
