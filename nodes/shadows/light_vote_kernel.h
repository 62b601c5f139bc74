// What reproject and ray-vote-coverage make of a batch of receivers that share a point of the light
// and a time, in one go: light samples are carried there once, those alone that some receiver looks
// at; most receivers find nothing that stands before them, and are done with a glance at each.
// Source: ray_vote_kernel.h, which is the same one location at a time.
// Cost: no allocation once buffers have grown.  Threads: each call touches its own outputs only.
#pragma once
#include <cstdint>
#include <vector>

#include "light-field/kernels.h"
#include "light-field/streams.h"
#include "runtime/isa.h"
#include "shadows/light_view.h"
#include "shadows/streams.h"

namespace weft::shadows {

// Samples of one kind, hits or passes, around the batch.
struct LightVoteGrid {
    light_field::Block block;
    Projection projection;
    // Of its entries: how their planes rise, 1/w a px, as the light's point sees them; and of
    // passes, as of LightVoteScratch::Passes.
    struct Traits {
        std::vector<float> rise_x, rise_y, end, way_x, way_y, bulge;
        void grow(size_t n) {
            if (end.size() >= n) return;
            for (auto* values : {&rise_x, &rise_y, &end, &way_x, &way_y, &bulge})
                values->resize(2 * n);
        }
    } traits;
};

struct LightVoteScratch {
    LightVoteGrid hits, passes;
    std::vector<std::uint32_t> first, across, rows;  // light_field::Reach
    light_field::WantedCells wanted;                 // that some receiver looks at
    // What stops the light of receivers: where, and 1/w of its plane at the receiver.
    struct Places {
        std::vector<float> x, y, inverse;  // px
        void grow(size_t n) {
            if (x.size() >= n) return;
            for (auto* values : {&x, &y, &inverse}) values->resize(2 * n);
        }
    } stops;
    // Of a receiver, the passes that lie before it: where, how deep, how deep they get, how far they
    // move over the film a unit of 1/w, and how far what bends comes out beside them.
    struct Passes {
        std::vector<float> x, y, inverse, end, way_x, way_y, bulge;
        void grow(size_t n) {
            if (x.size() >= n) return;
            for (auto* values : {&x, &y, &inverse, &end, &way_x, &way_y, &bulge}) values->resize(2 * n);
        }
    } passing;
    // Receivers that passes may say something of, and where each one's `stops` begin.
    std::vector<std::uint32_t> open, first_stop;
};

#define WEFT_LIGHT_VOTE_KERNELS(isa)                                                             \
    namespace isa {                                                                              \
    void light_vote(const Hierarchy& hits, const Hierarchy& passes, const LightView& view,       \
                    const Locations& locations, const ShadowQueries& queries, float bias,        \
                    LightVoteScratch& scratch, LightShares& out);                                \
    }
WEFT_LIGHT_VOTE_KERNELS(v2)
WEFT_LIGHT_VOTE_KERNELS(v3)
WEFT_LIGHT_VOTE_KERNELS(v4)

}  // namespace weft::shadows
