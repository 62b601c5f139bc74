// merge: joins the parts of a run and does the rest of it.
#include <fmt/format.h>

#include "cli/execute.h"
#include "cli/terminal.h"
#include "runtime/isa.h"
#include "runtime/registry.h"
#include "runtime/shard.h"

namespace weft::cli {
int merge(const MergeCommand& options) {
    const Parts parts(options.parts);
    const PartHeader& header = parts.header();
    pin_isa_named(header.isa);

    LoadOptions load;
    load.for_run = true;
    const std::string out = parameter_of_out(header);
    for (const auto& [name, value] : header.files)
        if (name != out) load.overrides.set.push_back(fmt::format("{}={}", name, value));
    load.overrides.set.push_back(fmt::format("{}={}", out, options.out));
    for (const std::string& set : options.set) {
        const std::string name = set.substr(0, set.find('='));
        if (!header.files.count(name) || name == out)
            throw UsageError(fmt::format("--set {}: a merge only takes names of files to write; {}",
                                         set,
                                         header.files.size() > 1 ? "see 'parameters' in the graph"
                                                                 : "here OUT is the only one"));
        load.overrides.set.push_back(set);
    }
    const Loaded loaded =
        load_graph_text(header.provenance.graph, options.parts.front(), Registry::instance(), load);
    print_findings(loaded.findings);
    if (!loaded.ok()) return failed;

    const std::unique_ptr<Executor> executor = executor_named("tbb", options.threads);
    PlanOptions plan_options = merge_options(header);
    plan_options.threads = executor->threads();
    if (!options.memory.empty()) plan_options.memory_limit = parse_bytes(options.memory);
    const Plan plan = make_plan(loaded.graph, plan_options);
    expect_same_files(plan, header);

    RunOptions run_options;
    run_options.tile = header.tile;
    run_options.provenance = header.provenance;
    run_options.parts = &parts;
    RunResult result;
    return execute(plan, *executor, run_options, {options.quiet, options.report, options.trace},
                   result);
}

}  // namespace weft::cli
