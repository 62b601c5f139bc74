#include "runtime/part_header.h"

#include <fmt/format.h>

#include "runtime/isa.h"

namespace weft {
namespace {

class Reader {
  public:
    explicit Reader(const std::string& path) : path_(path) {}

    const Json& member(const Json& object, const char* name, Json::Kind kind) const {
        const Json* found = object.find(name);
        if (!found || !found->is(kind)) wrong(name);
        return *found;
    }
    const std::string& text(const Json& object, const char* name) const {
        return member(object, name, Json::Kind::text).text;
    }
    std::int64_t whole(const Json& object, const char* name, std::int64_t low,
                       std::int64_t high) const {
        const Json& value = member(object, name, Json::Kind::number);
        if (!value.is_integer || value.is_unsigned || value.integer < low || value.integer > high)
            wrong(name);
        return value.integer;
    }
    [[noreturn]] void wrong(const std::string& name) const {
        throw Error(
            fmt::format("{}: is damaged: '{}' in its header makes no sense; make this part again",
                        path_, name));
    }

  private:
    const std::string& path_;
};

constexpr std::int64_t most = std::int64_t{1} << 52;

Shape shape_of(const Json& list, const Reader& read) {
    if (list.items.size() != 5) read.wrong("shapes");
    for (const Json& item : list.items)
        if (!item.is(Json::Kind::number) || !(item.number >= 0 && item.number < double(most)))
            read.wrong("shapes");
    const auto number = [&](size_t i) { return std::int64_t(list.items[i].number); };
    return {number(0), number(1), number(2), number(3), list.items[4].number};
}

DividedTask task_of(const Json& one, const Reader& read) {
    DividedTask task;
    task.node = read.text(one, "node");
    task.name = read.text(one, "name");
    task.extent = {int(read.whole(one, "width", 0, 1 << 30)),
                   int(read.whole(one, "height", 0, 1 << 30))};
    task.items = std::uint64_t(read.whole(one, "items", 0, most));
    for (const Json& sink : read.member(one, "sinks", Json::Kind::list).items) {
        if (!sink.is(Json::Kind::text)) read.wrong("sinks");
        task.sinks.push_back(sink.text);
    }
    return task;
}

}  // namespace

bool DividedTask::operator==(const DividedTask& other) const {
    return node == other.node && name == other.name && extent.width == other.extent.width &&
           extent.height == other.extent.height && items == other.items && sinks == other.sinks;
}

Json to_json(const PartHeader& header) {
    Json out = Json::object();
    out.set("weft", header.provenance.version);
    out.set("shard", header.shard.index);
    out.set("shards", header.shard.count);
    out.set("key", header.key);
    out.set("tile", header.tile);
    out.set("isa", header.isa);
    out.set("name", header.graph_name);
    out.set("graph", header.provenance.graph);
    out.set("inputs", header.provenance.inputs);
    Json& files = out.set("files", Json::object());
    for (const auto& [name, value] : header.files) files.set(name, value);
    Json& shapes = out.set("shapes", Json::object());
    for (const auto& [name, s] : header.shapes)
        shapes.set(name, Json::list({Json(s.width), Json(s.height), Json(s.channels),
                                     Json(s.records), Json(s.bytes)}));
    Json& tasks = out.set("tasks", Json::list());
    for (const DividedTask& task : header.tasks) {
        Json one = Json::object();
        one.set("node", task.node);
        one.set("name", task.name);
        one.set("width", task.extent.width);
        one.set("height", task.extent.height);
        one.set("items", task.items);
        Json& sinks = one.set("sinks", Json::list());
        for (const std::string& sink : task.sinks) sinks.items.push_back(Json(sink));
        tasks.items.push_back(std::move(one));
    }
    return out;
}

PartHeader part_header(std::string_view text, const std::string& path) {
    const Json in = parse_json_or_throw(text, path + ": header");
    const Reader read(path);
    if (!in.is(Json::Kind::object)) read.wrong("header");
    PartHeader header;
    header.provenance.version = read.text(in, "weft");
    header.shard.count = int(read.whole(in, "shards", 1, 1 << 20));
    header.shard.index = int(read.whole(in, "shard", 1, header.shard.count));
    header.key = read.text(in, "key");
    header.tile = int(read.whole(in, "tile", 1, 65536));
    header.isa = read.text(in, "isa");
    if (!isa_named(header.isa)) read.wrong("isa");
    header.graph_name = read.text(in, "name");
    header.provenance.graph = read.text(in, "graph");
    header.provenance.inputs = read.text(in, "inputs");
    for (const JsonMember& member : read.member(in, "files", Json::Kind::object).members) {
        if (!member.value.is(Json::Kind::text)) read.wrong("files");
        header.files[member.key] = member.value.text;
    }
    for (const JsonMember& member : read.member(in, "shapes", Json::Kind::object).members)
        header.shapes[member.key] = shape_of(member.value, read);
    for (const Json& one : read.member(in, "tasks", Json::Kind::list).items)
        header.tasks.push_back(task_of(one, read));
    return header;
}

}  // namespace weft
