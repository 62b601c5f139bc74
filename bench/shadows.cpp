// What do soft shadows add to light-field reconstruction, stage by stage, and how does it grow?
//   bench_shadows [SCENE...] [--threads N] [--repeat N]
// Renders each scene (by default graphs/scenes/shadow-lens.json) once, 320 x 180 pixels of 4
// samples with their shadow rays, and runs graphs/parts/tlfr.json and tlfr-7d.json on what was
// stored, at 128 locations a pixel; prints CPU nanoseconds a location of the whole runs, and of
// each node and stage of the latter. Then how CPU time grows with pixels, samples and locations.
#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "bench/graph_runs.h"

namespace {

using namespace weft;
namespace fs = std::filesystem;

constexpr int usual_spp = 4, usual_locations = 128;

void write(const std::string& path, const std::string& text) {
    std::ofstream(path) << text;
}

// Scenes' stored samples, and graphs that reconstruct them.
class Runs {
  public:
    Runs(int threads, int repeat) : threads_(threads), repeat_(repeat) {
        const auto part = [](const char* name) {
            return std::string(WEFT_SOURCE_DIR) + "/graphs/parts/" + name;
        };
        for (const char* name : {"tlfr.json", "tlfr-7d.json"})
            write(graph(name),
                  R"({"weft": 1,
                "parameters": {"samples": {"type": "file"}, "locations": {"type": "integer"}, "out": {"type": "file"}},
                "nodes": {
                    "samples": {"type": "read-samples", "set": {"file": "$samples", "channels": ["*"]}},
                    "picture": {"type": ")" +
                      part(name) +
                      R"(", "in": {"samples": "samples"}, "set": {"locations": "$locations"}},
                    "write":   {"type": "write-image", "in": {"image": "picture"}, "set": {"file": "$out", "depth": "float"}}}})");
        write(graph("render"), R"({"weft": 1,
            "parameters": {"scene": {"type": "file"}, "width": {"type": "integer"}, "height": {"type": "integer"},
                           "spp": {"type": "integer"}, "out": {"type": "file"}},
            "nodes": {
                "scene":  {"type": "read-scene", "set": {"file": "$scene"}},
                "render": {"type": "render-samples", "in": {"scene": "scene"},
                           "set": {"width": "$width", "height": "$height", "spp": "$spp",
                                   "channels": ["basic", "normal", "albedo", "geometric_normal", "direct", "direct_unshadowed",
                                                "light_index", "light_point", "shadow_hit", "shadow_normal", "shadow_motion"]}},
                "write":  {"type": "write-samples", "in": {"samples": "render"}, "set": {"file": "$out"}}}})");
    }

    std::string samples(const std::string& scene, int width, int height, int spp) {
        const std::string path =
            folder_.path +
            fmt::format("/{}-{}x{}x{}.npz", fs::path(scene).stem().string(), width, height, spp);
        if (!fs::exists(path))
            weft::run(graph_of(graph("render"), {"scene=" + scene, fmt::format("width={}", width),
                                                 fmt::format("height={}", height),
                                                 fmt::format("spp={}", spp), "out=" + path}),
                      threads_);
        return path;
    }

    // Of each graph the run of median CPU time; one after the other by turns, as the machine's own
    // speed drifts.
    std::vector<RunResult> of(const std::vector<const char*>& names, const std::string& samples,
                              int locations) const {
        std::vector<std::vector<RunResult>> runs(names.size());
        for (int i = 0; i < repeat_; ++i)
            for (size_t k = 0; k < names.size(); ++k)
                runs[k].push_back(weft::run(
                    graph_of(graph(names[k]),
                             {"samples=" + samples, fmt::format("locations={}", locations),
                              "out=" + folder_.path + "/out.exr"}),
                    threads_));
        std::vector<RunResult> medians;
        for (auto& each : runs) {
            std::sort(each.begin(), each.end(),
                      [](const RunResult& a, const RunResult& b) { return a.cpu_s < b.cpu_s; });
            medians.push_back(std::move(each[each.size() / 2]));
        }
        return medians;
    }

  private:
    std::string graph(const std::string& name) const {
        return folder_.path + "/" + fs::path(name).stem().string() + ".json";
    }

    Scratch folder_;
    int threads_, repeat_;
};

void print_account(Runs& runs, const std::string& scene) {
    const std::string samples = runs.samples(scene, 320, 180, usual_spp);
    const auto both = runs.of({"tlfr.json", "tlfr-7d.json"}, samples, usual_locations);
    const RunResult &five = both[0], &seven = both[1];
    const double locations = 320.0 * 180 * usual_locations;
    fmt::print("{}: tlfr.json {:.0f} ns a location, tlfr-7d.json {:.0f} ns, {:.2f} times as much\n",
               scene, five.cpu_s * 1e9 / locations, seven.cpu_s * 1e9 / locations,
               seven.cpu_s / five.cpu_s);
    print_nodes(seven, locations);
}

void print_scaling(Runs& runs, const std::string& scene) {
    const auto add = [&](Series& to, const std::string& label, const std::string& samples,
                         int locations) {
        const RunResult result = std::move(runs.of({"tlfr-7d.json"}, samples, locations)[0]);
        double stages = 0;
        for (const SegmentReport& segment : result.segments)
            for (const StageReport& stage : segment.stages) stages += stage.cpu_s;
        to.add(label, result.cpu_s, stages);
    };
    fmt::print("{}, tlfr-7d.json, CPU seconds; linear or better: 1 or below\n", scene);
    Series pixels{"pixels"}, spp{"spp"}, locations{"locations"};
    for (const int scale : {1, 2, 4})
        add(pixels, fmt::format("{}x{}", 160 * scale, 90 * scale),
            runs.samples(scene, 160 * scale, 90 * scale, usual_spp), 64);
    for (const int n : {1, 4, 16})
        add(spp, std::to_string(n), runs.samples(scene, 320, 180, n), 64);
    for (const int n : {32, 128, 512})
        add(locations, std::to_string(n), runs.samples(scene, 320, 180, usual_spp), n);
}

}  // namespace

int main(int argc, char** argv) try {
    std::vector<std::string> scenes;
    int threads = 1, repeat = 3;
    for (int i = 1; i < argc; ++i) {
        const std::string key = argv[i];
        const auto number = [&] { return std::max(1, i + 1 < argc ? std::atoi(argv[++i]) : 0); };
        if (key == "--threads")
            threads = number();
        else if (key == "--repeat")
            repeat = number();
        else if (!key.starts_with("--"))
            scenes.push_back(key);
        else
            return fmt::print(stderr, "unknown option {}\n", key), 2;
    }
    if (scenes.empty())
        scenes.push_back(std::string(WEFT_SOURCE_DIR) + "/graphs/scenes/shadow-lens.json");
    Runs runs(threads, repeat);
    for (const std::string& scene : scenes) print_account(runs, scene);
    print_scaling(runs, scenes.front());
} catch (const std::exception& e) {
    fmt::print(stderr, "bench_shadows: {}\n", e.what());
    return 1;
}
