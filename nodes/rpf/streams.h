// The streams of random parameter filtering, in the order in which stages hand them on. A batch is
// one record, a block of pixels (most often one pixel) and the samples around it: some thousands of
// numbers, as much as stays in the cache.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "rpf/sample_vectors.h"
#include "runtime/value.h"

namespace weft {

// Pixels [x0, x1) x [y0, y1).
struct PixelBlock {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

// Samples around a block that the block's own are compared with, its own first. What is known of
// them are rows of numbers, a row a number of the vectors, as they are; normalised they are
// (x - mean) scale, with the mean and 1 / deviation over the neighbourhood. A row that is constant
// there has scale 0.
struct Neighbourhoods : Batch {
    static constexpr size_t padding = 16;  // numbers past a row's end that may be read

    const SampleVectors* vectors = nullptr;
    PixelBlock block;
    std::vector<std::uint32_t> own_pixels;  // the block's, those past its tile included
    std::vector<std::uint32_t>
        own_offset;  // of pixel p of the block are samples [own_offset[p], own_offset[p + 1])
    std::vector<std::uint32_t> sample;  // index in the vectors
    size_t pitch = 0;                   // from row to row: whole vectors, 0 past the last sample
    LargeArray<float> values;           // rows() x pitch, maybe some rows more, and padding
    std::vector<float> mean, scale;     // of each row
    std::vector<float> low, high;       // of each row, normalised: its least and its largest number
    std::vector<std::uint32_t> own_record;  // what the base's span looks at

    size_t rows() const { return vectors->stride(); }
    size_t color_row(size_t k) const { return vectors->components.size() + k; }
    size_t samples() const { return sample.size(); }
    size_t own() const { return own_offset.empty() ? 0 : own_offset.back(); }
    const float* row(size_t i) const { return &values[i * pitch]; }
    void count(Items& items) const {
        items.add("pixels", own_pixels.size());
        items.add("samples", samples());
    }
    void describe(FieldVisitor& see) const;
};

// How much each row counts in the filter's distances, and how much of the colour is noise.
struct Weights : Batch {
    std::vector<float> of_row;       // beta of a feature, alpha of a colour, 0 of all else
    float w_random = 0;              // W_c^r
    std::array<float, 3> w_color{};  // W_c,k^r
    void count(Items& items) const { items.add("blocks", size()); }
    void describe(FieldVisitor& see) const;
};

// Filtered colours of the block's own samples, pixel by pixel.
struct SampleColors : Batch {
    std::vector<std::uint32_t> own_pixels, own_offset, sample;  // as of Neighbourhoods
    std::vector<float> rgb;                                     // 3 a sample
    std::vector<float> effective;  // (sum w)^2 / sum w^2: of how many samples it is the mean
    // Makes room for those of a neighbourhood. Throws Error where `colors` are not the samples it
    // was made of.
    void take_own(const Neighbourhoods& around, const Samples& colors);
    void count(Items& items) const { items.add("samples", sample.size()); }
    void describe(FieldVisitor& see) const;
};

WEFT_STREAM_TYPE(Neighbourhoods, "Neighbourhoods",
                 "the samples around each block of pixels, with their mean and deviation")
WEFT_STREAM_TYPE(Weights, "Weights", "what each feature and colour counts in a block's filter")
WEFT_STREAM_TYPE(SampleColors, "SampleColors", "filtered colours of each block's own samples")

}  // namespace weft
