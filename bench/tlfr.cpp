// What does light-field reconstruction cost, stage by stage, and how does it grow?
//   bench_tlfr [FOLDER...] [--locations N] [--threads N] [--repeat N]    tables of sample files
//   bench_tlfr --scaling [--repeat N]                                    times against size, spp,
//   locations, threads
// Runs graphs/tlfr.json on every s*.npz below the folders (../shared/data) and prints, of the run
// of median speed: locations per CPU second of the whole run; of the reconstruction alone
// nanoseconds and cycles of CPU, bytes moved and candidates looked at per location, and how many
// times the floor it takes; then the nanoseconds of each node and stage, from the run's own report.
// The floor is an estimate for one core of 3.6 GHz with AVX-512: 30 ns a location at 1 spp for
// arithmetic and memory, 4.3 more for each further sample a pixel. Bytes are counted, not measured:
// 56 for each sample projected (24 read, 16 kept, 16 sorted), and what stages hand on.
#include <fmt/format.h>
#include <linux/perf_event.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <x86intrin.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/graph_runs.h"
#include "samples/analytic_scene.h"
#include "samples/write_npz.h"

namespace {

using namespace weft;
namespace fs = std::filesystem;

// Cycles of this process and the threads it starts from now on; where the system does not count
// them, those of the time stamp counter, which runs at one rate whatever the core does, times CPU
// seconds.
class Cycles {
  public:
    Cycles() {
        perf_event_attr attr{};
        attr.type = PERF_TYPE_HARDWARE;
        attr.size = sizeof attr;
        attr.config = PERF_COUNT_HW_CPU_CYCLES;
        attr.inherit = 1;
        attr.exclude_kernel = 1;
        counter_ = int(syscall(SYS_perf_event_open, &attr, 0, -1, -1, 0));
        if (counter_ >= 0) return;
        const auto start = std::chrono::steady_clock::now();
        const std::uint64_t first = __rdtsc();
        while (std::chrono::steady_clock::now() - start < std::chrono::milliseconds(100)) {
        }
        rate_ = double(__rdtsc() - first) / 0.1;
    }
    ~Cycles() {
        if (counter_ >= 0) close(counter_);
    }
    Cycles(const Cycles&) = delete;
    Cycles& operator=(const Cycles&) = delete;

    const char* source() const {
        return counter_ >= 0 ? "core cycles, counted"
                             : "CPU seconds x time stamp counter: no cycle counter here";
    }
    double now() const {
        std::uint64_t count = 0;
        return counter_ >= 0 && read(counter_, &count, sizeof count) == sizeof count ? double(count)
                                                                                     : 0;
    }
    // Of a run that took so many CPU seconds.
    double since(double before, double cpu_s) const {
        return counter_ >= 0 ? now() - before : cpu_s * rate_;
    }

  private:
    int counter_ = -1;
    double rate_ = 0;
};

struct Setting {
    std::string samples;
    int locations = 128, threads = 2;
};

struct Measured {
    RunResult result;
    double locations = 0, candidates = 0, projected = 0, bytes = 0, segment_cpu_s = 0,
           segment_wall_s = 0, cycles = 0;
    double per_cpu_s() const { return locations / result.cpu_s; }
};

std::uint64_t items(const StageReport& stage, const char* name) {
    const auto found = stage.items.find(name);
    return found == stage.items.end() ? 0 : found->second;
}

// What a stage hands on: positions and pixel; offsets; a surface a candidate; decision and range;
// colour and validity.
double bytes_handed_on(const StageReport& stage) {
    const double locations = double(items(stage, "locations")),
                 candidates = double(items(stage, "candidates"));
    if (stage.type == "output-locations") return 12 * locations;
    if (stage.type == "reproject") return 8 * locations + 12 * candidates;
    if (stage.type == "same-surface-cluster") return 2 * locations + 2 * candidates;
    if (stage.type == "coverage") return 5 * locations;
    if (stage.type == "accumulate") return 0;
    return 17 * locations;
}

Measured measure(const Setting& set, const std::string& folder, const Cycles& cycles) {
    const Graph graph = graph_of("graphs/tlfr.json",
                                 {"samples=" + set.samples, fmt::format("locations={}", set.locations),
                                  "out=" + folder + "/out.exr"});
    const double before = cycles.now();
    Measured m;
    m.result = run(graph, set.threads);
    const double all_cycles = cycles.since(before, m.result.cpu_s);
    const SegmentReport& segment = m.result.segments.at(0);
    for (const StageReport& stage : segment.stages) {
        m.candidates += double(items(stage, "candidates"));
        m.projected += double(items(stage, "projected"));
        m.bytes += bytes_handed_on(stage);
        m.segment_cpu_s += stage.cpu_s;
    }
    m.bytes += 56 * m.projected;
    m.locations = double(items(segment.stages.at(0), "locations"));
    m.segment_wall_s = segment.wall_s;
    m.cycles = all_cycles * m.segment_cpu_s / m.result.cpu_s;
    return m;
}

// The run whose `value` is the median of `repeat`.
template <class Value>
Measured median(const Setting& set, int repeat, const Cycles& cycles, Value&& value) {
    const Scratch folder;
    std::vector<Measured> runs;
    for (int i = 0; i < repeat; ++i) runs.push_back(measure(set, folder.path, cycles));
    std::sort(runs.begin(), runs.end(),
              [&](const Measured& a, const Measured& b) { return value(a) < value(b); });
    return std::move(runs[runs.size() / 2]);
}

void print_account(const std::vector<std::string>& files, Setting set, int repeat,
                   const Cycles& cycles) {
    fmt::print("{} locations a pixel, {} threads, median of {}; cycles: {}\n", set.locations,
               set.threads, repeat, cycles.source());
    fmt::print("{:24} {:>6} {:>12} {:>8} {:>8} {:>8} {:>10} {:>8}\n", "", "spp", "locations/s",
               "ns", "cycles", "bytes", "candidates", "x floor");
    for (const std::string& file : files) {
        set.samples = file;
        const Measured m =
            median(set, repeat, cycles, [](const Measured& x) { return x.per_cpu_s(); });
        const double pixels = m.locations / double(set.locations);
        double samples = 0;
        for (const StageReport& node : m.result.nodes)
            if (node.type == "read-samples") samples = double(items(node, "samples"));
        const double spp = samples / pixels, ns = m.segment_cpu_s * 1e9 / m.locations,
                     floor = 30 + 4.3 * (std::max(spp, 1.0) - 1);
        const fs::path path(file);
        fmt::print("{:24} {:6.2f} {:12.0f} {:8.1f} {:8.0f} {:8.0f} {:10.1f} {:8.2f}\n",
                   (path.parent_path().filename() / path.stem()).string(), spp, m.per_cpu_s(), ns,
                   m.cycles / m.locations, m.bytes / m.locations, m.candidates / m.locations,
                   ns / floor);
        print_nodes(m.result, m.locations);
    }
}

std::string made(const fs::path& folder, int width, int height, int spp) {
    const std::string path = folder / fmt::format("{}x{}x{}.npz", width, height, spp);
    PlainContext ctx;
    AnalyticOptions options;
    options.width = width;
    options.height = height;
    options.spp = spp;
    if (!fs::exists(path)) write_npz(analytic_samples("garden", options, ctx), path, false, ctx);
    return path;
}

void print_scaling(int repeat, const Cycles& cycles) {
    const Scratch folder;
    const auto add = [&](Series& to, const std::string& label, const std::string& samples,
                         int locations) {
        const Measured m = median({samples, locations, 2}, repeat, cycles,
                                  [](const Measured& x) { return x.result.cpu_s; });
        to.add(label, m.result.cpu_s, m.segment_cpu_s);
    };
    fmt::print("built-in scene 'garden', median of {}, CPU seconds; linear or better: 1 or below\n",
               repeat);
    Series pixels{"pixels"}, spp{"spp"}, locations{"locations"};
    for (int scale : {1, 2, 4})
        add(pixels, fmt::format("{}x{}", 160 * scale, 90 * scale),
            made(folder.path, 160 * scale, 90 * scale, 4), 64);
    for (int n : {1, 4, 16}) add(spp, std::to_string(n), made(folder.path, 320, 180, n), 64);
    for (int n : {32, 128, 512})
        add(locations, std::to_string(n), made(folder.path, 320, 180, 4), n);
    const auto wall = [&](int threads) {
        const std::string samples = made(folder.path, 640, 360, 4);
        return median({samples, 128, threads}, std::max(repeat, 5), cycles,
                      [](const Measured& m) { return m.segment_wall_s; })
            .segment_wall_s;
    };
    const double one = wall(1), two = wall(2);
    fmt::print(
        "threads 1 to 2, wall seconds of the reconstruction: {:.3f} to {:.3f}, {:.2f} times as "
        "fast\n",
        one, two, one / two);
}

}  // namespace

int main(int argc, char** argv) try {
    std::vector<std::string> folders;
    Setting set;
    int repeat = 3;
    bool scaling = false;
    for (int i = 1; i < argc; ++i) {
        const std::string key = argv[i];
        const auto number = [&] { return std::max(1, i + 1 < argc ? std::atoi(argv[++i]) : 0); };
        if (key == "--scaling")
            scaling = true;
        else if (key == "--locations")
            set.locations = number();
        else if (key == "--threads")
            set.threads = number();
        else if (key == "--repeat")
            repeat = number();
        else if (!key.starts_with("--"))
            folders.push_back(key);
        else
            return fmt::print(stderr, "unknown option {}\n", key), 2;
    }
    const Cycles cycles;
    if (scaling) return print_scaling(repeat, cycles), 0;
    if (folders.empty()) folders.push_back(std::string(WEFT_SOURCE_DIR) + "/../shared/data");
    std::vector<std::string> files;
    for (const std::string& folder : folders)
        for (const auto& entry : fs::recursive_directory_iterator(folder))
            if (entry.path().extension() == ".npz" &&
                entry.path().filename().string().starts_with("s"))
                files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    if (files.empty())
        return fmt::print(stderr, "bench_tlfr: no s*.npz below {}\n", folders.front()), 1;
    print_account(files, set, repeat, cycles);
} catch (const std::exception& e) {
    fmt::print(stderr, "bench_tlfr: {}\n", e.what());
    return 1;
}
