// Streams meet only streams of the same source, holding the same records; and no stream waits for
// what comes out of its own end.
#include <algorithm>
#include <map>
#include <set>

#include "graph/table.h"

namespace weft::loading {
namespace {

// What a stream output carries. Selection 0 is all of the source's records.
struct Stream {
    int source = -1, selection = 0;
};

struct Selection {
    int parent = -1;
    Link by;
};

// The stream links into one port.
struct Joined {
    const PortDecl* port;
    const FlatLink* link;
    Stream stream;
    bool per_batch;
};

class StreamChecker {
  public:
    StreamChecker(const NodeTable& table, Findings& findings) : table_(table), findings_(findings) {
        streams_.resize(table.nodes.size());
        member_.assign(table.nodes.size(), -1);
        waits_.resize(table.nodes.size());
    }
    void run(const std::vector<int>& order) {
        for (const int node : order) {
            join(node);
            wait(node);
        }
        circles();
    }

  private:
    const FlatNode& at(int node) const { return table_.nodes[size_t(node)]; }
    std::string output_name(Link link) const {
        const FlatNode& node = at(link.node);
        return node.stand_in ? node.name
                             : node.name + "." + node.type->outputs[size_t(link.port)].name;
    }
    std::string records(Stream stream) const {
        if (stream.selection == 0)
            return fmt::format("all records of '{}'", at(stream.source).name);
        return fmt::format("the records that '{}' selects",
                           output_name(selections_[size_t(stream.selection)].by));
    }

    void join(int index) {
        const FlatNode& node = at(index);
        auto& outputs = streams_[size_t(index)];
        outputs.resize(node.type->outputs.size());
        const auto is_stream = [](const PortDecl& port) { return port.stream; };
        const bool gives =
            std::any_of(node.type->outputs.begin(), node.type->outputs.end(), is_stream);
        const bool takes =
            std::any_of(node.type->inputs.begin(), node.type->inputs.end(), is_stream);
        Stream base;
        if (takes) {
            base = base_of(node);
            if (base.source < 0) return;  // told, or it is not connected
        } else if (gives) {
            base.source = index;
        } else {
            return;
        }
        member_[size_t(index)] = base.source;
        for (size_t i = 0; i < outputs.size(); ++i) {
            const PortDecl& port = node.type->outputs[i];
            if (!port.stream) continue;
            outputs[i] = base;
            if (!port.selects) continue;
            outputs[i].selection = int(selections_.size());
            selections_.push_back({base.selection, {index, int(i)}});
        }
    }

    Stream base_of(const FlatNode& node) {
        std::vector<Joined> joined;
        bool all_optional = true;
        for (size_t i = 0; i < node.inputs.size(); ++i) {
            const PortDecl& port = node.type->inputs[i];
            if (!port.stream) continue;
            all_optional = all_optional && port.need == Need::optional;
            for (const FlatLink& link : node.inputs[i]) {
                const auto& streams = streams_[size_t(link.link.node)];
                const Stream stream = streams[size_t(link.link.port)];
                const PortDecl& output = at(link.link.node).type->outputs[size_t(link.link.port)];
                if (stream.source >= 0)
                    joined.push_back({&port, &link, stream, port.per_batch || output.per_batch});
            }
        }
        if (joined.empty()) {
            const bool connected = std::any_of(node.inputs.begin(), node.inputs.end(),
                                               [](const auto& links) { return !links.empty(); });
            if (all_optional && !connected)
                findings_.error(node.place,
                                "'{}' is a stage of a stream, but none of its streams is connected",
                                node.entity->name);
            return {};
        }
        const auto whole = [](const Joined& j) { return !j.per_batch && !j.port->branch; };
        const auto found = std::find_if(joined.begin(), joined.end(), whole);
        const Joined& base = found == joined.end() ? joined.front() : *found;
        for (const Joined& other : joined)
            if (&other != &base) compare(base, other);
        return base.stream;
    }

    void compare(const Joined& base, const Joined& other) {
        const std::string name = output_name(other.link->link);
        if (other.stream.source != base.stream.source) {
            // Whoever uses this graph as a node will see to what its inputs have in common.
            if (at(other.stream.source).stand_in || at(base.stream.source).stand_in) return;
            findings_.error(other.link->place,
                            "'{}' is a stream of '{}', but '{}' is one of '{}'; a node joins "
                            "streams of one source only",
                            name, at(other.stream.source).name, base.port->name,
                            at(base.stream.source).name);
            return;
        }
        if (other.per_batch || base.per_batch) return;
        if (other.port->branch) {
            if (other.stream.selection == base.stream.selection)
                findings_.error(
                    other.link->place,
                    "'{}' holds the same records as '{}' ({}); '{}' takes a selection of them",
                    name, base.port->name, records(base.stream), other.port->name);
            else if (selections_[size_t(other.stream.selection)].parent != base.stream.selection)
                findings_.error(other.link->place,
                                "'{}' holds {}, which were not selected from '{}' ({}); '{}' takes "
                                "a branch of it",
                                name, records(other.stream), base.port->name, records(base.stream),
                                other.port->name);
        } else if (other.stream.selection != base.stream.selection) {
            findings_.error(other.link->place,
                            "'{}' holds {}, but '{}' holds {}; join streams of the same records, "
                            "or merge them by a "
                            "node with a branch",
                            name, records(other.stream), base.port->name, records(base.stream));
        }
    }

    // waits_: the sources whose streams must have ended before a value is there.
    void wait(int index) {
        const FlatNode& node = at(index);
        auto& own = waits_[size_t(index)];
        for (size_t i = 0; i < node.inputs.size(); ++i) {
            if (node.type->inputs[i].stream) continue;
            for (const FlatLink& link : node.inputs[i]) {
                std::set<int> before;
                const int source = member_[size_t(link.link.node)];
                if (source >= 0)
                    before.insert(source);
                else
                    before = waits_[size_t(link.link.node)];
                own.insert(before.begin(), before.end());
                if (const int stream = member_[size_t(index)]; stream >= 0)
                    for (const int other : before) edges_.push_back({stream, other, index, link});
            }
        }
    }

    bool reaches(int from, int to) const {
        std::set<int> seen{from};
        std::vector<int> open{from};
        while (!open.empty()) {
            const int now = open.back();
            open.pop_back();
            if (now == to) return true;
            const auto next = before_.find(now);
            if (next == before_.end()) continue;
            for (const int other : next->second)
                if (seen.insert(other).second) open.push_back(other);
        }
        return false;
    }

    // A stream is run as one: it cannot wait for a stream that waits for it.
    void circles() {
        for (const Edge& edge : edges_) {
            std::set<int>& before = before_[edge.stream];
            if (before.count(edge.waits_for)) continue;
            if (!reaches(edge.waits_for, edge.stream)) {
                before.insert(edge.waits_for);
                continue;
            }
            findings_.error(edge.link.place,
                            "'{}' is part of the stream of '{}' and reads '{}', which is there "
                            "only when that stream "
                            "has ended; give it a stream of its own, from a second source node",
                            at(edge.reader).name, at(edge.stream).name,
                            output_name(edge.link.link));
        }
    }

    struct Edge {
        int stream, waits_for, reader;
        FlatLink link;
    };

    const NodeTable& table_;
    Findings& findings_;
    std::vector<Selection> selections_{{}};
    std::vector<std::vector<Stream>> streams_;  // by node and output
    std::vector<int> member_;                   // the source whose stream a node is part of
    std::vector<std::set<int>> waits_;
    std::vector<Edge> edges_;
    std::map<int, std::set<int>> before_;  // streams that must have ended before one starts
};

}  // namespace

void check_streams(const NodeTable& table, const std::vector<int>& order, Findings& findings) {
    StreamChecker(table, findings).run(order);
}

}  // namespace weft::loading
