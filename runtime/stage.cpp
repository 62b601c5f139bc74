#include "runtime/stage.h"

#include <algorithm>

#include "runtime/registry.h"

namespace weft {
namespace {

bool same(Link a, Link b) {
    return a.node == b.node && a.port == b.port;
}

// Looks for a fusion's parts among a segment's nodes.
class Match {
  public:
    Match(const Graph& graph, const std::vector<int>& nodes, const FusionDecl& fusion, int first)
        : graph_(graph), nodes_(nodes), fusion_(fusion), members_(fusion.parts.size(), -1) {
        members_[0] = first;
    }

    bool find(const std::function<bool(Link)>& tapped) {
        return find_members() && all_inputs_known() && all_outputs_known(tapped);
    }
    const std::vector<int>& members() const { return members_; }

    std::vector<StagePlan::Port> inputs() const {
        std::vector<StagePlan::Port> ports;
        for (const FusionDecl::Port& port : fusion_.inputs)
            ports.push_back({port.name, members_[port.ends[0].part], input_of(port.ends[0])});
        return ports;
    }
    std::vector<StagePlan::Port> outputs() const {
        std::vector<StagePlan::Port> ports;
        for (const FusionDecl::Port& port : fusion_.outputs)
            ports.push_back({port.name, members_[port.ends[0].part], output_of(port.ends[0]).port});
        return ports;
    }

  private:
    const GraphNode& member(size_t part) const { return graph_.nodes[size_t(members_[part])]; }
    int input_of(const FusionDecl::End& end) const {
        return member(end.part).type->find_input(end.port);
    }
    Link output_of(const FusionDecl::End& end) const {
        return {members_[end.part], member(end.part).type->find_output(end.port)};
    }
    const std::vector<Link>& links_of(const FusionDecl::End& end) const {
        return member(end.part).inputs[size_t(input_of(end))];
    }
    bool is_member(int node) const {
        return std::find(members_.begin(), members_.end(), node) != members_.end();
    }

    bool find_members() {
        for (size_t found = 1; found < members_.size();) {
            const size_t before = found;
            for (const auto& [from, to] : fusion_.inner) {
                if (members_[from.part] < 0 || members_[to.part] >= 0) continue;
                for (const int n : nodes_) {
                    const NodeDecl& type = *graph_.nodes[size_t(n)].type;
                    const int port =
                        type.type == fusion_.parts[to.part] ? type.find_input(to.port) : -1;
                    if (port < 0) continue;
                    const auto& links = graph_.nodes[size_t(n)].inputs[size_t(port)];
                    if (links.size() == 1 && same(links[0], output_of(from))) {
                        members_[to.part] = n;
                        ++found;
                        break;
                    }
                }
            }
            if (found == before) return false;
        }
        return std::all_of(fusion_.inner.begin(), fusion_.inner.end(), [&](const auto& link) {
            const auto& links = links_of(link.second);
            return links.size() == 1 && same(links[0], output_of(link.first));
        });
    }

    // Every input of a part is an inner one, or one of the fusion's, and what those read is there
    // before the first part.
    bool all_inputs_known() const {
        const int first = *std::min_element(members_.begin(), members_.end());
        for (const FusionDecl::Port& port : fusion_.inputs) {
            const std::vector<Link>& links = links_of(port.ends[0]);
            for (const FusionDecl::End& end : port.ends)
                if (!std::equal(links.begin(), links.end(), links_of(end).begin(),
                                links_of(end).end(), same))
                    return false;
            for (const Link& link : links)
                if (link.node >= first) return false;
        }
        for (size_t part = 0; part < members_.size(); ++part)
            for (size_t p = 0; p < member(part).inputs.size(); ++p) {
                const auto is_this = [&](const FusionDecl::End& end) {
                    return end.part == part && end.port == member(part).type->inputs[p].name;
                };
                const bool known =
                    std::any_of(fusion_.inner.begin(), fusion_.inner.end(),
                                [&](const auto& link) { return is_this(link.second); }) ||
                    std::any_of(fusion_.inputs.begin(), fusion_.inputs.end(),
                                [&](const FusionDecl::Port& port) {
                                    return std::any_of(port.ends.begin(), port.ends.end(), is_this);
                                });
                if (!known && !member(part).inputs[p].empty()) return false;
            }
        return true;
    }

    // Nobody outside reads an output that is not one of the fusion's.
    bool all_outputs_known(const std::function<bool(Link)>& tapped) const {
        const auto kept = [&](Link link) {
            return std::any_of(
                fusion_.outputs.begin(), fusion_.outputs.end(),
                [&](const FusionDecl::Port& port) { return same(output_of(port.ends[0]), link); });
        };
        for (const int m : members_)
            for (size_t p = 0; p < graph_.nodes[size_t(m)].type->outputs.size(); ++p) {
                const Link link{m, int(p)};
                if (kept(link)) continue;
                if (tapped(link)) return false;
                for (const int n : nodes_)
                    for (const auto& links : graph_.nodes[size_t(n)].inputs)
                        for (const Link& l : links)
                            if (same(l, link) && !is_member(n)) return false;
            }
        return true;
    }

    const Graph& graph_;
    const std::vector<int>& nodes_;
    const FusionDecl& fusion_;
    std::vector<int> members_;
};

StagePlan single(const Graph& graph, int n) {
    const NodeDecl& type = *graph.nodes[size_t(n)].type;
    StagePlan stage;
    stage.nodes = {n};
    for (size_t p = 0; p < type.inputs.size(); ++p)
        stage.inputs.push_back({type.inputs[p].name, n, int(p)});
    for (size_t p = 0; p < type.outputs.size(); ++p)
        stage.outputs.push_back({type.outputs[p].name, n, int(p)});
    return stage;
}

}  // namespace

std::string StagePlan::name(const Graph& graph) const {
    const auto name_of = [&](int n) -> const std::string& { return graph.nodes[size_t(n)].name; };
    std::string name = name_of(nodes[0]);
    const size_t scope = name.rfind('/') + 1;  // npos + 1 is 0
    for (size_t i = 1; i < nodes.size(); ++i) {
        const std::string& next = name_of(nodes[i]);
        name += "+" + (next.compare(0, scope, name, 0, scope) == 0 ? next.substr(scope) : next);
    }
    return name;
}

const std::string& StagePlan::type(const Graph& graph) const {
    return fusion ? fusion->decl().name : graph.nodes[size_t(nodes[0])].type->type;
}

std::vector<StagePlan> stages_of(const Graph& graph, const std::vector<int>& nodes, bool fuse,
                                 const std::function<bool(Link)>& tapped) {
    std::vector<StagePlan> stages;
    std::vector<int> taken;
    for (const int n : nodes) {
        if (std::find(taken.begin(), taken.end(), n) != taken.end()) continue;
        StagePlan stage = single(graph, n);
        if (fuse)
            for (const auto& fusion : Registry::instance().fusions()) {
                if (fusion->decl().parts[0] != graph.nodes[size_t(n)].type->type) continue;
                Match match(graph, nodes, fusion->decl(), n);
                if (!match.find(tapped)) continue;
                std::vector<const GraphNode*> parts;
                for (const int m : match.members()) parts.push_back(&graph.nodes[size_t(m)]);
                std::unique_ptr<NodeInstance> instance = fusion->make(parts);
                if (!instance) continue;
                stage = {match.members(), fusion.get(), std::move(instance), match.inputs(),
                         match.outputs()};
                taken.insert(taken.end(), stage.nodes.begin(), stage.nodes.end());
                break;
            }
        stages.push_back(std::move(stage));
    }
    return stages;
}

namespace detail {

FusionDecl::End end_named(const FusionDecl& decl, const std::string& name) {
    const size_t dot = name.find('.');
    const std::string type = name.substr(0, dot);
    const auto part = std::find(decl.parts.begin(), decl.parts.end(), type);
    if (dot == std::string::npos || part == decl.parts.end())
        throw Error("fusion '" + decl.name + "': '" + name + "' is not a part's port or parameter");
    return {size_t(part - decl.parts.begin()), name.substr(dot + 1)};
}

const Json& parameter(const GraphNode& node, const std::string& name) {
    for (size_t p = 0; p < node.type->params.size(); ++p)
        if (node.type->params[p].name == name) return node.params[p];
    throw Error("'" + node.type->type + "' has no parameter '" + name + "'");
}

size_t choice_of(const GraphNode& node, const std::string& name, const Json& value) {
    const auto& choices = node.type->find_param(name)->choices;
    return size_t(std::find(choices.begin(), choices.end(), value.text) - choices.begin());
}

}  // namespace detail
}  // namespace weft
