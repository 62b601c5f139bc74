// farm: a graph in shards on many machines: planned and checked here, run by an engine, followed
// until done.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <thread>

#include "cli/execute.h"
#include "cli/farm_engine.h"
#include "cli/process.h"
#include "cli/terminal.h"
#include "runtime/isa.h"
#include "runtime/shard.h"

namespace weft::cli {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<FarmEngine> engine_of(const FarmCommand& options, const std::string& name) {
    const EngineOptions engine{options.partition, options.slurm, options.at_once};
    return name == "local" ? make_local_engine(engine) : make_slurm_engine(engine);
}

std::string absolute(const std::string& path) {
    return fs::absolute(path).lexically_normal().string();
}

// Checks and plans: what is wrong is found here and not on the farm.
FarmJob plan_job(const FarmCommand& options, const Graph& graph) {
    PlanOptions plan_options;
    plan_options.work = Work::shard;
    plan_options.divide = options.divide;
    plan_options.threads = options.threads > 0
                               ? options.threads
                               : int(std::max(1u, std::thread::hardware_concurrency()));
    if (!options.memory.empty()) plan_options.memory_limit = parse_bytes(options.memory);
    const Plan plan = make_plan(graph, plan_options);
    FarmJob job;
    job.header = shard_header(plan, files_read(plan), {1, options.shards}, options.tile);
    parameter_of_out(job.header);  // the merge must know what OUT is
    for (const Task& task : plan.tasks)
        if (task.divided)
            job.header.tasks.push_back(
                {graph.nodes[size_t(task.nodes.front())].name, task.name, {}, 0, {}});
    plan_options = merge_options(job.header);
    if (!options.memory.empty()) plan_options.memory_limit = parse_bytes(options.memory);
    make_plan(graph, plan_options);
    job.header.tasks.clear();

    job.program = own_path();
    job.work = fs::current_path().string();
    job.graph = graph.name;
    job.engine = options.engine;
    job.out = file_parameter(graph, "out");
    for (const std::string& folder : options.nodes) job.nodes.push_back(absolute(folder));
    job.divide = options.divide;
    job.memory = options.memory;
    job.threads = options.threads;
    fs::path folder = options.folder;
    if (folder.empty())
        folder = (job.out.empty() ? fs::path(graph.name).filename() : fs::path(job.out))
                     .replace_extension(".farm");
    job.folder = absolute(folder.string());
    return job;
}

// Shows how a job goes: what changes a line each; on a terminal the shards that run below.
class Progress {
  public:
    Progress(const FarmJob& job, bool quiet)
        : job_(job), quiet_(quiet), bars_(!quiet && stderr_is_terminal()) {}
    ~Progress() { erase(); }

    void update(const FarmStates& states, const std::set<int>& done) {
        if (quiet_) return;
        std::string news, running;
        for (int i = 1; i <= job_.shards(); ++i) {
            const auto state = states.find(i);
            std::string now = done.count(i)                              ? "done"
                              : state == states.end()                    ? "not in the queue"
                              : state->second.what == FarmState::running ? "running"
                              : state->second.what == FarmState::waiting ? "waiting"
                                                                         : state->second.word;
            if (now == "running" && bars_)
                running +=
                    fmt::format("  shard {}/{}  {}\n", i, job_.shards(), log_progress(job_.log(i)));
            std::string& before = shown_[i];
            if (now != before && now != "waiting" && now != "not in the queue")
                news += fmt::format(
                    "shard {}/{}: {}{}\n", i, job_.shards(), now,
                    now == "done" ? fmt::format(" ({} of {})", done.size(), job_.shards()) : "");
            before = now;
        }
        if (const auto merge = states.find(0);
            merge != states.end() && merge->second.what == FarmState::running) {
            if (shown_[0] != "running") news += "merge: running\n";
            shown_[0] = "running";
        }
        erase();
        if (bars_) lines_ = std::count(running.begin(), running.end(), '\n');
        fmt::print(stderr, "{}{}", news, bars_ ? running : "");
        std::fflush(stderr);
    }

  private:
    void erase() {
        if (lines_ > 0) fmt::print(stderr, "\x1b[{}A\r\x1b[J", lines_);
        lines_ = 0;
    }
    const FarmJob& job_;
    bool quiet_, bars_;
    std::ptrdiff_t lines_ = 0;
    std::map<int, std::string> shown_;
};

void report_failure(const FarmJob& job, int shard, const std::string& word) {
    complain(fmt::format("{} failed ({}); the last lines of {}:\n{}", job.name_of(shard), word,
                         job.log(shard), log_tail(job.log(shard), 12)));
}

std::string again(const FarmJob& job) {
    return fmt::format(
        "what is done stays in {}; 'weft farm' with the same arguments and --resume does the rest",
        job.folder);
}

// Until the merge is done, or a shard has failed and no other runs.
int follow(const FarmJob& job, FarmEngine& engine, bool quiet, bool may_be_old) {
    catch_interruptions();
    const auto pause = std::chrono::milliseconds(job.engine == "local" ? 100 : 1000);
    std::set<int> done;
    std::map<int, std::string> failed;
    std::map<int, int> absent;  // polls since a shard was last heard of
    Progress progress(job, quiet);
    const int patience =
        may_be_old ? 1 : 5;  // a job just submitted, or a file system that lags behind
    for (;;) {
        const FarmStates states = engine.poll(job);
        bool open = false;
        for (int i = 1; i <= job.shards(); ++i) {
            if (done.count(i) || failed.count(i)) continue;
            if (job.has_part(i)) {
                done.insert(i);
                continue;
            }
            const auto state = states.find(i);
            if (state != states.end() && state->second.what != FarmState::ended) {
                absent[i] = 0;
                open = true;
            } else if (++absent[i] > patience) {
                failed[i] = state == states.end() ? "no longer in the queue" : state->second.word;
            } else {
                open = true;
            }
        }
        progress.update(states, done);
        if (job.merged()) break;
        if (!failed.empty() && !open) break;
        if (int(done.size()) == job.shards()) {
            const auto merge = states.find(0);
            if (merge == states.end() || merge->second.what == FarmState::ended) {
                if (++absent[0] > patience) {
                    failed[0] =
                        merge == states.end() ? "no longer in the queue" : merge->second.word;
                    break;
                }
            } else {
                absent[0] = 0;
            }
        }
        if (!failed.empty()) engine.cancel_merge(job);
        if (interruption()) {
            complain(
                fmt::format("interrupted: {}; follow with 'weft farm --folder {} --follow', or go "
                            "on with --resume",
                            engine.leave(job), shell_quoted(job.folder)));
            return interrupted;
        }
        std::this_thread::sleep_for(pause);
    }
    if (failed.empty()) {
        if (!quiet)
            complain(fmt::format("done: {}", job.out.empty() ? "the merge is through" : job.out));
        return Status::done;
    }
    engine.cancel_merge(job);
    for (const auto& [shard, word] : failed) report_failure(job, shard, word);
    complain(again(job));
    return Status::failed;
}

int follow_again(const FarmCommand& options) {
    if (options.folder.empty()) throw UsageError("--follow: name the job's folder with --folder");
    if (!FarmJob::is_there(options.folder))
        throw Error(fmt::format("{}: holds no job of 'weft farm'", options.folder));
    const FarmJob job = FarmJob::read(options.folder);
    if (job.engine == "local")
        throw UsageError(fmt::format(
            "{}: a local job runs in its own terminal; go on with --resume", options.folder));
    return follow(job, *engine_of(options, job.engine), options.quiet, true);
}

}  // namespace

int farm(const FarmCommand& options) {
    if (options.follow) return follow_again(options);
    if (options.graph.empty()) throw UsageError("farm: name a graph, or a job to --follow");
    if (options.shards < 1)
        throw UsageError("farm: --shards N is missing: in how many parts the work is divided");
    pin_isa_named(options.isa);
    const Loaded loaded = load_for_run(options.graph, options.overrides);
    print_findings(loaded.findings);
    if (!loaded.ok()) return misused;
    const FarmJob job = plan_job(options, loaded.graph);
    const std::unique_ptr<FarmEngine> engine = engine_of(options, options.engine);

    const bool there = FarmJob::is_there(job.folder);
    if (there && !options.resume && !options.dry_run)
        throw UsageError(fmt::format(
            "{}: holds a job already; --resume does what is left of it, or name another --folder",
            job.folder));
    if (there && !options.dry_run) engine->expect_idle(job);
    std::vector<int> shards;
    for (int i = 1; i <= job.shards(); ++i) {
        std::string why;
        if (options.resume && job.has_part(i, &why)) continue;
        if (!why.empty() && !options.quiet)
            complain(fmt::format("{} is done again: {}", job.name_of(i), why));
        shards.push_back(i);
    }
    if (options.dry_run) {
        print(fmt::format("# {}\n{}\n# {}\n", job.script(), job.script_text(), job.engine));
        for (const std::string& command : engine->commands(job, shards)) print(command + "\n");
        return done;
    }
    job.write();
    job.forget(shards);
    engine->submit(job, shards);
    if (!options.quiet)
        complain(fmt::format("{} of {} shards, instruction set {}, logs and parts in {}",
                             shards.size(), job.shards(), job.header.isa, job.folder));
    return follow(job, *engine, options.quiet, false);
}

}  // namespace weft::cli
