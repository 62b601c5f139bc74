// The kernels of light-field reconstruction: plain functions over batches, built for each instruction
// set (WEFT_PICK(gather)(...), runtime/isa.h). What each must give is said by its scalar form in
// reference_kernels.h; tests hold the two together.
// Cost: no allocation once buffers have grown.  Threads: each call touches its own outputs only.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "light-field/hierarchy.h"
#include "light-field/streams.h"
#include "runtime/isa.h"

namespace weft::light_field {

// The groups that can be seen from a block of pixels at some (u, v, t), with their bounds side by
// side, and the memory that projecting them takes.
struct Block {
    const Hierarchy* hierarchy = nullptr;
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    float reach = 0;
    size_t groups = 0;
    std::vector<std::uint32_t> group;  // ascending; this and the bounds are filled up to whole vectors
    std::vector<float> slope, velocity_x, velocity_y, x_low, x_high, y_low, y_high;
    // Of the bytes of Projection::traits: lowest value and step.
    float slope_low = 0, slope_step = 0, velocity_x_low = 0, velocity_y_low = 0, velocity_step = 0;

    std::vector<std::uint32_t> seen;  // groups at hand for one slice
    std::vector<float> x, y;
    std::vector<std::uint32_t> cell, sample, traits;

    bool covers(const Hierarchy& h, int bx0, int by0, int bx1, int by1, float needed) const {
        return hierarchy == &h && x0 == bx0 && y0 == by0 && x1 == bx1 && y1 == by1 && reach >= needed;
    }
};
// Lays the grid of a projection over what is within `reach` of pixels [x0, x1) x [y0, y1), with cells for searches
// within some `radius`.
void lay_grid(const Hierarchy& hierarchy, int x0, int y0, int x1, int y1, float reach, float radius, Projection& out);
void collect(const Hierarchy& hierarchy, int x0, int y0, int x1, int y1, float reach, Block& block);

// Same-surface test (reference_kernels.h has it for one pair): trajectories of two samples conflict
// where they cross within `box` of the location's (u, v), half of it in t, by more than `tolerance`.
struct SameSurface {
    float box = 0.0884f;     // lens units; of time half of it
    float tolerance = 0.1f;  // px
};

struct ClusterScratch {
    std::vector<float> depth, found, sorted;
    std::vector<std::uint32_t> rank, at;
};

// How many samples a surface that covers all of a disk has in it.
inline float samples_in(float radius, const Hierarchy& h) { return float(h.mean_spp) * 3.14159265f * radius * radius; }

// A surface is too thin for its samples to surround what it covers if fewer than these are there of what one would
// have that covers all around: of the disk of R two fifths (a straight edge through the location leaves half), of that
// of 2 R a quarter (what an edge 0.8 R away leaves, from where nothing is within R but a sliver). What part of the location a thin one covers is then the sum of its samples'
// weights, against that of a surface without gaps, under a squared tent, whose integral is a sixth of the disk's area.
inline constexpr float thin_near = 0.4f, thin_around = 0.25f, squared_tent_mean = 1.0f / 6;

// Of each of some locations, the cells of a projection's grid near it: the first, how many side by
// side, how many rows of them.
struct Reach {
    std::uint32_t *first, *across, *rows;
};

struct CoverageScratch {
    std::vector<float> x, y, left_x, left_y, right_x, right_y;
    std::vector<std::uint32_t> sizes;  // of each surface, and its weight
    std::vector<float> weights;
    Visibility visibility;
};

struct Tent {
    float radius = 1;    // px
    float exponent = 1;  // weight (1 - d / radius)^exponent
};
struct FilterScratch {
    std::vector<float> dx, dy, weight;
    std::vector<std::uint32_t> sample;
};

// What see-visible does (reproject, same-surface-cluster, coverage and filter-visible together); and, where
// `nearest` is given, which sample each location sees: of the surface that it sees, the one that lands nearest (of
// several surfaces, one by location_number()), 0xffffffff where that is undecided.
struct SeeSettings {
    float radius = 1;        // px, of the search
    float cover_radius = 1;  // px: R, by which surfaces surround a location
    SameSurface test;
    Tent tent;               // of power 1, 2 or 4; ends within the search
    bool final = false;      // settle all, as coverage's final pass does
};
struct SeeScratch {
    std::vector<std::uint32_t> cell, across, rows;  // Reach
    std::vector<std::uint32_t> open;    // locations that are not settled at first sight
    std::vector<std::uint8_t> colored;  // whether they have a colour, should they have one surface
    // Candidates of one location: as they are found, and nearest first.
    std::vector<float> found_x, found_y, found_depth, found_slope, found_velocity_x, found_velocity_y;
    std::vector<float> x, y, depth, slope, velocity_x, velocity_y;
    std::vector<std::uint32_t> found, rank, sample;
    std::vector<float> weight;  // of those that are filtered
    std::vector<std::uint32_t> seen;
    CoverageScratch coverage;
    Visibility visibility;

    void grow(size_t n) {
        if (x.size() >= n) return;
        for (auto* values : {&found_x, &found_y, &found_depth, &found_slope, &found_velocity_x, &found_velocity_y, &x, &y, &depth, &slope, &velocity_x, &velocity_y, &weight,
                             &coverage.x, &coverage.y})
            values->resize(2 * n);
        for (auto* values : {&found, &rank, &sample, &seen}) values->resize(2 * n);
    }
};

// Cells of a projection's grid, some of which are asked for.
struct WantedCells {
    std::vector<std::uint8_t> cells;  // not 0 where one is, as numbered by Projection::start; seven more may be read
    std::vector<std::int32_t> sums;   // how many blocks of cells before are asked for (project_kernel.cpp)
};

// project_depths: onto a grid that is there already (lay_grid), samples of cells that are wanted alone;
// Projection::Entry::traits is 1/w.
#define WEFT_LIGHT_FIELD_KERNELS(isa)                                                                       \
    namespace isa {                                                                                         \
    void project(const Hierarchy& hierarchy, Block& block, float u, float v, float t, bool colors,          \
                 Projection& out);                                                                          \
    void project_depths(const Hierarchy& hierarchy, Block& block, WantedCells& wanted, float u, float v,    \
                        float t, Projection& out);                                                          \
    void gather(const Projection& projection, const Locations& locations, float radius, Candidates& out);   \
    void gather_each(const Hierarchy& hierarchy, Block& block, const Locations& locations, float radius,    \
                     Candidates& out);                                                                      \
    void cluster(const Candidates& candidates, const SameSurface& test, ClusterScratch& scratch,            \
                 Surfaces& out);                                                                            \
    void cover(const Candidates& candidates, const Surfaces& surfaces, float radius, Visibility& out);      \
    void cover_finally(const Candidates& candidates, const Surfaces& surfaces, float radius,                \
                       CoverageScratch& scratch, Visibility& out);                                          \
    void filter(const Candidates& candidates, const Surfaces& surfaces, const Visibility& visibility,       \
                const Tent& tent, FilterScratch& scratch, Colors& out);                                     \
    void see(const Projection& projection, const Locations& locations, const SeeSettings& settings,         \
             SeeScratch& scratch, Colors& out, std::uint32_t* nearest);                                                           \
    }
WEFT_LIGHT_FIELD_KERNELS(v2)
WEFT_LIGHT_FIELD_KERNELS(v3)
WEFT_LIGHT_FIELD_KERNELS(v4)

}  // namespace weft::light_field
