// Order, cycles, and nodes that are there for nothing.
#include <algorithm>
#include <functional>
#include <queue>

#include "graph/table.h"

namespace weft::loading {
namespace {

// Visits links into `node` whose other end counts.
template <class Visit>
void each_link(const NodeTable& table, int node, Visit&& visit) {
    for (const auto& port : table.nodes[size_t(node)].inputs)
        for (const FlatLink& link : port)
            if (!table.nodes[size_t(link.link.node)].removed) visit(link);
}

// Tells every circle among the nodes that have no place in an order, each node in one circle at
// most.
class CycleFinder {
  public:
    CycleFinder(const NodeTable& table, const std::vector<bool>& placed, Findings& findings)
        : table_(table),
          findings_(findings),
          state_(table.nodes.size(), State::fresh),
          told_(table.nodes.size()) {
        for (size_t i = 0; i < placed.size(); ++i)
            if (placed[i] || table.nodes[i].removed) state_[i] = State::done;
        for (size_t i = 0; i < placed.size(); ++i)
            if (state_[i] == State::fresh) search(int(i));
    }

  private:
    enum class State { fresh, open, done };
    struct Step {
        int node;
        std::vector<FlatLink> links;
        size_t next = 0;
    };

    void enter(int node) {
        state_[size_t(node)] = State::open;
        Step step{node, {}};
        each_link(table_, node, [&](const FlatLink& link) { step.links.push_back(link); });
        path_.push_back(std::move(step));
    }
    void search(int start) {
        enter(start);
        while (!path_.empty()) {
            Step& step = path_.back();
            if (step.next == step.links.size()) {
                state_[size_t(step.node)] = State::done;
                path_.pop_back();
                continue;
            }
            const int source = step.links[step.next++].link.node;
            if (state_[size_t(source)] == State::fresh)
                enter(source);
            else if (state_[size_t(source)] == State::open)
                tell(source);
        }
    }
    // The path from `source` on reads: source <- ... <- its reader, and the last reads from source.
    void tell(int source) {
        size_t from = path_.size();
        while (path_[--from].node != source) {
        }
        for (size_t i = from; i < path_.size(); ++i)
            if (told_[size_t(path_[i].node)]) return;
        // Told along the data, from the node that stands first in the document.
        std::vector<int> circle;
        std::vector<Place> links;  // into circle[i]
        for (size_t i = path_.size(); i-- > from;) {
            circle.push_back(path_[i].node);
            links.push_back(path_[i].links[path_[i].next - 1].place);
            told_[size_t(path_[i].node)] = true;
        }
        const auto first = std::min_element(circle.begin(), circle.end()) - circle.begin();
        std::rotate(circle.begin(), circle.begin() + first, circle.end());
        std::rotate(links.begin(), links.begin() + first, links.end());
        std::string text;
        for (const int node : circle) text += table_.nodes[size_t(node)].name + " -> ";
        findings_.error(links[0], "nodes feed each other in a circle: {}{}", text,
                        table_.nodes[size_t(circle[0])].name);
    }

    const NodeTable& table_;
    Findings& findings_;
    std::vector<State> state_;
    std::vector<bool> told_;
    std::vector<Step> path_;
};

bool writes(const Entity& entity) {
    if (entity.bypass) return false;
    if (entity.decl) return entity.decl->writes;
    return entity.inner && std::any_of(entity.inner->entities.begin(), entity.inner->entities.end(),
                                       [](const Entity& e) { return writes(e); });
}

void find_unread(const Scope& scope, Findings& findings) {
    for (const Entity& entity : scope.entities) {
        if (entity.broken || entity.bypass || scope.removed) continue;
        if (!entity.read && entity.input)
            findings.warning(entity.place, "nothing reads the graph's input '{}'", entity.name);
        else if (!entity.read && !writes(entity))
            findings.warning(entity.place,
                             "nothing reads '{}' and it writes nothing: it will not be run",
                             entity.name);
        if (entity.inner) find_unread(*entity.inner, findings);
    }
}

}  // namespace

std::vector<int> order(const NodeTable& table, Findings& findings) {
    const size_t count = table.nodes.size();
    std::vector<int> waiting(count);
    std::vector<std::vector<int>> readers(count);
    size_t total = 0;
    for (size_t i = 0; i < count; ++i) {
        if (table.nodes[i].removed) continue;
        ++total;
        each_link(table, int(i), [&](const FlatLink& link) {
            readers[size_t(link.link.node)].push_back(int(i));
            ++waiting[i];
        });
    }
    // Of those that can go next, the one that stands first in the document.
    std::priority_queue<int, std::vector<int>, std::greater<>> ready;
    for (size_t i = 0; i < count; ++i)
        if (!table.nodes[i].removed && waiting[i] == 0) ready.push(int(i));
    std::vector<int> out;
    std::vector<bool> placed(count);
    while (!ready.empty()) {
        const int node = ready.top();
        ready.pop();
        out.push_back(node);
        placed[size_t(node)] = true;
        for (const int reader : readers[size_t(node)])
            if (--waiting[size_t(reader)] == 0) ready.push(reader);
    }
    if (out.size() == total) return out;
    CycleFinder(table, placed, findings);
    return {};
}

void find_unread(const NodeTable& table, Findings& findings) {
    find_unread(*table.top, findings);
}

}  // namespace weft::loading
