// run: checks, plans and runs a graph.
#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/terminal.h"
#include "runtime/atomic_file.h"
#include "runtime/isa.h"
#include "runtime/provenance.h"
#include "runtime/registry.h"
#include "runtime/run.h"

namespace weft::cli {
namespace {

std::unique_ptr<Executor> executor_named(const std::string& name, int threads) {
    if (name == "threads") return make_thread_executor(threads);
    if (name == "serial") return make_serial_executor();
    return make_tbb_executor(threads);
}

void print_errors(const RunResult& result) {
    for (const NodeError& error : result.errors) {
        std::string message = fmt::format("'{}': {}", error.node, error.message);
        if (!error.skipped.empty())
            message += fmt::format("; skipped because of it: {}", fmt::join(error.skipped, ", "));
        print_findings({{Diagnostic::Level::error, message, error.place}});
    }
}

}  // namespace

int run(const RunCommand& options) {
    LoadOptions load;
    load.overrides = options.overrides;
    load.for_run = true;
    const Loaded loaded = load_graph(options.graph, Registry::instance(), load);
    print_findings(loaded.findings);
    if (!loaded.ok()) return misused;

    if (!options.isa.empty()) {
        const auto isa = isa_named(options.isa);
        if (!isa) throw UsageError(fmt::format("--isa {}: expected v2, v3 or v4", options.isa));
        pin_isa(*isa);
    }
    const std::unique_ptr<Executor> executor = executor_named(options.executor, options.threads);
    PlanOptions plan_options;
    plan_options.taps = options.taps;
    plan_options.threads = executor->threads();
    if (!options.memory.empty()) plan_options.memory_limit = parse_bytes(options.memory);
    const Plan plan = make_plan(loaded.graph, plan_options);
    if (plan.tasks.empty()) {
        complain(fmt::format("{}: nothing to do: no node of this graph writes anything; add a 'write-image' or use --tap",
                             options.graph));
        return misused;
    }

    RunOptions run_options;
    run_options.tile = options.tile;
    run_options.provenance = make_provenance(loaded.graph);
    run_options.stop = &interruption();
    catch_interruptions();

    Monitor monitor;
    monitor.tracing = !options.trace.empty();
    RunResult result;
    {
        monitor.begin(plan);
        ProgressDisplay display(monitor, options.quiet);
        monitor.warning = [&](const std::string& node, const std::string& message) {
            display.note(fmt::format("warning: '{}': {}", node, message));
        };
        result = run_plan(plan, *executor, monitor, run_options);
    }
    print_errors(result);
    if (!options.report.empty()) write_file(options.report, report_json(result, plan, executor->threads()));
    if (!options.trace.empty()) write_file(options.trace, monitor.trace());
    if (result.cancelled) {
        complain("interrupted; no partial file was left");
        return interrupted;
    }
    return result.errors.empty() ? done : failed;
}

}  // namespace weft::cli
