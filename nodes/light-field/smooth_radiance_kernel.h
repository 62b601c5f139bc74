// Smoothing of noisy radiance along surfaces, and sharpening of clean detail, as far as the samples
// themselves say that it does good. For each sample and each treatment its radiance is predicted
// from its neighbours on its surface, itself left out; the sample goes as far towards one treatment
// as is best around it.
//   as it is     what a filter of the narrowest width, a squared tent, will make of the samples
//   later sharpened    the same of 2 y - (the samples so filtered): its blur is made up for in
//   advance,
//                within what the neighbours are and a quarter of the least of them, so that an
//                outlier leaves no black samples around it and energy is kept
//   smoothed     means under paraboloids (Epanechnikov's kernel) of greater widths
//   neighbours   by position at lens centre and half time; of one surface where slope, velocity and
//                depth are alike
//                Under the greater widths albedo has to be alike, too, and the more normals differ,
//                the less a neighbour counts, where samples have them.
//   errors       (sample - prediction)^2 / (wide mean^2 + epsilon^2), averaged over a window
//   how far      what makes the error of the two predictions' mix least, there and then: where
//   noise and
//                structure meet, part of both is kept
// Several radiances of the same samples, such as parts of the light, are smoothed in one go: whom each
// sample's surface holds around it, and how near, is found out once for all.
// Source: leave-one-out choice of bandwidth (Stone 1974; as in Haerdle 1990, ch. 5), mixing of
// predictions by the same errors (Wolpert 1992; Breiman 1996, "Stacked regressions"), twicing
// (Tukey 1977; Stuetzle and Mittal 1979); own combination. Kernels work on blocks [first, last) of
// samples. Cost: some 800 neighbours a sample in all, about 0.3 us. Memory: 20 bytes a sample, and some 120 for
// each of a band of rows: the field is gone through from top to bottom once. Threads:
// through the context.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "runtime/context.h"
#include "runtime/isa.h"
#include "runtime/large_array.h"
#include "samples/samples.h"

namespace weft::light_field {

struct Smoothing {
    static constexpr size_t widths = 3;
    static constexpr size_t treatments =
        widths + 1;                     // 0 as it is, 1 ... smoothed, the last sharpened
    std::array<float, widths> width{};  // px, ascending; the first is that of the filter to come
    float window = 3;                   // px: errors are averaged within it
    float slope = 0.6f;                 // px: most that two of one surface differ by
    float velocity = 1.5f;              // px per shutter
    float depth = 0.03f;                // of the logarithm
    float normal = 0.55f;  // difference of unit normals from which on two are not smoothed together
    float albedo = 0.1f;   // the same of albedo, each channel
    float caution = 0.5f;  // standard errors by which a wider kernel has to win
    float sharp_caution = 2;  // the same for sharpening
    static constexpr size_t most_colors = 2;  // of the same samples
    std::array<float, most_colors> epsilon{0.1f, 0.1f};  // radiance below which errors count less
};

// Values of some samples, channel by channel.
struct Rgb {
    std::span<float> r, g, b;
};

// Values of samples in several arrays. They are longer than needed, for whole vectors.
struct Stretch {
    LargeArray<float> memory;  // of the arrays, one after another
    size_t length = 0;         // of each

    void lay_out(size_t room, std::span<std::span<float>* const> arrays);
    // Brings elements [from, end) of all arrays to the front.
    void shift(size_t from, size_t end);
};

// Samples in a grid, row by row. Cells are flat, so that a dozen samples that follow one another
// are about as high as wide together: a block, which looks at what is around it at once. Samples
// are numbered in the order of the cells; those of some rows are at hand at a time, from `first`
// on.
struct SampleField : Stretch {
    static constexpr size_t block_size = 16;
    struct Block {
        std::uint32_t begin, end;
    };

    size_t size = 0;
    int columns = 0, rows = 0;
    float cell_width = 1, cell_height = 1, x0 = 0, y0 = 0;
    float block_width = 1;            // px, at most
    bool moving = false;              // else all velocities are 0
    LargeArray<std::uint32_t> start;  // of each cell, row by row; then twice the end
    LargeArray<std::uint32_t> order;  // index in the buffer

    // Of the samples at hand; element i of an array is of sample first + i.
    size_t first = 0;
    std::vector<Block> blocks;
    std::span<float> x, y, slope, velocity_x, velocity_y, log_depth;
    size_t colors = 1;
    std::array<Rgb, Smoothing::most_colors> color;
    std::array<std::span<float>, 3> normal,
        albedo;  // empty where samples have none; normals of unit length

    int column_of(float at) const { return clamped((at - x0) / cell_width, columns); }
    int row_of(float at) const { return clamped((at - y0) / cell_height, rows); }
    // Upper end of a row; the outermost hold whatever lies beyond them, too.
    float top_of(int row) const {
        constexpr float far = std::numeric_limits<float>::infinity();
        return row <= 0 ? -far : row >= rows ? far : y0 + float(row) * cell_height;
    }
    // The first sample of a row; of one past the end, the end.
    size_t start_of(int row) const {
        return start[size_t(std::clamp(row, 0, rows)) * size_t(columns)];
    }

  private:
    static int clamped(float at, int count) {
        return at > 0 ? (at < float(count) ? int(at) : count - 1) : 0;
    }
};
// In order, but none at hand, with room for some at a time. `radius`: of the gaps expected between
// samples, px.
SampleField sample_field(const Samples& samples, float radius, Context& ctx);
void make_room(const Samples& samples, size_t room, SampleField& field);
// Radiances of the samples of a buffer, three numbers each.
using Radiances = std::span<const std::span<const float>>;
// Takes the samples of rows [first, last), which follow those at hand, to hand, too.
void fetch(const Samples& samples, Radiances of, int first, int last, SampleField& field,
           Context& ctx);

// What the filter to come makes of each sample at hand, and the sum of its weights there.
struct Filtered : Stretch {
    std::array<Rgb, Smoothing::most_colors> color;
    std::span<float> weight;
    explicit Filtered(size_t room, size_t colors = 1);
};

// What each treatment but the first makes of a sample, against the sample as it is.
struct Change : Rgb {  // smoothed; none where sharpened
    std::span<float> gain;  // error less that of the sample as it is: below 0, it gains
    std::span<float> way;   // from the one prediction to the other, squared, as errors are
};
struct Changes : Stretch {
    // Of one radiance, treatment by treatment from the first that changes it on.
    using Of = std::array<Change, Smoothing::treatments - 1>;
    std::array<Of, Smoothing::most_colors> color;
    explicit Changes(size_t room, size_t colors = 1);
};

#define WEFT_SMOOTHING_KERNELS(isa)                                                               \
    namespace isa {                                                                               \
    void filter_samples(const SampleField& field, const Smoothing& by, size_t first, size_t last, \
                        Filtered& out);                                                           \
    void find_errors(const SampleField& field, const Filtered& filtered, const Smoothing& by,     \
                     size_t first, size_t last, Changes& out);                                    \
    void treat(const SampleField& field, const Filtered& filtered, const Changes& changes,        \
               const Smoothing& by, size_t first, size_t last, std::span<float>* rgb);            \
    }
WEFT_SMOOTHING_KERNELS(v2)
WEFT_SMOOTHING_KERNELS(v3)
WEFT_SMOOTHING_KERNELS(v4)

// Radiances of the buffer's samples, Smoothing::most_colors at most, smoothed. Widths are `radius` times 1 ... widest.
std::vector<Array<float>> smooth_radiance(const Samples& samples, Radiances of, float radius,
                                          float widest, Smoothing by, Context& ctx);

}  // namespace weft::light_field
