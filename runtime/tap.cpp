#include "runtime/tap.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "graph/diagnostic.h"
#include "runtime/atomic_file.h"
#include "runtime/registry.h"

namespace weft {
namespace {

Json number(float value) {
    // JSON has no infinity and no NaN; they are written as text.
    if (value != value) return Json("nan");
    if (value - value != 0) return Json(value > 0 ? "inf" : "-inf");
    return Json(std::stod(fmt::format("{}", value)));
}
Json number(std::uint32_t value) { return Json(std::int64_t{value}); }

template <class T>
Json slice(std::span<const T> values, size_t begin, size_t end, int components) {
    const auto one = [&](size_t i) {
        if (components == 1) return number(values[i]);
        Json list = Json::list();
        for (int c = 0; c < components; ++c) list.items.push_back(number(values[i * size_t(components) + size_t(c)]));
        return list;
    };
    Json list = Json::list();
    for (size_t i = begin; i < end && (i + 1) * size_t(components) <= values.size(); ++i) list.items.push_back(one(i));
    return list;
}

// All arrays of a value, as lists.
class WholeValue final : public FieldVisitor {
  public:
    Json out = Json::object();
    void field(std::string_view name, std::span<const float> values, int components) override {
        out.set(name, slice(values, 0, values.size() / size_t(components), components));
    }
    void field(std::string_view name, std::span<const std::uint32_t> values, int components) override {
        out.set(name, slice(values, 0, values.size() / size_t(components), components));
    }
    void children(std::string_view name, std::span<const std::uint32_t> offsets) override {
        out.set(std::string(name) + ".offsets", slice(offsets, 0, offsets.size(), 1));
    }
};

// The fields of one record of a batch, its children's among them.
class OneRecord final : public FieldVisitor {
  public:
    OneRecord(size_t index, size_t records) : index_(index), records_(records) {}
    Json out = Json::object();

    void field(std::string_view name, std::span<const float> values, int components) override {
        add(name, values, components);
    }
    void field(std::string_view name, std::span<const std::uint32_t> values, int components) override {
        add(name, values, components);
    }
    void children(std::string_view name, std::span<const std::uint32_t> offsets) override {
        if (offsets.size() < index_ + 2) return;
        into_ = std::string(name);
        begin_ = offsets[index_];
        end_ = offsets[index_ + 1];
        out.set(into_, Json::object());
    }

  private:
    template <class T>
    void add(std::string_view name, std::span<const T> values, int components) {
        if (!into_.empty()) {
            out.find(into_)->set(name, slice(values, begin_, end_, components));
        } else if (values.size() >= records_ * size_t(components)) {
            Json one = slice(values, index_, index_ + 1, components);
            out.set(name, one.items.empty() ? Json() : one.items.front());
        }
    }
    size_t index_, records_, begin_ = 0, end_ = 0;
    std::string into_;
};

}  // namespace

Tap parse_tap(const std::string& text, const Graph& graph) {
    const size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
        throw UsageError(fmt::format("--tap {}: expected node.port=file, or node.port@x,y=file for a stream", text));
    Tap tap;
    tap.text = text;
    tap.file = text.substr(equals + 1);
    std::string from = text.substr(0, equals);
    const size_t at = from.find('@');
    bool region = false;
    if (at != std::string::npos) {
        int x0, y0, x1, y1, used = 0;
        const std::string numbers = from.substr(at + 1);
        if (std::sscanf(numbers.c_str(), "%d,%d,%d,%d%n", &x0, &y0, &x1, &y1, &used) == 4 && size_t(used) == numbers.size()) {
            tap.x0 = x0, tap.y0 = y0, tap.x1 = x1, tap.y1 = y1;
        } else if (std::sscanf(numbers.c_str(), "%d,%d%n", &x0, &y0, &used) == 2 && size_t(used) == numbers.size()) {
            tap.x0 = x0, tap.y0 = y0, tap.x1 = x0 + 1, tap.y1 = y0 + 1;
        } else {
            throw UsageError(fmt::format("--tap {}: '{}' is no pixel; expected x,y or x0,y0,x1,y1", text, numbers));
        }
        region = true;
        from.resize(at);
    }
    std::string node_name = from, port_name;
    if (const size_t dot = from.rfind('.'); dot != std::string::npos) {
        node_name = from.substr(0, dot);
        port_name = from.substr(dot + 1);
    }
    tap.from.node = graph.find(node_name);
    if (tap.from.node < 0) {
        std::vector<std::string> names;
        for (const GraphNode& node : graph.nodes) names.push_back(node.name);
        throw UsageError(fmt::format("--tap {}: no node '{}'{}", text, node_name, suggestion(node_name, names)));
    }
    const NodeDecl& type = *graph.nodes[size_t(tap.from.node)].type;
    std::vector<std::string> ports;
    for (const PortDecl& port : type.outputs) ports.push_back(port.name);
    if (port_name.empty() && ports.size() == 1) port_name = ports.front();
    tap.from.port = type.find_output(port_name);
    if (tap.from.port < 0)
        throw UsageError(fmt::format("--tap {}: '{}' has no output '{}'{}", text, node_name, port_name, suggestion(port_name, ports)));
    const bool stream = type.outputs[size_t(tap.from.port)].stream;
    if (stream && !region)
        throw UsageError(fmt::format("--tap {}: '{}.{}' is a stream; name a pixel, as in {}.{}@120,60=records.json", text,
                                     node_name, port_name, node_name, port_name));
    if (!stream && region)
        throw UsageError(fmt::format("--tap {}: '{}.{}' is a value and is written whole; leave out '@...'", text, node_name, port_name));
    return tap;
}

void write_tap(const Tap& tap, const TypeInfo& type, const void* value, Context& ctx) {
    if (const Saver saver = saver_of(type.name)) return saver(value, tap.file, ctx);
    if (!type.describe) throw Error(fmt::format("--tap {}: {} has nothing to write", tap.text, type.name));
    WholeValue fields;
    type.describe(value, fields);
    write_file(tap.file, fields.out.dump(false) + "\n");
}

void StreamTap::take(const TypeInfo& type, const void* object, const Batch& batch, size_t serial) {
    if (!type.describe) throw Error(fmt::format("--tap {}: {} has nothing to write", tap_.text, type.name));
    for (size_t i = 0; i < batch.size(); ++i) {
        const int x = int(batch.pixels[i]) % width_, y = int(batch.pixels[i]) / width_;
        if (x < tap_.x0 || x >= tap_.x1 || y < tap_.y0 || y >= tap_.y1) continue;
        OneRecord record(i, batch.size());
        type.describe(object, record);
        const std::lock_guard lock(mutex_);
        records_.push_back({batch.pixels[i], serial, i, std::move(record.out)});
    }
}

void StreamTap::write() {
    std::sort(records_.begin(), records_.end(), [](const Record& a, const Record& b) {
        return std::tie(a.pixel, a.serial, a.index) < std::tie(b.pixel, b.serial, b.index);
    });
    std::string text = fmt::format("{{\"tap\": {}, \"records\": [", Json(tap_.text.substr(0, tap_.text.find('='))).dump());
    for (size_t i = 0; i < records_.size(); ++i) {
        Json one = Json::object();
        one.set("x", int(records_[i].pixel) % width_);
        one.set("y", int(records_[i].pixel) / width_);
        for (JsonMember& member : records_[i].fields.members) one.set(member.key, std::move(member.value));
        text += (i ? ",\n" : "\n") + one.dump();
    }
    write_file(tap_.file, text + "\n]}\n");
}

}  // namespace weft
