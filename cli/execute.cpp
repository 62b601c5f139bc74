#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "cli/execute.h"
#include "cli/terminal.h"
#include "image/picture_file.h"
#include "runtime/atomic_file.h"
#include "runtime/isa.h"
#include "runtime/provenance.h"
#include "runtime/registry.h"
#include "runtime/run.h"

namespace weft::cli {
namespace {

// The first few by name, how many follow.
std::string some_of(const std::vector<std::string>& nodes) {
    constexpr size_t few = 6;
    const auto end = nodes.begin() + std::ptrdiff_t(std::min(nodes.size(), few));
    std::string text = fmt::format("{}", fmt::join(nodes.begin(), end, ", "));
    if (nodes.size() > few) text += fmt::format(" and {} more", nodes.size() - few);
    return text;
}

void print_errors(const RunResult& result) {
    for (const NodeError& error : result.errors) {
        std::string message = fmt::format("'{}': {}", error.node, error.message);
        if (!error.skipped.empty())
            message += fmt::format("; skipped because of it: {}", some_of(error.skipped));
        print_findings({{Diagnostic::Level::error, message, error.place}});
    }
}

bool is_picture(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    char head[16] = {};
    file.read(head, sizeof head);
    return is_exr_or_png({head, size_t(file.gcount())});
}

// A file that the picture was made from and that is not what it was: the run goes on, with a word.
void compare_inputs(const std::string& picture, const std::string& recorded) {
    const Json inputs = parse_json_or_throw(recorded, picture + ": weft:inputs");
    for (const Json& input : inputs.items) {
        const Json *path = input.find("path"), *hash = input.find("xxh3");
        if (!path || !hash) continue;
        std::error_code error;
        if (!std::filesystem::exists(path->text, error)) continue;  // its reader will say so
        if (content_hash(path->text) != hash->text)
            complain(
                fmt::format("warning: {}: has changed since {} was made", path->text, picture));
    }
}

// The graph a picture carries, as if it were a document.
Loaded load_from_picture(const std::string& picture, const LoadOptions& options) {
    const auto attributes = picture_info(picture).attributes;
    const auto graph = attributes.find("weft:graph");
    if (graph == attributes.end())
        throw Error(fmt::format(
            "{}: carries no graph; only pictures that Weft wrote can be run again", picture));
    if (const auto inputs = attributes.find("weft:inputs"); inputs != attributes.end())
        compare_inputs(picture, inputs->second);
    if (const auto version = attributes.find("weft:version");
        version != attributes.end() && version->second != program_version)
        complain(fmt::format("warning: {}: made by weft {}, this is {}", picture, version->second,
                             program_version));
    return load_graph_text(graph->second, picture, Registry::instance(), options);
}

}  // namespace

std::unique_ptr<Executor> executor_named(const std::string& name, int threads) {
    if (name == "threads") return make_thread_executor(threads);
    if (name == "serial") return make_serial_executor();
    return make_tbb_executor(threads);
}

void pin_isa_named(const std::string& name) {
    if (name.empty()) return;
    const auto isa = isa_named(name);
    if (!isa) throw UsageError(fmt::format("--isa {}: expected v2, v3 or v4", name));
    pin_isa(*isa);
}

Loaded load_for_run(const std::string& graph, const Overrides& overrides) {
    LoadOptions load;
    load.overrides = overrides;
    load.for_run = true;
    return is_picture(graph) ? load_from_picture(graph, load)
                             : load_graph(graph, Registry::instance(), load);
}

std::string file_parameter(const Graph& graph, const std::string& name) {
    for (const GraphParameter& parameter : graph.parameters)
        if (parameter.decl.name == name && parameter.decl.kind == Kind::file)
            return parameter.value.text;
    return "";
}

std::string part_name(const Graph& graph, const Shard& shard) {
    std::filesystem::path out = file_parameter(graph, "out");
    if (out.empty()) out = std::filesystem::path(graph.name).filename();
    return out.replace_extension(fmt::format(".shard-{}-of-{}.part", shard.index, shard.count))
        .string();
}

std::string parameter_of_out(const PartHeader& header) {
    if (header.files.empty())
        throw Error(
            fmt::format("{}: writes no file; there is nothing to merge", header.graph_name));
    if (header.files.count("out")) return "out";
    if (header.files.size() == 1) return header.files.begin()->first;
    std::vector<std::string> names;
    for (const auto& [name, value] : header.files) names.push_back(name);
    throw UsageError(
        fmt::format("{}: writes several files and none is called 'out', so it is not known which "
                    "OUT is; give the graph a "
                    "parameter 'out' (it has {})",
                    header.graph_name, fmt::join(names, ", ")));
}

Status execute(const Plan& plan, Executor& executor, RunOptions run, const ExecuteOptions& options,
               RunResult& result) {
    run.stop = &interruption();
    catch_interruptions();
    Monitor monitor;
    monitor.tracing = !options.trace.empty();
    {
        monitor.begin(plan);
        ProgressDisplay display(monitor, options.quiet);
        monitor.warning = [&](const std::string& node, const std::string& message) {
            display.note(fmt::format("warning: '{}': {}", node, message));
        };
        result = run_plan(plan, executor, monitor, run);
    }
    print_errors(result);
    if (!options.report.empty())
        write_file(options.report, report_json(result, plan, executor.threads()));
    if (!options.trace.empty()) write_file(options.trace, monitor.trace());
    if (result.cancelled) {
        complain("interrupted; no partial file was left");
        return interrupted;
    }
    return result.errors.empty() ? done : failed;
}

}  // namespace weft::cli
