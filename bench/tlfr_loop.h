// The kernels of light-field reconstruction in one hand-written loop, as benchmarks call them: what a graph
// of separate nodes is measured against. One thread.
#pragma once
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <vector>

#include "light-field/build_hierarchy_kernel.h"
#include "light-field/kernels.h"
#include "light-field/points.h"

namespace weft::light_field {

inline double cpu_ns() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) * 1e9 + double(now.tv_nsec);
}

struct LoopOptions {
    std::uint32_t locations = 128, per_slice = 1;
    int block = 32, sets = 1;
    float exponent = 2, radius = 1, retry = 2, filter_radius = 1;
    SameSurface test;
    bool stages = true;  // time each kernel
};

enum Kernel { placing, projecting, gathering, clustering, covering, filtering, retrying, summing, kernels };
inline constexpr std::array<const char*, kernels> kernel_names{"locations", "project", "gather", "cluster", "cover", "filter", "retry", "sum"};

struct Loop {
    const Hierarchy& h;
    const LoopOptions& o;
    Loop(const Hierarchy& hierarchy, const LoopOptions& options) : h(hierarchy), o(options) {}
    std::vector<float> sums;  // r g b weight a pixel
    std::array<double, kernels> ns{};
    std::uint64_t locations = 0, candidates = 0, slow = 0, retried = 0, empty = 0, projected = 0;

    Locations at, again;
    Block block;
    Projection projection;
    Candidates candidates_, candidates2;
    Surfaces surfaces, surfaces2;
    Visibility visibility, visibility2;
    Colors colors, colors2;
    ClusterScratch cluster_scratch;
    CoverageScratch cover_scratch;
    FilterScratch filter_scratch;

    template <class Work>
    void timed(Kernel kernel, Work&& work) {
        if (!o.stages) return work();
        const auto start = std::chrono::steady_clock::now();
        work();
        ns[kernel] += std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count();
    }

    void place(int x0, int y0, int x1, int y1, int set, std::uint32_t slice, const LensPoint& p) {
        at.x.clear();
        at.y.clear();
        at.own_pixels.clear();
        at.shared = true;
        at.u.assign(1, p.u);
        at.v.assign(1, p.v);
        at.t.assign(1, p.t);
        at.x0 = x0, at.y0 = y0, at.x1 = x1, at.y1 = y1;
        for (std::uint32_t j = 0; j < o.per_slice; ++j) {
            const auto pattern = pixel_pattern(slice * o.per_slice + j);
            for (int y = y0; y < y1; ++y)
                for (int x = x0; x < x1; ++x) {
                    if (o.sets > 1 && ((x + 2 * y) % o.sets + o.sets) % o.sets != set) continue;
                    const std::uint64_t key = pixel_scramble(1, x, y);
                    at.x.push_back(float(x) + unit_float(pattern[0] ^ std::uint32_t(key)));
                    at.y.push_back(float(y) + unit_float(pattern[1] ^ std::uint32_t(key >> 32)));
                    at.own_pixels.push_back(std::uint32_t(y * h.width + x));
                }
        }
        at.pixels = at.own_pixels;
    }

    void batch() {
        const size_t n = at.size();
        candidates_.pixels = surfaces.pixels = visibility.pixels = colors.pixels = at.pixels;
        timed(projecting, [&] {
            if (!block.covers(h, at.x0, at.y0, at.x1, at.y1, o.retry * o.radius * h.radius))
                collect(h, at.x0, at.y0, at.x1, at.y1, o.retry * o.radius * h.radius, block);
            WEFT_PICK(project)(h, block, at.u[0], at.v[0], at.t[0], false, projection);
        });
        projected += projection.samples;
        timed(gathering, [&] { WEFT_PICK(gather)(projection, at, o.radius * h.radius, candidates_); });
        timed(clustering, [&] { WEFT_PICK(cluster)(candidates_, o.test, cluster_scratch, surfaces); });
        timed(covering, [&] { WEFT_PICK(cover)(candidates_, surfaces, o.radius * h.radius, visibility); });
        const Tent tent{o.filter_radius * o.radius * h.radius, o.exponent};
        timed(filtering, [&] { WEFT_PICK(filter)(candidates_, surfaces, visibility, tent, filter_scratch, colors); });
        for (size_t l = 0; l < n; ++l) slow += surfaces.count_of[l] > 1;
        timed(retrying, [&] {
            again.x.clear();
            again.y.clear();
            again.own_pixels.clear();
            again.own_parents.clear();
            for (size_t l = 0; l < n; ++l)
                if (visibility.decision[l] == Decision::undecided) {
                    again.x.push_back(at.x[l]);
                    again.y.push_back(at.y[l]);
                    again.own_pixels.push_back(at.pixels[l]);
                    again.own_parents.push_back(std::uint32_t(l));
                }
            again.u = at.u;
            again.v = at.v;
            again.t = at.t;
            again.shared = true;
            again.pixels = again.own_pixels;
            candidates2.pixels = surfaces2.pixels = visibility2.pixels = colors2.pixels = again.pixels;
            if (again.size() == 0) return;
            WEFT_PICK(gather)(projection, again, o.retry * o.radius * h.radius, candidates2);
            WEFT_PICK(cluster)(candidates2, o.test, cluster_scratch, surfaces2);
            WEFT_PICK(cover_finally)(candidates2, surfaces2, o.radius * h.radius, cover_scratch, visibility2);
            WEFT_PICK(filter)(candidates2, surfaces2, visibility2, tent, filter_scratch, colors2);
            for (size_t l = 0; l < again.size(); ++l) {
                const size_t to = again.own_parents[l];
                std::copy_n(&colors2.rgba[4 * l], 4, &colors.rgba[4 * to]);
                colors.valid[to] = colors2.valid[l];
            }
        });
        timed(summing, [&] {
            for (size_t l = 0; l < n; ++l) {
                if (!colors.valid[l]) {
                    ++empty;
                    continue;
                }
                float* to = &sums[4 * size_t(at.pixels[l])];
                for (int c = 0; c < 3; ++c) to[c] += colors.rgba[4 * l + size_t(c)];
                to[3] += 1;
            }
        });
        locations += n;
        candidates += candidates_.offset[n];
        retried += again.size();
    }

    void run() {
        sums.assign(4 * size_t(h.width) * size_t(h.height), 0);
        const std::uint32_t slices = o.locations / o.per_slice;
        std::vector<std::vector<LensPoint>> points(static_cast<size_t>(o.sets));
        for (int set = 0; set < o.sets; ++set)
            for (std::uint32_t i = 0; i < slices; ++i)
                points[size_t(set)].push_back(lens_point(7 + 1000 * std::uint64_t(set), i, slices, h.lens));
        for (int y = 0; y < h.height; y += o.block)
            for (int x = 0; x < h.width; x += o.block)
                for (std::uint32_t i = 0; i < slices; ++i)
                    for (int set = 0; set < o.sets; ++set) {
                        timed(placing, [&] {
                            place(x, y, std::min(x + o.block, h.width), std::min(y + o.block, h.height), set, i,
                                  points[size_t(set)][i]);
                        });
                        batch();
                    }
    }
};

}  // namespace weft::light_field
