// check, plan, dot: what a graph is, without running it.
#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "cli/commands.h"
#include "cli/terminal.h"
#include "runtime/keys.h"
#include "runtime/plan.h"
#include "runtime/registry.h"

namespace weft::cli {
namespace {

Json finding_json(const Diagnostic& finding) {
    const LineColumn at = line_column(finding.place);
    Json one = Json::object();
    one.set("level", finding.level == Diagnostic::Level::error ? "error" : "warning");
    one.set("file", finding.place.source ? finding.place.source->name : std::string());
    one.set("line", at.line);
    one.set("column", at.column);
    one.set("message", finding.message);
    return one;
}

Loaded load(const std::string& graph, const Overrides& overrides) {
    LoadOptions options;
    options.overrides = overrides;
    return load_graph(graph, Registry::instance(), options);
}

}  // namespace

int check(const CheckCommand& options) {
    bool ok = true;
    Json all = Json::list();
    for (const std::string& graph : options.graphs) {
        const Loaded loaded = load(graph, options.overrides);
        ok = ok && loaded.ok();
        if (options.json) {
            for (const Diagnostic& finding : loaded.findings) all.items.push_back(finding_json(finding));
            continue;
        }
        print_findings(loaded.findings);
        if (loaded.ok()) print(fmt::format("{}: ok, {} nodes\n", graph, loaded.graph.nodes.size()));
    }
    if (options.json) print(all.dump(true) + "\n");
    return ok ? done : misused;
}

int plan(const PlanCommand& options) {
    const Loaded loaded = load(options.graph, options.overrides);
    print_findings(loaded.findings);
    if (!loaded.ok()) return misused;
    PlanOptions plan_options;
    plan_options.taps = options.taps;
    plan_options.fuse = !options.no_fuse;
    plan_options.threads = options.threads > 0 ? options.threads : int(std::max(1u, std::thread::hardware_concurrency()));
    if (!options.memory.empty()) plan_options.memory_limit = parse_bytes(options.memory);
    const Plan made = make_plan(loaded.graph, plan_options);
    const Keys keys = make_keys(made, files_read(made));
    print(options.json ? to_json(made, &keys).dump(true) + "\n" : to_text(made, &keys));
    return done;
}

int dot(const GraphOptions& options, bool mermaid) {
    const Loaded loaded = load(options.graph, options.overrides);
    print_findings(loaded.findings);
    if (!loaded.ok()) return misused;
    print(mermaid ? to_mermaid(loaded.graph) : to_dot(loaded.graph));
    return done;
}

}  // namespace weft::cli
