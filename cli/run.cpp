// run: checks, plans and runs a graph, or a shard of it.
#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "cli/commands.h"
#include "cli/execute.h"
#include "cli/terminal.h"
#include "runtime/isa.h"
#include "runtime/keys.h"
#include "runtime/shard.h"

namespace weft::cli {
namespace {

// A farm's worker does the job that was planned, or nothing: other files, another program or
// another instruction set would be found by the merge, after all the work.
void expect_job(const std::string& file, const PartHeader& header, const FilesRead& files) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw Error(fmt::format("{}: cannot open it to read", file));
    std::stringstream text;
    text << in.rdbuf();
    const Json job = parse_json_or_throw(text.str(), file);
    const auto expected = [&](const char* name) {
        const Json* value = job.find(name);
        return value ? value->text : std::string();
    };
    if (expected("weft") != header.provenance.version)
        throw Error(fmt::format("planned with weft {}, this is {}", expected("weft"),
                                header.provenance.version));
    if (expected("isa") != header.isa)
        throw Error(fmt::format("planned for instruction set {}, this runs with {}; use --isa {}",
                                expected("isa"), header.isa, expected("isa")));
    if (expected("key") == header.key) return;
    const Json inputs = parse_json_or_throw(expected("inputs"), file + ": inputs");
    for (const Json& input : inputs.items) {
        const Json *path = input.find("path"), *hash = input.find("xxh3");
        const auto found = path ? files.find(path->text) : files.end();
        if (found == files.end()) continue;
        if (found->second.hash.empty() && hash)
            throw Error(
                fmt::format("{}: is not here; it was when the job was planned", path->text));
        if (hash && found->second.hash != hash->text)
            throw Error(
                fmt::format("{}: is another file than the job was planned with (content {}, "
                            "planned {}); put the same file here, "
                            "or plan again",
                            path->text, found->second.hash, hash->text));
    }
    throw Error(fmt::format(
        "the key here is {}, the job was planned with {}: other files or another graph; plan again",
        header.key, expected("key")));
}

int run_shard(const RunCommand& options, const Plan& plan, Executor& executor) {
    const Shard shard = parse_shard(options.shard);
    const FilesRead files = files_read(plan);
    PartHeader header = shard_header(plan, files, shard, options.tile);
    if (!options.expect.empty()) expect_job(options.expect, header, files);
    const std::string path = options.part.empty() ? part_name(*plan.graph, shard) : options.part;
    PartWriter part(path);
    RunOptions run_options;
    run_options.tile = options.tile;
    run_options.provenance = header.provenance;
    run_options.shard = shard;
    run_options.part = &part;
    RunResult result;
    const Status status = execute(plan, executor, run_options,
                                  {options.quiet, options.report, options.trace}, result);
    if (status != done) return status;
    header.tasks = result.divided;
    part.finish(header);
    if (!options.quiet)
        complain(fmt::format("shard {} is in {}; 'weft merge OUT PARTS...' joins all {}",
                             shard.text(), path, shard.count));
    return done;
}

}  // namespace

int run(const RunCommand& options) {
    const Loaded loaded = load_for_run(options.graph, options.overrides);
    print_findings(loaded.findings);
    if (!loaded.ok()) return misused;
    if (options.shard.empty())
        for (const auto& [option, value] :
             {std::pair("--part", options.part), std::pair("--expect", options.expect)})
            if (!value.empty())
                throw UsageError(fmt::format("{} is for a shard; use it with --shard I/N", option));
    if (options.shard.empty() && !options.divide.empty())
        throw UsageError("--divide is for a shard; use it with --shard I/N");

    pin_isa_named(options.isa);
    const std::unique_ptr<Executor> executor = executor_named(options.executor, options.threads);
    PlanOptions plan_options;
    plan_options.taps = options.taps;
    plan_options.fuse = !options.no_fuse;
    plan_options.threads = executor->threads();
    if (!options.memory.empty()) plan_options.memory_limit = parse_bytes(options.memory);
    if (!options.shard.empty()) {
        parse_shard(options.shard);
        plan_options.work = Work::shard;
        plan_options.divide = options.divide;
    }
    const Plan plan = make_plan(loaded.graph, plan_options);
    if (plan.tasks.empty()) {
        complain(
            fmt::format("{}: nothing to do: no node of this graph writes anything; add a "
                        "'write-image' or use --tap",
                        options.graph));
        return misused;
    }
    if (!options.shard.empty()) return run_shard(options, plan, *executor);

    RunOptions run_options;
    run_options.tile = options.tile;
    run_options.provenance = make_provenance(plan);
    RunResult result;
    return execute(plan, *executor, run_options, {options.quiet, options.report, options.trace},
                   result);
}

}  // namespace weft::cli
