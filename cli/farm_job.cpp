#include "cli/farm_job.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "cli/process.h"
#include "runtime/atomic_file.h"
#include "runtime/part_header.h"

namespace weft::cli {

namespace fs = std::filesystem;

namespace {

std::string slurp(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw Error(fmt::format("{}: cannot open it to read", path));
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

Json texts(const std::vector<std::string>& all) {
    Json list = Json::list();
    for (const std::string& text : all) list.items.push_back(Json(text));
    return list;
}

std::vector<std::string> last_lines(const std::string& path, size_t count) {
    std::ifstream file(path, std::ios::binary);
    std::error_code error;
    const auto size = fs::file_size(path, error);
    constexpr std::uintmax_t most = 8192;
    if (!error && size > most) file.seekg(std::streamoff(size - most));
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);)
        if (!line.empty()) lines.push_back(line);
    if (lines.size() > count) lines.erase(lines.begin(), lines.end() - std::ptrdiff_t(count));
    return lines;
}

std::string command(const std::vector<std::string>& words) {
    std::vector<std::string> quoted;
    for (const std::string& word : words) quoted.push_back(shell_quoted(word));
    return fmt::format("{}", fmt::join(quoted, " "));
}

}  // namespace

std::string FarmJob::part(int shard) const {
    return path(fmt::format("parts/{}.part", shard));
}
std::string FarmJob::log(int shard) const {
    return shard == 0 ? path("logs/merge.log") : path(fmt::format("logs/{}.log", shard));
}
std::string FarmJob::name_of(int shard) const {
    return shard == 0 ? "the merge" : fmt::format("shard {}/{}", shard, shards());
}
bool FarmJob::merged() const {
    return fs::exists(path("merged"));
}

bool FarmJob::has_part(int shard, std::string* why) const {
    if (!fs::exists(part(shard))) return false;
    std::string reason;
    try {
        const PartHeader found = PartFile(part(shard)).header();
        if (found.shard != Shard{shard, shards()})
            reason = fmt::format("it is shard {}", found.shard.text());
        else if (found.key != header.key)
            reason = "its key differs: made of other input, or with other parameters";
        else if (found.provenance.graph != header.provenance.graph)
            reason = "made of another graph";
        else if (found.isa != header.isa)
            reason = fmt::format("made with instruction set {}", found.isa);
        else if (found.tile != header.tile)
            reason = fmt::format("made with tiles of {} pixels", found.tile);
        else if (found.provenance.version != header.provenance.version)
            reason = fmt::format("made by weft {}", found.provenance.version);
    } catch (const Error& error) {
        reason = error.what();
    }
    if (why) *why = reason;
    return reason.empty();
}

std::string FarmJob::script_text() const {
    std::vector<std::string> sets, plugins, run, merge;
    for (const auto& [name, value] : header.files) {
        sets.push_back("--set");
        sets.push_back(fmt::format("{}={}", name, value));
    }
    for (const std::string& folder_of_nodes : nodes)
        plugins.insert(plugins.end(), {"--nodes", folder_of_nodes});
    run = {program,         "run",    path("graph.json"),          "--isa",
           header.isa,      "--tile", std::to_string(header.tile), "--expect",
           path("job.json")};
    for (const std::string& node : divide) run.insert(run.end(), {"--divide", node});
    if (!memory.empty()) run.insert(run.end(), {"--memory", memory});
    run.insert(run.end(), plugins.begin(), plugins.end());
    run.insert(run.end(), sets.begin(), sets.end());
    merge = {program, "merge"};
    merge.insert(merge.end(), plugins.begin(), plugins.end());
    if (!memory.empty()) merge.insert(merge.end(), {"--memory", memory});
    // OUT is the graph's 'out' or the only name of a file that it has.
    const std::string own = header.files.count("out")  ? "out"
                            : header.files.size() == 1 ? header.files.begin()->first
                                                       : "";
    for (const auto& [name, value] : header.files)
        if (name != own) merge.insert(merge.end(), {"--set", fmt::format("{}={}", name, value)});
    merge.push_back(own.empty() ? "" : header.files.at(own));
    for (int i = 1; i <= shards(); ++i) merge.push_back(part(i));

    return fmt::format(
        R"(#!/bin/sh
# {graph} in {shards} shards, planned by 'weft farm'.  run.sh I [THREADS]: shard I.  run.sh merge [THREADS]: joins them.
cd {work} || exit 1
threads=${{2:-{threads}}}
if [ "$1" = merge ]; then
    {merge} ${{threads:+--threads "$threads"}} || exit
    : > {merged}
else
    exec {run} --shard "$1/{shards}" --part {parts}/"$1.part" ${{threads:+--threads "$threads"}}
fi
)",
        fmt::arg("graph", fs::path(graph).filename().string()), fmt::arg("shards", shards()),
        fmt::arg("work", shell_quoted(work)),
        fmt::arg("threads", threads > 0 ? std::to_string(threads) : ""),
        fmt::arg("merge", command(merge)), fmt::arg("merged", shell_quoted(path("merged"))),
        fmt::arg("run", command(run)), fmt::arg("parts", shell_quoted(path("parts"))));
}

void FarmJob::write() const {
    fs::create_directories(path("parts"));
    fs::create_directories(path("logs"));
    Json job = to_json(header);  // "weft", "key", "isa", "inputs" ... are what --expect reads
    job.set("program", program);
    job.set("work", work);
    job.set("graph-file", graph);
    job.set("engine", engine);
    job.set("out", out);
    job.set("nodes", texts(nodes));
    job.set("divide", texts(divide));
    job.set("memory", memory);
    job.set("threads", threads);
    write_file(path("job.json"), job.dump(true) + "\n");
    write_file(path("graph.json"), header.provenance.graph);
    write_file(script(), script_text());
    fs::permissions(script(), fs::perms::owner_exec | fs::perms::group_exec, fs::perm_options::add);
}

bool FarmJob::is_there(const std::string& folder) {
    return fs::exists(folder + "/job.json");
}

FarmJob FarmJob::read(const std::string& folder) {
    FarmJob job;
    job.folder = fs::absolute(folder).lexically_normal().string();
    const std::string file = job.path("job.json"), text = slurp(file);
    job.header = part_header(text, file);
    const Json in = parse_json_or_throw(text, file);
    const auto member = [&](const char* name) {
        const Json* found = in.find(name);
        if (!found)
            throw Error(
                fmt::format("{}: '{}' is missing; it is no job of 'weft farm'", file, name));
        return *found;
    };
    job.program = member("program").text;
    job.work = member("work").text;
    job.graph = member("graph-file").text;
    job.engine = member("engine").text;
    job.out = member("out").text;
    for (const Json& item : member("nodes").items) job.nodes.push_back(item.text);
    for (const Json& item : member("divide").items) job.divide.push_back(item.text);
    job.memory = member("memory").text;
    job.threads = int(member("threads").integer);
    return job;
}

void FarmJob::forget(const std::vector<int>& shards) const {
    std::error_code ignored;
    for (const int shard : shards) {
        fs::remove(part(shard), ignored);
        fs::remove(log(shard), ignored);
    }
    fs::remove(log(0), ignored);
    fs::remove(path("merged"), ignored);
}

std::string log_tail(const std::string& path, size_t lines) {
    std::string text;
    for (const std::string& line : last_lines(path, lines)) text += fmt::format("    {}\n", line);
    return text.empty() ? "    (empty)\n" : text;
}

std::string log_progress(const std::string& path) {
    const std::vector<std::string> lines = last_lines(path, 1);
    if (lines.empty()) return "";
    const size_t percent = lines[0].find(" %  ");
    if (percent == std::string::npos) return "";
    const size_t colon = lines[0].rfind(": ", percent);
    if (colon == std::string::npos) return "";
    const size_t begin = lines[0].find_first_not_of(' ', colon + 2);
    return fmt::format("{} %", lines[0].substr(begin, percent - begin));
}

}  // namespace weft::cli
