// The streams of shadow reconstruction, in the order in which stages hand them on: which sample
// each of the camera's locations sees, where the light is asked about it, how much of the light it
// sees.
#pragma once
#include <cstdint>
#include <vector>

#include "runtime/value.h"

namespace weft {

// The sample that each location sees: the nearest one of its surface.
struct SeenSamples : Batch {
    static constexpr std::uint32_t none = 0xffffffff;
    std::vector<std::uint32_t> sample;  // index in the camera's hierarchy
    float chance = 1;  // with which a location is among these: of several lights it asks one
    void count(Items& items) const { items.add("locations", size()); }
    void describe(FieldVisitor& see) const;
};

// How far places of a film are from each other: d^T Q d of d px, Q of determinant 1. What lies nearer
// than 1 is an ellipse as large as a disc.
struct FilmMetric {
    float xx = 1, xy = 0, yy = 1;
    float square(float x, float y) const { return xx * x * x + 2 * xy * x * y + yy * y * y; }
};

// What is asked of the light at each location, beside the place on its film (a Locations batch of
// the same records).
struct ShadowQueries : Batch {
    std::vector<float> inverse_depth;  // 1 / w of the receiver at the location's time; 0: not asked
    std::vector<float> slope_x, slope_y;  // of 1 / w over the film, of the receiver's surface, seen
                                          // from l = 0
    std::vector<std::uint32_t> sample;    // of the camera's buffer; SeenSamples::none
    std::vector<std::uint32_t> answer_of;  // the location whose share holds for each; empty: its own
    std::vector<FilmMetric> metric;       // by which light samples are near; empty: as px are
    FilmMetric metric_of(size_t l) const { return metric.empty() ? FilmMetric{} : metric[l]; }
    float chance = 1;    // as of SeenSamples: what is found counts 1 / chance times
    size_t outside = 0;  // receivers that the light shines on and its view does not hold
    void count(Items& items) const {
        items.add("queries", size());
        items.add("outside-view", outside);
    }
    void describe(FieldVisitor& see) const;
};

// How much of the light each location sees.
struct LightShares : Batch {
    std::vector<float> share;          // 0: none of it, 1: all
    std::vector<std::uint32_t> votes;  // light samples that had a say; 0: nobody, share is 1
    void count(Items& items) const { items.add("locations", size()); }
    void describe(FieldVisitor& see) const;
};

WEFT_STREAM_TYPE(SeenSamples, "SeenSamples", "the sample that each location sees")
WEFT_STREAM_TYPE(ShadowQueries, "ShadowQueries", "receivers whose light is asked for")
WEFT_STREAM_TYPE(LightShares, "LightShares", "how much of the light each location sees")

}  // namespace weft
