// A farm job's folder: all that its workers need, and what they leave.
//
//   job.json          key, shards, tiles, instruction set, inputs: what workers are held to
//   graph.json        the flattened graph
//   run.sh            "run.sh I [THREADS]" does shard I, "run.sh merge [THREADS]" joins them
//   parts/I.part      of each shard that is done
//   logs/I.log, logs/merge.log
//   merged            there once the merge is done
//   engine.json       the engine's own: which jobs it submitted
#pragma once
#include <string>
#include <vector>

#include "graph/json.h"
#include "runtime/part_file.h"

namespace weft::cli {

struct FarmJob {
    std::string folder;                      // absolute, as all paths in it are
    std::string program;                     // this one
    std::string work;                        // where files' names are relative to
    std::string graph;                       // as it was named
    std::string engine;                      // "slurm", "local"
    std::string out;                         // the graph's 'out', "" where it has none
    PartHeader header;                       // what every part must say, but for its shard's index
    std::vector<std::string> nodes, divide;  // --nodes, --divide
    std::string memory;                      // --memory, "" for none
    int threads = 0;                         // of a shard; 0: what the engine gives it

    int shards() const { return header.shard.count; }
    std::string part(int shard) const;
    std::string log(int shard) const;  // 0: the merge's
    std::string path(const std::string& name) const { return folder + "/" + name; }
    std::string name_of(int shard) const;  // "shard 3/5", "the merge"

    // Whether the part is there and of this job; if not, why: "" where there is none.
    bool has_part(int shard, std::string* why = nullptr) const;
    bool merged() const;
    // The command of a shard or of the merge, for an engine.
    std::string script() const { return path("run.sh"); }
    std::string script_text() const;

    void write() const;                              // job.json, graph.json, run.sh, folders
    static FarmJob read(const std::string& folder);  // throws Error
    static bool is_there(const std::string& folder);
    void forget(
        const std::vector<int>& shards) const;  // parts, logs and 'merged' of an earlier try
};

// The last lines of a log, indented; "(empty)".
std::string log_tail(const std::string& path, size_t lines);
// How far a running shard is, from the last progress line of its log: "37 %", or "".
std::string log_progress(const std::string& path);

}  // namespace weft::cli
