// The Slurm engine: shards as one job array, the merge as a job that depends on it (sbatch, squeue,
// scancel). No accounting database is asked: states come from squeue, and what is done from the
// parts. A job that Slurm loses is queued again (--requeue); one that is killed on its node (out of
// memory, by hand) queues itself again, twice.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fstream>
#include <sstream>

#include "cli/farm_engine.h"
#include "cli/process.h"
#include "runtime/atomic_file.h"

namespace weft::cli {
namespace {

// "1-3,7": the array's indices.
std::string index_text(const std::vector<int>& shards) {
    std::string text;
    for (size_t i = 0; i < shards.size();) {
        size_t end = i + 1;
        while (end < shards.size() && shards[end] == shards[end - 1] + 1) ++end;
        text += fmt::format("{}{}", text.empty() ? "" : ",", shards[i]);
        if (end - i > 1) text += fmt::format("-{}", shards[end - 1]);
        i = end;
    }
    return text;
}

std::string trimmed(std::string text) {
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
    return text;
}

FarmState::What meaning(const std::string& state) {
    for (const char* word : {"PENDING", "CONFIGURING", "REQUEUED", "REQUEUE_HOLD", "REQUEUE_FED",
                             "SPECIAL_EXIT", "RESV_DEL_HOLD"})
        if (state == word) return FarmState::waiting;
    for (const char* word :
         {"RUNNING", "COMPLETING", "SUSPENDED", "STOPPED", "SIGNALING", "STAGE_OUT", "RESIZING"})
        if (state == word) return FarmState::running;
    return FarmState::ended;
}

class SlurmEngine final : public FarmEngine {
  public:
    explicit SlurmEngine(EngineOptions options) : options_(std::move(options)) {}

    void expect_idle(const FarmJob& job) override {
        read_ids(job);
        for (const auto& [shard, state] : poll(job))
            if (state.what != FarmState::ended)
                throw Error(
                    fmt::format("job {} of {} is still in the queue ({}); follow it with 'weft "
                                "farm --folder {} --follow', or end it "
                                "with 'scancel {} {}' first",
                                shard == 0 ? merge_id_ : array_id_, job.folder, state.word,
                                shell_quoted(job.folder), array_id_, merge_id_));
    }

    void submit(const FarmJob& job, const std::vector<int>& shards) override {
        array_id_.clear();
        if (!shards.empty()) array_id_ = sbatch(array_command(job, shards));
        write_ids(job);
        merge_id_ = sbatch(merge_command(job, array_id_));
        write_ids(job);
    }

    FarmStates poll(const FarmJob& job) override {
        if (array_id_.empty() && merge_id_.empty()) read_ids(job);
        FarmStates states;
        for (const std::string& id : {array_id_, merge_id_}) {
            if (id.empty()) continue;
            // Of a job that ended longer ago than the controller remembers there is only an error.
            const ProcessResult squeue =
                run_process({"squeue", "-h", "-r", "-t", "all", "-j", id, "-o", "%F|%K|%T|%r"});
            if (squeue.status == 127)
                throw Error("squeue: no such program; is this machine one of the farm's?");
            if (squeue.status != 0 && squeue.err.find("Invalid job id") == std::string::npos) {
                // The controller does not answer: nothing is known, so nothing has changed.
                states = last_;
                return states;
            }
            std::istringstream lines(squeue.out);
            for (std::string line; std::getline(lines, line);) {
                std::istringstream fields(line);
                std::string job_id, index, state, reason;
                std::getline(fields, job_id, '|');
                std::getline(fields, index, '|');
                std::getline(fields, state, '|');
                std::getline(fields, reason, '|');
                reason = trimmed(reason);
                const bool of_array = id == array_id_ && !index.empty() &&
                                      index.find_first_not_of("0123456789") == std::string::npos;
                if (id == array_id_ && !of_array) continue;
                const bool tell = !reason.empty() && reason != "None" && state == "PENDING";
                states[of_array ? std::stoi(index) : 0] = {
                    meaning(state), tell ? fmt::format("{}, {}", state, reason) : state};
            }
        }
        last_ = states;
        return states;
    }

    void cancel_merge(const FarmJob&) override {
        if (!merge_id_.empty()) run_process({"scancel", merge_id_});
    }

    std::vector<std::string> commands(const FarmJob& job,
                                      const std::vector<int>& shards) const override {
        std::vector<std::string> all;
        if (!shards.empty()) all.push_back(quoted(array_command(job, shards)));
        all.push_back(quoted(merge_command(job, shards.empty() ? "" : "JOB")));
        return all;
    }

    std::string leave(const FarmJob&) override {
        return fmt::format(
            "the jobs go on (squeue -j {0}; scancel {1} ends them)",
            array_id_.empty() ? merge_id_ : fmt::format("{},{}", array_id_, merge_id_),
            array_id_.empty() ? merge_id_ : fmt::format("{} {}", array_id_, merge_id_));
    }

  private:
    std::vector<std::string> common(const FarmJob& job, const std::string& name) const {
        std::vector<std::string> words = {"sbatch",
                                          "--parsable",
                                          fmt::format("--job-name=weft-{}", name),
                                          fmt::format("--chdir={}", job.work),
                                          "--open-mode=append",
                                          "--requeue"};
        if (!options_.partition.empty()) words.push_back("--partition=" + options_.partition);
        if (job.threads > 0) words.push_back(fmt::format("--cpus-per-task={}", job.threads));
        words.insert(words.end(), options_.arguments.begin(), options_.arguments.end());
        return words;
    }

    std::vector<std::string> array_command(const FarmJob& job,
                                           const std::vector<int>& shards) const {
        std::vector<std::string> words = common(job, "shard");
        words.push_back("--array=" + index_text(shards));
        words.push_back(fmt::format("--output={}", job.path("logs/%a.log")));
        // 137: killed. Its own requeue is refused where the site forbids it; then it has failed.
        words.push_back(fmt::format(
            "--wrap=/bin/sh {} \"$SLURM_ARRAY_TASK_ID\" \"$SLURM_CPUS_ON_NODE\"; status=$?\n"
            "if [ $status = 137 ] && [ \"${{SLURM_RESTART_COUNT:-0}}\" -lt 2 ]; then "
            "echo 'killed; queued again'; scontrol requeue \"$SLURM_JOB_ID\"; sleep 60; fi\nexit "
            "$status",
            shell_quoted(job.script())));
        return words;
    }

    std::vector<std::string> merge_command(const FarmJob& job, const std::string& after) const {
        std::vector<std::string> words = common(job, "merge");
        if (!after.empty()) {
            words.push_back("--dependency=afterok:" + after);
            words.push_back("--kill-on-invalid-dep=yes");
        }
        words.push_back(fmt::format("--output={}", job.log(0)));
        words.push_back(fmt::format("--wrap=/bin/sh {} merge \"$SLURM_CPUS_ON_NODE\"",
                                    shell_quoted(job.script())));
        return words;
    }

    static std::string quoted(const std::vector<std::string>& words) {
        std::vector<std::string> all;
        for (const std::string& word : words) all.push_back(shell_quoted(word));
        return fmt::format("{}", fmt::join(all, " "));
    }

    static std::string sbatch(const std::vector<std::string>& words) {
        const ProcessResult result = run_process(words);
        if (result.status == 127)
            throw Error(
                "sbatch: no such program; install Slurm's client here, or use --engine local");
        if (result.status != 0)
            throw Error(fmt::format("sbatch refused the job: {}",
                                    trimmed(result.err.empty() ? result.out : result.err)));
        const std::string id = trimmed(result.out.substr(0, result.out.find(';')));
        if (id.empty() || id.find_first_not_of("0123456789") != std::string::npos)
            throw Error(
                fmt::format("sbatch answered '{}'; expected a job's number", trimmed(result.out)));
        return id;
    }

    void write_ids(const FarmJob& job) const {
        Json ids = Json::object();
        ids.set("array", array_id_);
        ids.set("merge", merge_id_);
        write_file(job.path("engine.json"), ids.dump() + "\n");
    }
    void read_ids(const FarmJob& job) {
        std::ifstream file(job.path("engine.json"), std::ios::binary);
        if (!file) return;
        std::stringstream text;
        text << file.rdbuf();
        const Json ids = parse_json_or_throw(text.str(), job.path("engine.json"));
        if (const Json* id = ids.find("array")) array_id_ = id->text;
        if (const Json* id = ids.find("merge")) merge_id_ = id->text;
    }

    EngineOptions options_;
    std::string array_id_, merge_id_;
    FarmStates last_;
};

}  // namespace

std::unique_ptr<FarmEngine> make_slurm_engine(const EngineOptions& options) {
    return std::make_unique<SlurmEngine>(options);
}

}  // namespace weft::cli
