// What do the stages of a stream cost as separate nodes, against the same kernels in one hand-written loop?
//   bench_tlfr_segment SAMPLES.npz [--locations N] [--repeat N]
// Runs the loop and the segment of graphs/tlfr.json in turn, on one thread and the same samples (not
// smoothed), and prints CPU nanoseconds a location of each: median of --repeat runs (7) with its range.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "bench/tlfr_loop.h"
#include "graph/graph.h"
#include "runtime/registry.h"
#include "runtime/run.h"
#include "samples/sample_file.h"

namespace {

using namespace weft;

// CPU nanoseconds a location of the segment: of the whole run, without its value nodes.
double segment_ns(const std::string& file, std::uint32_t per_pixel) {
    LoadOptions load;
    load.for_run = true;
    load.overrides.set = {"samples=" + file, fmt::format("locations={}", per_pixel), "out=/dev/shm/bench_tlfr_segment.exr"};
    load.overrides.bypass = {"smooth"};
    const Loaded loaded = load_graph(std::string(WEFT_SOURCE_DIR) + "/graphs/tlfr.json", Registry::instance(), load);
    if (!loaded.ok()) throw Error(to_text(loaded.findings.at(0)));
    Monitor monitor;
    const RunResult result = run_plan(make_plan(loaded.graph), *make_serial_executor(), monitor);
    if (!result.ok()) throw Error(result.errors.at(0).message);
    const SegmentReport& segment = result.segments.at(0);
    double cpu_s = result.cpu_s;
    for (const StageReport& node : result.nodes) cpu_s -= node.cpu_s;
    return cpu_s * 1e9 / double(segment.stages.at(0).items.at("locations"));
}

struct Median {
    std::vector<double> of;
    double value() {
        std::sort(of.begin(), of.end());
        return of[of.size() / 2];
    }
    std::string text() { return fmt::format("{:.1f} ns/location ({:.1f} to {:.1f})", value(), of.front(), of.back()); }
};

}  // namespace

int main(int argc, char** argv) try {
    std::string file;
    light_field::LoopOptions options;
    options.stages = false;
    int repeat = 7;
    for (int i = 1; i < argc; ++i) {
        const std::string key = argv[i];
        if (!key.starts_with("--")) file = key;
        else if (key == "--locations" && i + 1 < argc) options.locations = std::uint32_t(std::atoi(argv[++i]));
        else if (key == "--repeat" && i + 1 < argc) repeat = std::max(1, std::atoi(argv[++i]));
        else return fmt::print(stderr, "unknown option {}\n", key), 2;
    }
    if (file.empty()) return fmt::print(stderr, "usage: bench_tlfr_segment SAMPLES.npz [--locations N] [--repeat N]\n"), 2;
    PlainContext ctx;
    const Hierarchy h = light_field::build_hierarchy(read_sample_file(map_file(file), ReadOptions(), ctx),
                                                     light_field::Arrangement::layers, 1, ctx);
    Median loop, segment;
    for (int i = 0; i < repeat; ++i) {
        light_field::Loop run(h, options);
        const double start = light_field::cpu_ns();
        run.run();
        loop.of.push_back((light_field::cpu_ns() - start) / double(run.locations));
        segment.of.push_back(segment_ns(file, options.locations));
    }
    fmt::print("loop    {}\nsegment {}\nsegment / loop {:.3f}\n", loop.text(), segment.text(), segment.value() / loop.value());
} catch (const std::exception& e) {
    fmt::print(stderr, "bench_tlfr_segment: {}\n", e.what());
    return 1;
}
