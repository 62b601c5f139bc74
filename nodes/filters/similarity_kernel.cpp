// A block at a time, taps of one row together, a vector of pixels at a time: distances of colour,
// their sums over patches, weights, weighted sums. The rows of p and q stay in the nearest cache
// for all taps of a row.
#include <algorithm>
#include <span>
#include <vector>

#include "filters/simd.h"
#include "filters/similarity.h"

namespace weft::kernel::WEFT_ISA {
namespace {

// Where a row starts: p at (x, y), q a tap away.
struct Row {
    int x, y, dx, dy;
};

// A plane's values at p and q, from a row's start on.
struct Pair {
    const float *a, *b;
    Pair(const Planes& planes, int plane, Row at)
        : a(planes.row(plane, at.y) + at.x), b(planes.row(plane, at.y + at.dy) + at.x + at.dx) {}
    HWY_INLINE VF here(size_t i) const { return hn::LoadU(f, a + i); }
    HWY_INLINE VF there(size_t i) const { return hn::LoadU(f, b + i); }
};

HWY_INLINE VF squared_difference(const Pair& value, size_t i, VF sum) {
    const VF off = hn::Sub(value.here(i), value.there(i));
    return hn::MulAdd(off, off, sum);
}

// (difference - s (va + min(va, vb))) / (e + k^2 (va + vb))
HWY_INLINE VF over_noise(const Term& term, VF difference, VF va, VF vb, VF e) {
    const VF noise = hn::Add(va, hn::Min(va, vb));
    return hn::Div(hn::NegMulAdd(hn::Set(f, term.subtract), noise, difference),
                   hn::MulAdd(hn::Set(f, term.k2), hn::Add(va, vb), e));
}

// work(i, distances of pixels i ...) for a row of n, of the term as a vector.
template <class Work>
HWY_INLINE void each_vector_distance(const Planes& planes, const Term& term, Row at, size_t n,
                                     const Work& work) {
    const VF zero = hn::Zero(f), least = hn::Set(f, term.e), gain = hn::Set(f, term.slope_gain);
    const float* slope = term.slope >= 0 ? planes.row(term.slope, at.y) + at.x : nullptr;
    for (size_t i = 0; i < n; i += lanes) {
        VF difference = zero;
        for (int c = 0; c < term.components; ++c)
            difference = squared_difference(Pair(planes, term.first + c, at), i, difference);
        const VF e = slope ? hn::Max(least, hn::Mul(gain, hn::LoadU(f, slope + i))) : least;
        if (term.variances < 0) {
            work(i, hn::Div(difference, e));
            continue;
        }
        VF va = zero, vb = zero;
        for (int c = 0; c < term.variance_planes; ++c) {
            const Pair variance(planes, term.variances + c, at);
            va = hn::Add(va, variance.here(i));
            vb = hn::Add(vb, variance.there(i));
        }
        work(i, over_noise(term, difference, va, vb, e));
    }
}

// The same where each component has a denominator of its own: their mean.
template <class Work>
HWY_INLINE void each_mean_distance(const Planes& planes, const Term& term, Row at, size_t n,
                                   const Work& work) {
    const VF zero = hn::Zero(f), e = hn::Set(f, term.e),
             share = hn::Set(f, 1.0f / float(term.components));
    for (size_t i = 0; i < n; i += lanes) {
        VF sum = zero;
        for (int c = 0; c < term.components; ++c) {
            const VF difference = squared_difference(Pair(planes, term.first + c, at), i, zero);
            if (term.variances < 0) {
                sum = hn::Add(sum, hn::Div(difference, e));
                continue;
            }
            const Pair variance(planes, term.variances + c, at);
            sum =
                hn::Add(sum, over_noise(term, difference, variance.here(i), variance.there(i), e));
        }
        work(i, hn::Mul(sum, share));
    }
}

template <class Work>
HWY_INLINE void each_color_distance(const Similarity& by, Row at, size_t n, const Work& work) {
    if (by.apart)
        each_mean_distance(by.planes, by.color, at, n, work);
    else
        each_vector_distance(by.planes, by.color, at, n, work);
}

// How many of a patch's pixels, and theirs a tap away, lie within [0, size): at `at` along an axis.
int both_inside(int at, int tap, int patch, int size) {
    const int first = std::max({at - patch, 0, -tap}),
              last = std::min({at + patch, size - 1, size - 1 - tap});
    return std::max(0, last - first + 1);
}

// Colour distances for some taps of one row, summed over patches. Rows are kept in rings of
// 2 patch + 1: of each row of the block its distances are found once.
class Patches {
  public:
    Patches(const Similarity& by, Block block, SimilarityScratch& scratch)
        : by_(by), block_(block), scratch_(scratch), height_(size_t(2 * by.patch + 1)) {
        wide_ = whole_vectors(size_t(block.x1 - block.x0 + 2 * by.patch));
        pitch_ = wide_ + lanes;
        scratch.box.assign(pitch_ + lanes, 0.0f);
        scratch.known_box.assign(pitch_ + lanes, 0.0f);
    }

    // n: pixels of a row, in whole vectors.
    void start(std::span<const Tap> taps, size_t n) {
        taps_ = taps;
        n_ = n;
        scratch_.distances.assign(taps.size() * height_ * pitch_ + lanes, 0.0f);
        if (by_.holes)
            scratch_.known.assign(taps.size() * height_ * pitch_ + lanes, 0.0f);
        else
            scratch_.known.assign(taps.size() * n, 0.0f);
        if (by_.holes) return;
        // Where nothing is unknown, how many pixels a patch has is known beforehand.
        for (size_t t = 0; t < taps.size(); ++t)
            for (int x = block_.x0; x < block_.x1; ++x)
                scratch_.known[t * n + size_t(x - block_.x0)] =
                    1 / float(std::max(1, both_inside(x, taps[t].dx, by_.patch, by_.planes.width)));
    }

    // Distances of row y, which may lie outside the picture.
    void add(int y) {
        const Planes& planes = by_.planes;
        const int there = y + taps_.front().dy;
        const bool inside = y >= 0 && y < planes.height && there >= 0 && there < planes.height;
        for (size_t t = 0; t < taps_.size(); ++t) {
            float* distances = &scratch_.distances[at(t, y)];
            float* known = by_.holes ? &scratch_.known[at(t, y)] : nullptr;
            if (!inside) {
                std::fill_n(distances, wide_, 0.0f);
                if (known) std::fill_n(known, wide_, 0.0f);
                continue;
            }
            const Row row{block_.x0 - by_.patch, y, taps_[t].dx, taps_[t].dy};
            const Pair seen(planes, by_.known, row);
            each_color_distance(by_, row, wide_, [&](size_t i, VF d) HWY_ATTR {
                const VF both = hn::Mul(seen.here(i), seen.there(i));
                hn::StoreU(hn::IfThenElseZero(hn::Gt(both, hn::Zero(f)), d), f, distances + i);
                if (known) hn::StoreU(both, f, known + i);
            });
        }
    }

    // Of row y and tap t; rows y - patch ... y + patch were added.
    void row(int y, size_t t, float* to) {
        sum_rows(scratch_.distances, t, scratch_.box.data());
        if (by_.holes) sum_rows(scratch_.known, t, scratch_.known_box.data());
        const int down = both_inside(y, taps_[t].dy, by_.patch, by_.planes.height);
        const VF zero = hn::Zero(f), one = hn::Set(f, 1.0f),
                 per_row = hn::Set(f, 1.0f / float(std::max(1, down)));
        const float* across = by_.holes ? nullptr : &scratch_.known[t * n_];
        for (size_t i = 0; i < n_; i += lanes) {
            const VF sum = sum_columns(&scratch_.box[i]);
            const VF mean = across
                                ? hn::Mul(sum, hn::Mul(hn::LoadU(f, across + i), per_row))
                                : hn::Div(sum, hn::Max(one, sum_columns(&scratch_.known_box[i])));
            hn::StoreU(hn::Max(zero, mean), f, to + i);
        }
    }

  private:
    size_t at(size_t tap, int y) const {
        return (tap * height_ + size_t(y + by_.patch) % height_) * pitch_;
    }
    void sum_rows(const std::vector<float>& rows, size_t tap, float* to) const {
        const float* from = &rows[tap * height_ * pitch_];
        for (size_t i = 0; i < wide_; i += lanes) {
            VF sum = hn::LoadU(f, from + i);
            for (size_t j = 1; j < height_; ++j)
                sum = hn::Add(sum, hn::LoadU(f, from + j * pitch_ + i));
            hn::StoreU(sum, f, to + i);
        }
    }
    HWY_INLINE VF sum_columns(const float* from) const {
        VF sum = hn::LoadU(f, from);
        for (size_t j = 1; j < height_; ++j) sum = hn::Add(sum, hn::LoadU(f, from + j));
        return sum;
    }

    const Similarity& by_;
    Block block_;
    SimilarityScratch& scratch_;
    size_t height_, wide_, pitch_, n_ = 0;
    std::span<const Tap> taps_;
};

// Exponents so far, n of them, become the weights of the pixels a tap away.
void weigh(const Similarity& by, Row at, float tap, size_t n, float* exponents) {
    for (const Term& feature : by.features)
        each_vector_distance(by.planes, feature, at, n, [&](size_t i, VF d) HWY_ATTR {
            const VF sum = hn::Add(hn::LoadU(f, exponents + i), hn::Max(hn::Zero(f), d));
            hn::StoreU(sum, f, exponents + i);
        });
    const VF weight = hn::Set(f, tap), last = hn::Set(f, last_exponent);
    const Pair known(by.planes, by.known, at);
    for (size_t i = 0; i < n; i += lanes) {
        const VF e = exp_of_minus(hn::Min(hn::LoadU(f, exponents + i), last));
        hn::StoreU(hn::Mul(hn::Mul(weight, known.there(i)), e), f, exponents + i);
    }
}

// to[i] += sum over taps of weight value, or of weight^2 value; without a plane: of weight.
enum class Sum { weights, values, variances };
template <Sum what>
void add_taps(const Similarity& by, std::span<const Tap> taps, Block block, int y, int plane,
              const float* weights, size_t n, float* to) {
    for (size_t i = 0; i < n; i += at_once * lanes) {
        VF sums[at_once];
        for (size_t v = 0; v < at_once; ++v) sums[v] = hn::LoadU(f, to + i + v * lanes);
        for (size_t t = 0; t < taps.size(); ++t) {
            const float* w = weights + t * n + i;
            const float* value = what == Sum::weights ? nullptr
                                                      : by.planes.row(plane, y + taps[t].dy) +
                                                            block.x0 + taps[t].dx + int(i);
            for (size_t v = 0; v < at_once; ++v) {
                VF weight = hn::LoadU(f, w + v * lanes);
                if constexpr (what == Sum::weights) {
                    sums[v] = hn::Add(sums[v], weight);
                } else {
                    if constexpr (what == Sum::variances) weight = hn::Mul(weight, weight);
                    sums[v] = hn::MulAdd(weight, hn::LoadU(f, value + v * lanes), sums[v]);
                }
            }
        }
        for (size_t v = 0; v < at_once; ++v) hn::StoreU(sums[v], f, to + i + v * lanes);
    }
}

// A block's sums, of all planes of a row, then of the next.
class Sums {
  public:
    Sums(const Similarity& by, Block block, std::vector<float>& values)
        : by_(by), block_(block), values_(values), planes_(size_t(output_planes(by))) {
        pitch_ = whole_vectors(size_t(block.x1 - block.x0), at_once);
        values.assign(pitch_ * planes_ * size_t(block.y1 - block.y0), 0.0f);
    }
    size_t pitch() const { return pitch_; }  // from row to row of weights

    void add(int y, std::span<const Tap> taps, const float* weights) {
        const auto channels = size_t(by_.channels);
        add_taps<Sum::weights>(by_, taps, block_, y, 0, weights, pitch_, plane(y, planes_ - 1));
        for (size_t c = 0; c < channels; ++c)
            add_taps<Sum::values>(by_, taps, block_, y, int(c), weights, pitch_, plane(y, c));
        for (size_t c = channels; c < planes_ - 1; ++c)
            add_taps<Sum::variances>(by_, taps, block_, y, by_.variances + int(c - channels),
                                     weights, pitch_, plane(y, c));
    }

    void put(Planes& out) {
        const auto channels = size_t(by_.channels), n = size_t(block_.x1 - block_.x0);
        for (int y = block_.y0; y < block_.y1; ++y) {
            const float* total = plane(y, planes_ - 1);
            for (size_t c = 0; c < planes_; ++c) {
                const float* from = plane(y, c);
                float* to = out.row(int(c), y) + block_.x0;
                for (size_t i = 0; i < n; ++i) {
                    const float by = total[i] > 0 ? total[i] : 1.0f;
                    to[i] = c == planes_ - 1 ? total[i]
                            : c < channels   ? from[i] / by
                                             : from[i] / by / by;
                }
            }
        }
    }

  private:
    float* plane(int y, size_t which) {
        return &values_[(size_t(y - block_.y0) * planes_ + which) * pitch_];
    }
    const Similarity& by_;
    Block block_;
    std::vector<float>& values_;
    size_t planes_, pitch_;
};

}  // namespace

void similar_means(const Similarity& by, Block block, SimilarityScratch& scratch, Planes& out) {
    const Planes& planes = by.planes;
    const bool colors = by.color.components > 0, patched = colors && by.patch > 0;
    Sums sums(by, block, scratch.sums);
    const size_t pitch = sums.pitch(), n = whole_vectors(size_t(block.x1 - block.x0));
    Patches patches(by, block, scratch);
    std::vector<Tap>& taps = scratch.taps;

    const auto weights_of_row = [&](int y) {
        for (size_t t = 0; t < taps.size(); ++t) {
            const Row at{block.x0, y, taps[t].dx, taps[t].dy};
            float* exponents = &scratch.weights[t * pitch];
            if (patched) {
                patches.row(y, t, exponents);
            } else if (colors) {
                // Of what is not known no colour is unlike.
                const Pair known(planes, by.known, at);
                each_color_distance(by, at, n, [&](size_t i, VF d) HWY_ATTR {
                    const VF zero = hn::Zero(f);
                    hn::StoreU(hn::IfThenElseZero(hn::Gt(known.here(i), zero), hn::Max(zero, d)), f,
                               exponents + i);
                });
            } else {
                std::fill_n(exponents, n, 0.0f);
            }
            weigh(by, at, taps[t].weight, n, exponents);
        }
        sums.add(y, taps, scratch.weights.data());
    };

    for (size_t first = 0, last = 0; first < by.taps.size(); first = last) {
        const int dy = by.taps[first].dy;
        taps.clear();
        for (last = first; last < by.taps.size() && by.taps[last].dy == dy; ++last) {
            const int dx = by.taps[last].dx;
            if (block.x1 + dx > 0 && block.x0 + dx < planes.width) taps.push_back(by.taps[last]);
        }
        const int y0 = std::max(block.y0, -dy), y1 = std::min(block.y1, planes.height - dy);
        if (y0 >= y1 || taps.empty()) continue;
        scratch.weights.resize(taps.size() * pitch);
        if (!patched) {
            for (int y = y0; y < y1; ++y) weights_of_row(y);
            continue;
        }
        patches.start(taps, n);
        for (int y = y0 - by.patch; y < y1 + by.patch; ++y) {
            patches.add(y);
            if (y - by.patch >= y0) weights_of_row(y - by.patch);
        }
    }
    sums.put(out);
}

}  // namespace weft::kernel::WEFT_ISA
