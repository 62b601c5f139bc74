#include "runtime/shard.h"

#include <fmt/format.h>
#include <xxhash.h>

#include "graph/json.h"
#include "runtime/isa.h"
#include "runtime/keys.h"

namespace weft {
namespace {

// The outputs of a divided task; of a segment those of its sinks.
std::string keys_text(const Plan& plan, const Keys& keys) {
    std::string text;
    for (const Task& task : plan.tasks) {
        if (!task.divided) continue;
        for (const int node : task.nodes) {
            if (task.segment && plan.instances[size_t(node)]->form() != Form::sink) continue;
            const GraphNode& n = plan.graph->nodes[size_t(node)];
            text += n.name;
            for (const Key& key : keys.outputs[size_t(node)])
                text += fmt::format(" {}", key.text());
            // A sink that writes may have no outputs: then it is told by what comes in.
            for (const auto& links : n.inputs)
                for (const Link& link : links) text += fmt::format(" {}", keys.of(link).text());
            text += "\n";
        }
    }
    return text;
}

}  // namespace

PartHeader shard_header(const Plan& plan, const FilesRead& files, const Shard& shard, int tile) {
    PartHeader header;
    header.shard = shard;
    const std::string text = keys_text(plan, make_keys(plan, files));
    const XXH128_hash_t hash = XXH3_128bits(text.data(), text.size());
    header.key = Key{hash.high64, hash.low64}.text();
    header.tile = tile;
    header.isa = name_of(active_isa());
    header.provenance = make_provenance(plan, files);
    header.graph_name = plan.graph->name;
    // What the flattened graph leaves open: where files are written.
    const Json flat = plan.graph->flattened();
    if (const Json* open = flat.find("parameters"))
        for (const GraphParameter& parameter : plan.graph->parameters)
            if (open->find(parameter.decl.name) && !parameter.value.is(Json::Kind::null))
                header.files[parameter.decl.name] = parameter.value.is(Json::Kind::text)
                                                        ? parameter.value.text
                                                        : parameter.value.dump();
    for (size_t n = 0; n < plan.shapes.size(); ++n)
        for (size_t p = 0; p < plan.shapes[n].size(); ++p)
            if (const Shape& s = plan.shapes[n][p]; s.width > 0 || s.bytes > 0)
                header.shapes[plan.name_of({int(n), int(p)})] = s;
    return header;
}

PlanOptions merge_options(const PartHeader& header) {
    PlanOptions options;
    options.work = Work::merge;
    options.shapes = header.shapes;
    for (const DividedTask& task : header.tasks) options.divide.push_back(task.node);
    return options;
}

void expect_same_files(const Plan& merge, const PartHeader& header) {
    const Json inputs =
        parse_json_or_throw(header.provenance.inputs, "inputs in the parts' header");
    for (const Task& task : merge.tasks) {
        if (task.divided) continue;
        for (const int node : task.nodes)
            for (const std::string& path : files_of(merge, node))
                for (const Json& input : inputs.items) {
                    const Json *name = input.find("path"), *hash = input.find("xxh3");
                    if (name && hash && name->text == path && content_hash(path) != hash->text)
                        throw Error(
                            fmt::format("{}: has changed since the shards ran; '{}' reads it too. "
                                        "Run the shards again, or put the old file back",
                                        path, merge.graph->nodes[size_t(node)].name));
                }
    }
}

}  // namespace weft
