// The program `weft`: its command line.
#include <malloc.h>

#include <CLI/CLI.hpp>
#include <cstdlib>

#include "cli/commands.h"
#include "cli/terminal.h"
#include "runtime/plan.h"
#include "runtime/provenance.h"
#include "runtime/registry.h"

namespace {

using namespace weft;

void add_overrides(CLI::App& command, Overrides& overrides) {
    command.add_option("--set", overrides.set, "a graph parameter (k=v) or a node's (node.param=v)")->allow_extra_args(false);
    command.add_option("--swap", overrides.swap, "another type for a node: node=type[,param=value...]")->allow_extra_args(false);
    command.add_option("--bypass", overrides.bypass, "pass a node's input through")->allow_extra_args(false);
}

void add_graph_options(CLI::App& command, cli::GraphOptions& options) {
    command.add_option("graph", options.graph, "graph document (.json), or a picture that Weft wrote")->required();
    add_overrides(command, options.overrides);
}

void load_nodes(const std::vector<std::string>& folders) {
    for (const std::string& folder : folders) load_node_libraries(folder);
    if (const char* more = std::getenv("WEFT_NODES"); more && *more) {
        const std::string list = more;
        for (size_t begin = 0; begin <= list.size();) {
            const size_t end = std::min(list.find(':', begin), list.size());
            if (end > begin) load_node_libraries(list.substr(begin, end - begin));
            begin = end + 1;
        }
    }
    for (const std::string& conflict : Registry::instance().conflicts()) cli::complain("warning: " + conflict);
}

int dispatch(int argc, char** argv) {
    CLI::App app{"Weft turns sparse Monte Carlo samples into pictures, by graphs of nodes."};
    app.set_version_flag("--version", std::string("weft ") + program_version);
    app.require_subcommand(1);
    app.fallthrough();
    std::vector<std::string> node_folders;
    app.add_option("--nodes", node_folders, "folder of further node libraries; $WEFT_NODES too")->allow_extra_args(false);
    int status = cli::done;
    const auto on = [&](CLI::App* command, std::function<int()> work) {
        command->callback([&, work] {
            load_nodes(node_folders);
            status = work();
        });
    };

    cli::RunCommand run;
    CLI::App* run_command = app.add_subcommand("run", "run a graph, or repeat the run that a picture came from");
    add_graph_options(*run_command, run);
    run_command->add_option("--threads", run.threads, "threads to use; default: one a core")->check(CLI::Range(1, 4096));
    run_command->add_option("--tile", run.tile, "tile side in pixels; changes no result")->check(CLI::Range(1, 65536));
    run_command->add_option("--memory", run.memory, "refuse a plan that needs more, as in 8G");
    run_command->add_option("--report", run.report, "write seconds and items of every node and stage (JSON)");
    run_command->add_option("--trace", run.trace, "write a trace for Perfetto or chrome://tracing");
    run_command->add_option("--tap", run.taps, "write a value (node.port=file) or a stream's records (node.port@x,y=file)")
        ->allow_extra_args(false);
    run_command->add_flag("--no-fuse", run.no_fuse, "run every stage by itself, fusions left out");
    run_command->add_option("--isa", run.isa, "instruction set of the kernels: v2, v3 or v4");
    run_command->add_option("--executor", run.executor, "tbb, threads or serial")
        ->check(CLI::IsMember({"tbb", "threads", "serial"}));
    run_command->add_flag("--quiet", run.quiet, "no progress");
    run_command->add_option("--shard", run.shard, "do part I of N, as in 2/5, into a file for 'weft merge'");
    run_command->add_option("--part", run.part, "the file for --shard; default: beside the graph's 'out'");
    run_command->add_option("--divide", run.divide, "node whose work --shard divides; default: the last that can be")->allow_extra_args(false);
    run_command->add_option("--expect", run.expect, "refuse if files, program or instruction set are not those of this job.json of 'weft farm'");
    on(run_command, [&] { return cli::run(run); });

    cli::MergeCommand merge;
    CLI::App* merge_command = app.add_subcommand("merge", "join what the shards of a run made, and do the rest of it");
    merge_command->add_option("out", merge.out, "file to write: the graph's 'out'")->required();
    merge_command->add_option("parts", merge.parts, "files that 'weft run --shard' wrote, all of them")->required();
    merge_command->add_option("--set", merge.set, "other names of files to write (k=v)")->allow_extra_args(false);
    merge_command->add_option("--threads", merge.threads, "threads to use; default: one a core")->check(CLI::Range(1, 4096));
    merge_command->add_option("--memory", merge.memory, "refuse a plan that needs more, as in 8G");
    merge_command->add_option("--report", merge.report, "write seconds of every node (JSON)");
    merge_command->add_option("--trace", merge.trace, "write a trace for Perfetto or chrome://tracing");
    merge_command->add_flag("--quiet", merge.quiet, "no progress");
    on(merge_command, [&] { return cli::merge(merge); });

    cli::FarmCommand farm;
    CLI::App* farm_command = app.add_subcommand("farm", "run a graph in shards on many machines, and merge them");
    farm_command->add_option("graph", farm.graph, "graph document (.json), or a picture that Weft wrote");
    add_overrides(*farm_command, farm.overrides);
    farm_command->add_option("--shards", farm.shards, "into how many parts the work is divided")->check(CLI::Range(1, 100000));
    farm_command->add_option("--engine", farm.engine, "slurm (job arrays), or local (processes here)")->check(CLI::IsMember({"slurm", "local"}));
    farm_command->add_option("--folder", farm.folder, "the job's: graph, script, parts, logs; default: beside the graph's 'out'");
    farm_command->add_flag("--resume", farm.resume, "do only shards whose part is missing or of other input");
    farm_command->add_flag("--follow", farm.follow, "show how the job in --folder goes, until it is done");
    farm_command->add_flag("--dry-run", farm.dry_run, "check and plan; print the script and what would be submitted");
    farm_command->add_option("--divide", farm.divide, "node whose work is divided; default: the last that can be")->allow_extra_args(false);
    farm_command->add_option("--isa", farm.isa, "instruction set of all shards: v2, v3 or v4; default: the best of this machine");
    farm_command->add_option("--tile", farm.tile, "tile side in pixels; changes no result")->check(CLI::Range(1, 65536));
    farm_command->add_option("--threads", farm.threads, "of a shard; default: what the engine gives it")->check(CLI::Range(1, 4096));
    farm_command->add_option("--memory", farm.memory, "refuse a plan that needs more, as in 8G");
    farm_command->add_option("--at-once", farm.at_once, "local: shards that run at a time; default: 1")->check(CLI::Range(1, 4096));
    farm_command->add_option("--partition", farm.partition, "slurm: where to");
    farm_command->add_option("--slurm", farm.slurm, "slurm: a further argument to sbatch, as in --slurm=--time=2:00:00")->allow_extra_args(false);
    farm_command->add_flag("--quiet", farm.quiet, "no progress");
    on(farm_command, [&] {
        farm.nodes = node_folders;
        return cli::farm(farm);
    });

    cli::CheckCommand check;
    CLI::App* check_command = app.add_subcommand("check", "all findings about graph documents");
    check_command->add_option("graphs", check.graphs, "graph documents")->required();
    add_overrides(*check_command, check.overrides);
    check_command->add_flag("--json", check.json, "findings as JSON");
    on(check_command, [&] { return cli::check(check); });

    cli::PlanCommand plan;
    CLI::App* plan_command = app.add_subcommand("plan", "tasks, stream segments, lifetimes and bytes of a graph");
    add_graph_options(*plan_command, plan);
    plan_command->add_option("--threads", plan.threads, "threads to plan for; default: one a core");
    plan_command->add_option("--memory", plan.memory, "refuse a plan that needs more, as in 8G");
    plan_command->add_option("--tap", plan.taps, "as for run")->allow_extra_args(false);
    plan_command->add_flag("--no-fuse", plan.no_fuse, "as for run");
    plan_command->add_flag("--json", plan.json, "the plan as JSON");
    on(plan_command, [&] { return cli::plan(plan); });

    cli::GraphOptions dot;
    bool mermaid = false;
    CLI::App* dot_command = app.add_subcommand("dot", "a drawing of a graph, for Graphviz or Mermaid");
    add_graph_options(*dot_command, dot);
    dot_command->add_flag("--mermaid", mermaid, "Mermaid instead of Graphviz");
    on(dot_command, [&] { return cli::dot(dot, mermaid); });

    bool json = false;
    std::string family, type, picture, reference, error_picture, file;
    CLI::App* nodes_command = app.add_subcommand("nodes", "the node types, by family");
    nodes_command->add_option("family", family, "only this family");
    nodes_command->add_flag("--json", json, "all declarations as JSON");
    on(nodes_command, [&] { return cli::nodes(family, json); });

    CLI::App* node_command = app.add_subcommand("node", "ports and parameters of a node type");
    node_command->add_option("type", type, "as in \"type\" of a graph")->required();
    node_command->add_flag("--json", json, "the declaration as JSON");
    on(node_command, [&] { return cli::node(type, json); });

    on(app.add_subcommand("schema", "JSON Schema of graph documents"), [] { return cli::schema(); });

    CLI::App* compare_command = app.add_subcommand("compare", "error measures between a picture and a reference");
    compare_command->add_option("picture", picture, "the picture to judge")->required();
    compare_command->add_option("reference", reference, "what it should be")->required();
    compare_command->add_option("--error", error_picture, "write a picture of the error");
    compare_command->add_flag("--json", json, "the table as JSON");
    on(compare_command, [&] { return cli::compare(picture, reference, error_picture, json); });

    CLI::App* show_command = app.add_subcommand("show", "what a picture or a sample file holds");
    show_command->add_option("file", file, "picture or sample file")->required();
    show_command->add_flag("--json", json, "as JSON");
    on(show_command, [&] { return cli::show(file, json); });

    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& success) {  // --help, --version
        return app.exit(success);
    } catch (const CLI::ParseError& error) {
        app.exit(error);
        return cli::misused;
    }
    return status;
}

}  // namespace

int main(int argc, char** argv) {
#ifdef M_MMAP_THRESHOLD
    // Memory that one node is done with is the next one's: the system clears all that it gives.
    mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the most that is allowed
    mallopt(M_TRIM_THRESHOLD, 256 << 20);
#endif
    try {
        return dispatch(argc, argv);
    } catch (const weft::UsageError& error) {
        weft::cli::complain(error.what());
        return weft::cli::misused;
    } catch (const weft::PlacedError& error) {
        weft::cli::print_findings({{weft::Diagnostic::Level::error, error.what(), error.place}});
        return weft::cli::failed;
    } catch (const std::bad_alloc&) {
        weft::cli::complain("ran out of memory");
        return weft::cli::failed;
    } catch (const std::exception& error) {
        weft::cli::complain(error.what());
        return weft::cli::failed;
    }
}
