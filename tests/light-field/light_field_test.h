// What tests of light-field reconstruction share: buffers of random samples, and running a graph's text.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "image/picture_file.h"
#include "runtime/registry.h"
#include "runtime/run.h"
#include "samples/samples.h"
#include "samples/write_npz.h"
#include "tests/instruction_sets.h"
#include "tests/graph_run.h"

namespace weft {

enum class Kind_of { still_pinhole, defocused, moving, moving_in_depth };

// `spp` samples a pixel, of two layers and some at infinity, in random motion.
inline Samples random_samples(int width, int height, int spp, Kind_of kind, unsigned seed = 1) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0, 1);
    Samples s;
    s.width = width;
    s.height = height;
    s.spp = spp;
    if (kind != Kind_of::still_pinhole) s.lens = Lens{-20, 4};
    std::vector<float> xy, uv, t, z, motion, rgb;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int i = 0; i < spp; ++i) {
                xy.insert(xy.end(), {float(x) + unit(random), float(y) + unit(random)});
                const float r = std::sqrt(unit(random)), a = 6.2831853f * unit(random);
                uv.insert(uv.end(), {r * std::cos(a), r * std::sin(a)});
                t.push_back(unit(random));
                const float choice = unit(random);
                const bool far = choice > 0.9f;
                const float depth = far ? INFINITY : choice > 0.5f ? 8 + unit(random) : 3 + 0.5f * unit(random);
                z.push_back(depth);
                const bool moves = kind == Kind_of::moving || kind == Kind_of::moving_in_depth;
                const float w = far ? 1 : depth;
                float vw = 0;
                if (kind == Kind_of::moving_in_depth && !far) vw = depth * (choice > 0.45f && choice < 0.5f ? 2.5f : 0.4f) * (unit(random) - 0.5f);
                motion.insert(motion.end(), {moves ? w * 6 * (unit(random) - 0.3f) : 0, moves ? w * 4 * (unit(random) - 0.5f) : 0, vw});
                for (int c = 0; c < 3; ++c) rgb.push_back(unit(random));
            }
    s.set_size(z.size());
    s.add("xy", 2, xy);
    s.add("z", 1, z);
    s.add("rgb", 3, rgb);
    if (kind != Kind_of::still_pinhole) s.add("uv", 2, uv);
    if (kind == Kind_of::moving || kind == Kind_of::moving_in_depth) {
        s.add("t", 1, t);
        s.add("motion", 3, motion);
    }
    return s;
}

// The name of a file of these samples.
inline std::string saved(const TestFolder& folder, const Samples& samples) {
    PlainContext ctx;
    const std::string path = folder / "samples.npz";
    write_npz(samples, path, false, ctx);
    return path;
}

// A graph that reconstructs `file`; `locations` are parameters of output-locations, `picture` is the node whose
// image is written: picture or energy.
inline std::string tlfr_text(const std::string& file, const std::string& locations, const std::string& picture = "picture") {
    return R"({"weft": 1, "nodes": {
        "samples":   {"type": "read-samples", "set": {"file": ")" + file + R"("}},
        "smooth":    {"type": "smooth-radiance", "in": {"samples": "samples"}},
        "hierarchy": {"type": "build-hierarchy", "in": {"samples": "smooth"}},
        "locations": {"type": "output-locations", "in": {"hierarchy": "hierarchy"}, "set": {)" + locations + R"(}},
        "picture":   {"type": "parts/tlfr-stages.json", "in": {"hierarchy": "hierarchy", "locations": "locations"}},
        "means":     {"type": "sample-means", "in": {"locations": "locations", "samples": "samples"}},
        "energy":    {"type": "preserve-energy", "in": {"image": "picture", "means": "means"}},
        "write":     {"type": "write-image", "in": {"image": ")" + picture + R"("}, "set": {"file": "OUT", "depth": "float"}}}})";
}

}  // namespace weft
