#include "runtime/keys.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>

#include "runtime/isa.h"
#include "runtime/values.h"

namespace weft {
namespace {

Key hash(const std::string& text) {
    const XXH128_hash_t value = XXH3_128bits(text.data(), text.size());
    return {value.high64, value.low64};
}

// 2 and 2.0 are one number.
Json plain(const Json& value) {
    if (value.is(Json::Kind::number)) {
        constexpr double exact = 9007199254740992.0;  // 2^53: whole numbers up to here are doubles
        return value.is_unsigned || std::abs(value.number) > exact ? value : Json(value.number);
    }
    Json out = value;
    for (Json& item : out.items) item = plain(item);
    for (JsonMember& member : out.members) member.value = plain(member.value);
    return out;
}

class Maker {
  public:
    Maker(const Plan& plan, const FilesRead& files)
        : plan_(plan), graph_(*plan.graph), files_(files) {}

    Keys make() {
        keys_.outputs.resize(graph_.nodes.size());
        std::vector<std::string> ends;
        for (size_t n = 0; n < graph_.nodes.size(); ++n) {
            const NodeDecl& type = *graph_.nodes[n].type;
            const std::string text = text_of(int(n));
            for (const PortDecl& port : type.outputs)
                keys_.outputs[n].push_back(hash(fmt::format("{} {}", port.name, text)));
            if (type.writes) ends.push_back(text);
        }
        for (const auto& [name, link] : graph_.outputs) ends.push_back(keys_.of(link).text());
        std::sort(ends.begin(), ends.end());  // the order of nodes in a document is of no weight
        keys_.run = hash(fmt::format("run {}", fmt::join(ends, "\n")));
        return std::move(keys_);
    }

  private:
    Json parameters(int node) const {
        const GraphNode& n = graph_.nodes[size_t(node)];
        Json set = Json::object();
        for (size_t p = 0; p < n.params.size(); ++p) {
            const ParamDecl& param = n.type->params[p];
            if (param.use == FileUse::write) continue;
            const auto file = files_.find(n.params[p].text);
            if (param.use == FileUse::read && file != files_.end() && !file->second.hash.empty())
                set.set(param.name, content(file->second));
            else
                set.set(param.name, plain(n.params[p]));
        }
        return set;
    }

    static Json content(const FileContent& file) {
        return Json::list({Json("content"), Json(file.size), Json(file.hash)});
    }

    Json further_files(int node) const {
        Json all = Json::list();
        if (const auto& instance = plan_.instances[size_t(node)])
            for (const std::string& path : instance->reads())
                if (const auto file = files_.find(path); file != files_.end())
                    all.items.push_back(content(file->second));
        return all;
    }

    Json inputs(int node) const {
        const GraphNode& n = graph_.nodes[size_t(node)];
        Json in = Json::object();
        for (size_t i = 0; i < n.inputs.size(); ++i) {
            const PortDecl& port = n.type->inputs[i];
            Json& links = in.set(port.name, Json::list());
            for (const Link& link : n.inputs[i]) {
                links.items.push_back(Json(keys_.of(link).text()));
                if (port.need == Need::variadic)
                    links.items.push_back(
                        Json(name_seen_from(n.name, graph_.nodes[size_t(link.node)].name)));
            }
        }
        return in;
    }

    // Rounding may differ between a node's own kernel and a fusion's.
    std::string fusion_of(int node) const {
        for (const Task& task : plan_.tasks)
            for (const StagePlan& stage : task.stages)
                if (stage.fusion && std::find(stage.nodes.begin(), stage.nodes.end(), node) != stage.nodes.end())
                    return stage.fusion->decl().name;
        return "";
    }

    std::string text_of(int node) const {
        const NodeDecl& type = *graph_.nodes[size_t(node)].type;
        return Json::list({Json(type.type), Json(type.version), Json(name_of(active_isa())),
                           parameters(node), further_files(node), inputs(node), Json(fusion_of(node))})
            .dump();
    }

    const Plan& plan_;
    const Graph& graph_;
    const FilesRead& files_;
    Keys keys_;
};

}  // namespace

std::string Key::text() const {
    return fmt::format("{:016x}{:016x}", high, low);
}

Keys make_keys(const Plan& plan, const FilesRead& files) {
    return Maker(plan, files).make();
}

}  // namespace weft
