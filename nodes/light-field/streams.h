// The streams of light-field reconstruction, in the order in which stages hand them on. A location is
// one point (x, y, u, v, t) whose radiance is to be reconstructed; a batch holds those of one block of
// pixels, most often at one common (u, v, t).
#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "light-field/hierarchy.h"
#include "runtime/value.h"

namespace weft {

// Where to reconstruct.
struct Locations : Batch {
    std::vector<float> x, y;     // px
    std::vector<float> u, v, t;  // lens in the unit disk, time in [0, 1]; one value each where shared
    bool shared = false;         // all records have the same (u, v, t)
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // every location lies in these pixels
    std::uint64_t number = 0;    // of the pixels' locations: what spreads them over further dimensions
    size_t together = 1;         // locations a pixel: the first of all pixels, then the second, and so on
    std::vector<float> ratio;    // R of each location over the hierarchy's; empty: by their place

    float u_of(size_t i) const { return u[shared ? 0 : i]; }
    float v_of(size_t i) const { return v[shared ? 0 : i]; }
    float t_of(size_t i) const { return t[shared ? 0 : i]; }
    void count(Items& items) const { items.add("locations", size()); }
    void describe(FieldVisitor& see) const;

    std::vector<std::uint32_t> own_pixels, own_parents;  // what the base's spans look at
};

// The samples that land on or near the batch's pixels at its common (u, v, t), in a grid of cells
// aligned to the picture: rows of cells `cell_height` high, cells `cell_width` wide. Samples of a cell
// are in ascending order, whatever block of pixels they were projected for. Each row ends with
// `padding` entries that are nowhere, so that vectors may be read past the end of a run.
struct Projection : Batch {
    static constexpr bool per_batch = true;
    static constexpr size_t padding = 16;
    struct Entry {
        float x, y;            // px, at (u, v, t)
        std::uint32_t sample;  // index in the hierarchy
        std::uint32_t traits;  // slope, velocity x, velocity y: a byte each; or 1/w, a float's bits
    };

    const Hierarchy* hierarchy = nullptr;
    float u = 0, v = 0, t = 0.5f;
    float reach = 0;  // px: all samples this near to the batch's pixels are in it
    float cell_width = 1, cell_height = 1;
    int column0 = 0, row0 = 0, columns = 0, rows = 0;  // cells: x / cell_width in [column0, column0 + columns)
    std::vector<std::uint32_t> start;                  // rows x (columns + 1): first entry of a cell
    std::vector<Entry> entries;
    float slope_step = 0, velocity_step = 0;           // of the bytes; see Candidates::spread
    std::uint32_t spread = 0;                          // of all samples: 0xffffffff: not known
    size_t samples = 0;                                // projected
    bool kept = false;                                 // from the batch before, whose (u, v, t) is the same
    bool colored = false;
    std::vector<float> rgba;                           // 4 an entry, where colored

    std::uint32_t row_start(int row) const { return start[size_t(row) * size_t(columns + 1)]; }
    void count(Items& items) const { items.add("projected", kept ? 0 : samples); }
    void describe(FieldVisitor& see) const;
};

// What a sample does at a location's (u, v, t).
struct Trajectory {
    float depth = 0;                         // camera z
    float slope_x = 0, slope_y = 0;          // px per unit of lens
    float velocity_x = 0, velocity_y = 0;    // px per shutter
};

// The samples within `radius` of each location: those of location l are [offset[l], offset[l + 1]). Arrays
// of candidates, here and in streams that follow, are at least 16 longer than needed, for whole vectors.
struct Candidates : Batch {
    const Hierarchy* hierarchy = nullptr;
    float radius = 0;                        // px, of the search
    std::vector<std::uint32_t> offset;       // size() + 1
    std::vector<float> dx, dy;               // px, sample minus location
    std::vector<std::uint32_t> sample;       // index in the hierarchy
    // Of each location, bytes that bound how much slope, velocity x and velocity y differ among its
    // candidates: no two differ by more than (byte + 1) x step. 0xffffffff: not known.
    std::vector<std::uint32_t> spread;
    float slope_step = 0, velocity_step = 0;
    // Of each location, its R over the hierarchy's; empty where R is one everywhere (local_radius.h).
    std::vector<float> ratio;
    // Of the locations.
    std::vector<float> x, y, u, v, t;
    bool shared = false;

    float u_of(size_t l) const { return u[shared ? 0 : l]; }
    float v_of(size_t l) const { return v[shared ? 0 : l]; }
    float t_of(size_t l) const { return t[shared ? 0 : l]; }
    size_t of(size_t l) const { return offset[l + 1] - offset[l]; }
    float ratio_of(size_t l) const { return ratio.empty() ? 1.0f : ratio[l]; }
    // Of candidate k of location l.
    Trajectory trajectory(size_t l, size_t k) const;
    void count(Items& items) const {
        items.add("locations", size());
        items.add("candidates", offset.empty() ? 0 : offset[size()]);
    }
    void describe(FieldVisitor& see) const;
};

// Which candidates belong to one surface: 0 is the nearest to the camera.
struct Surfaces : Batch {
    std::vector<std::uint16_t> count_of;  // surfaces of each location
    std::vector<std::uint16_t> surface;   // of each candidate
    void count(Items& items) const { items.add("locations", size()); }
    void describe(FieldVisitor& see) const;
};

enum class Decision : std::uint8_t {
    undecided,  // needs more samples around it
    one,        // there is one surface only
    covered,    // a surface surrounds the location
    last,       // the farthest: nothing else is left
    partly,     // several, each by the part of the location that it covers
    nearest,    // taken for want of anything better
};

// Which surfaces are seen: those from `first` to `last` of each location, both included; or some, each by its share.
struct Visibility : Batch {
    std::vector<std::uint16_t> first, last;
    std::vector<Decision> decision;
    struct Part {
        std::uint32_t location;
        std::uint16_t surface;
        float share;  // of one location they add up to 1
    };
    std::vector<Part> parts;  // of the locations that see several, in order

    // work(first, last, share) for all that location l sees; `part` is moved from location to location, from 0 on.
    template <class Work>
    void each_seen(size_t l, size_t& part, Work&& work) const {
        if (decision[l] != Decision::partly) {
            work(first[l], last[l], 1.0f);
            return;
        }
        for (; part < parts.size() && parts[part].location == l; ++part) work(parts[part].surface, parts[part].surface, parts[part].share);
    }
    void clear(size_t n) {
        first.assign(n, 0);
        last.assign(n, 0);
        decision.assign(n, Decision::undecided);
        parts.clear();
    }
    void count(Items& items) const { items.add("locations", size()); }
    void describe(FieldVisitor& see) const;
};

// What was reconstructed: radiance and alpha of each location, where `valid`.
struct Colors : Batch {
    std::vector<float> rgba;  // 4 a location
    std::vector<std::uint8_t> valid;
    const std::string* color_space = nullptr;  // of the samples
    std::uint64_t candidates = 0;              // samples they were filtered from, where one kernel did all of it
    void count(Items& items) const {
        items.add("locations", size());
        if (candidates > 0) items.add("candidates", candidates);
    }
    void describe(FieldVisitor& see) const;
};

WEFT_STREAM_TYPE(Locations, "Locations", "points (x, y, u, v, t) to reconstruct")
WEFT_STREAM_TYPE(Projection, "Projection", "samples at a batch's common (u, v, t), in a grid")
WEFT_STREAM_TYPE(Candidates, "Candidates", "the samples near each location")
WEFT_STREAM_TYPE(Surfaces, "Surfaces", "the surface each candidate belongs to, front to back")
WEFT_STREAM_TYPE(Visibility, "Visibility", "which surfaces are seen from each location")
WEFT_STREAM_TYPE(Colors, "Colors", "radiance of each location")

}  // namespace weft
