// Which samples around a block are looked at: places drawn from a Gaussian around it, which is the
// screen term of the bilateral filter, so that near samples count more by being drawn more often.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "rpf/pixel_bounds.h"
#include "rpf/streams.h"

namespace weft::rpf {

enum class DrawRule {
    stratified,  // one well-spread set of places for all blocks, mirrored by chance: no sample
                 // twice
    gaussian,    // independent; each time any sample of the pixel, so repeats happen; drawn again
                 // outside box and picture
    distinct,  // independent, lost outside the box; no sample twice, but always the same first ones
               // of a pixel
};

struct DrawSettings {
    DrawRule rule = DrawRule::stratified;
    int box = 55;      // px
    size_t draws = 0;  // of a neighbourhood
    float sigma = 14;  // px
    int spp = 1;       // the largest number of samples that one pixel may give
    std::uint64_t seed = 1;
};

// Of a place `dx`, `dy` from the block's middle the sample `turn` after the one that chance begins
// with.
struct Offset {
    std::int16_t dx, dy;
    std::uint32_t turn;
};

// What is drawn for all blocks: for `stratified` the set of places, sorted by rows, else a long run
// of draws to start somewhere in: which cells of the box they fall into, counted row by row, the
// one past the last being outside.
struct Places {
    static constexpr size_t run = 1024;
    std::vector<Offset> offsets;
    std::vector<std::uint16_t> cells;
    // Of each whole run of that many draws: how often each cell is in it.
    std::vector<std::uint16_t> in_run;
};
Places make_places(const DrawSettings& by);

// Samples in the order in which they were drawn.
struct DrawnSamples {
    // Of pixels all or some of whose samples are near; it ends before sample `end`.
    struct Stretch {
        size_t end;
        PixelNear near;
    };
    std::vector<std::uint32_t> sample;
    std::vector<Stretch> stretches;

    void clear() { sample.clear(), stretches.clear(); }
    // Those up to `end` lie in such pixels.
    void extend(size_t end, PixelNear near);
};

struct DrawScratch {
    std::vector<std::uint16_t> counts;  // of each cell: how often it was drawn
    std::vector<std::uint8_t> inside;   // of each cell: 1 where there may be samples
    std::vector<PixelNear> near;        // of a row of cells
};

// The samples drawn around a block; its own are never among them, nor, but for a `stratified` draw,
// those of pixels that are told by `near` to have none near.
void draw(const Samples& samples, const DrawSettings& by, const Places& places, PixelBlock block,
          std::span<const NearCodes> near, DrawScratch& scratch, DrawnSamples& drawn);

}  // namespace weft::rpf
