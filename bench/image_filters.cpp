// How many pixels a second does each filter from picture to picture make, on one thread?
// Input: noise, 640 x 360, R G B with variances; features as pixel-features gives them (normal,
// albedo, position, with variances). Each node as its defaults are. Prints the median of 5 runs in
// Mpix a CPU second, with their spread, for each instruction set.
#include <fmt/format.h>

#include <algorithm>

#include "bench/cpu_time.h"
#include "image/image.h"
#include "runtime/isa.h"
#include "runtime/registry.h"
#include "samples/random.h"

using namespace weft;

namespace {

constexpr int width = 640, height = 360;

Image noise(std::vector<std::string> names, float scale, size_t seed) {
    Image image(width, height, std::move(names));
    size_t i = seed << 32;
    for (float& v : image.pixels()) v = scale * unit_float(mix(i++));
    return image;
}

}  // namespace

int main() {
    const std::vector<std::string> rgb = {"R", "G", "B"};
    std::vector<std::string> layers;
    for (const char* layer : {"normal", "albedo", "position"})
        for (const char axis : {'x', 'y', 'z'}) layers.push_back(fmt::format("{}.{}", layer, axis));
    Image image = noise(rgb, 1, 1), variance = noise(rgb, 0.1f, 2), features = noise(layers, 1, 3),
          features_variance = noise(layers, 0.1f, 4);
    const std::pair<const char*, Image*> links[] = {{"image", &image},
                                                    {"variance", &variance},
                                                    {"features", &features},
                                                    {"features-variance", &features_variance}};
    for (const Isa isa : {Isa::v2, Isa::v3, Isa::v4}) {
        if (isa > best_isa()) continue;
        pin_isa(isa);
        for (const char* type : {"gaussian-filter", "bilateral-filter-image", "non-local-means",
                                 "cross-bilateral-image", "a-trous"}) {
            const NodeType* node = Registry::instance().type(type);
            Inputs in;
            for (const auto& [port, object] : links)
                if (node->decl().find_input(port) >= 0 &&
                    (object != &variance || type != std::string_view("bilateral-filter-image")))
                    in.slots.push_back({port, &type_info<Image>(), object, {object}});
            const auto instance = node->make(std::vector<Json>(node->decl().params.size()));
            std::vector<double> runs;
            for (int run = 0; run < 5; ++run) {
                Image result;
                Outputs out;
                out.slots.push_back({"image", &type_info<Image>(), &result, {}});
                PlainContext ctx;
                const double start = cpu_s();
                instance->run(in, out, ctx);
                runs.push_back(double(width) * height / (cpu_s() - start) * 1e-6);
            }
            std::sort(runs.begin(), runs.end());
            fmt::print("{}  {:24}{:8.2f} Mpix/s  ({:.2f} to {:.2f})\n", name_of(isa), type, runs[2],
                       runs[0], runs[4]);
        }
    }
}
