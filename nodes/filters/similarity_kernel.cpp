// A tap at a time over a block, a row at a time, a vector of pixels at a time: distances, their
// sums over patches, exponentials, weighted sums.
#include <algorithm>

#include "filters/simd.h"
#include "filters/similarity.h"

namespace weft::kernel::WEFT_ISA {
namespace {

// Where a row of distances starts: p at (x, y), q a tap away.
struct Row {
    int x, y, dx, dy;
};

// Planes of p and q, from a row's start on.
struct Pair {
    const float *a, *b;
    Pair(const Planes& planes, int plane, Row at)
        : a(planes.row(plane, at.y) + at.x), b(planes.row(plane, at.y + at.dy) + at.x + at.dx) {}
};

template <bool noisy>
HWY_INLINE void add_difference(const Planes& planes, const Term& term, int component, Row at,
                               size_t i, VF& above, VF& below) {
    const Pair value(planes, term.first + component, at);
    const VF off = hn::Sub(hn::LoadU(f, value.a + i), hn::LoadU(f, value.b + i));
    if constexpr (noisy) {
        const Pair variance(planes, term.variances + component, at);
        const VF va = hn::LoadU(f, variance.a + i), vb = hn::LoadU(f, variance.b + i);
        const VF noise = hn::Add(va, hn::Min(va, vb));
        above = hn::Add(above, hn::NegMulAdd(hn::Set(f, term.subtract), noise, hn::Mul(off, off)));
        below = hn::MulAdd(hn::Set(f, term.k2), hn::Add(va, vb), below);
    } else {
        above = hn::MulAdd(off, off, above);
    }
}

HWY_INLINE VF let_pass(const Planes& planes, const Term& term, Row at, size_t i) {
    const VF e = hn::Set(f, term.e);
    if (term.slope < 0) return e;
    const VF slope = hn::LoadU(f, planes.row(term.slope, at.y) + at.x + i);
    return hn::Max(e, hn::Mul(hn::Set(f, term.slope_gain), slope));
}

// The distance of a vector of pixels: of the term as a vector, or the mean of its components' own.
template <bool noisy, bool apart>
HWY_INLINE VF distance(const Planes& planes, const Term& term, Row at, size_t i) {
    const VF e = let_pass(planes, term, at, i);
    if constexpr (apart) {
        VF sum = hn::Zero(f);
        for (int c = 0; c < term.components; ++c) {
            VF above = hn::Zero(f), below = e;
            add_difference<noisy>(planes, term, c, at, i, above, below);
            sum = hn::Add(sum, hn::Div(above, below));
        }
        return hn::Mul(sum, hn::Set(f, 1.0f / float(term.components)));
    } else {
        VF above = hn::Zero(f), below = e;
        for (int c = 0; c < term.components; ++c)
            add_difference<noisy>(planes, term, c, at, i, above, below);
        return hn::Div(above, below);
    }
}

// work(i, distance of pixels i ... ) for a row of n.
template <class Work>
HWY_INLINE void each_distance(const Planes& planes, const Term& term, bool apart, Row at, size_t n,
                              Work&& work) {
    const auto loop = [&](auto noisy, auto own) HWY_ATTR {
        for (size_t i = 0; i < n; i += lanes)
            work(i, distance<decltype(noisy)::value, decltype(own)::value>(planes, term, at, i));
    };
    const bool noisy = term.variances >= 0;
    if (noisy && apart) loop(std::true_type(), std::true_type());
    if (noisy && !apart) loop(std::true_type(), std::false_type());
    if (!noisy && apart) loop(std::false_type(), std::true_type());
    if (!noisy && !apart) loop(std::false_type(), std::false_type());
}

// to[i] = sum over rows of from[row * pitch + i], 2 patch + 1 rows.
void add_rows(const float* from, size_t pitch, int patch, size_t n, float* to) {
    for (size_t i = 0; i < n; i += lanes) {
        VF sum = hn::LoadU(f, from + i);
        for (int j = 1; j <= 2 * patch; ++j)
            sum = hn::Add(sum, hn::LoadU(f, from + size_t(j) * pitch + i));
        hn::StoreU(sum, f, to + i);
    }
}

HWY_INLINE VF add_columns(const float* from, int patch) {
    VF sum = hn::LoadU(f, from);
    for (int j = 1; j <= 2 * patch; ++j) sum = hn::Add(sum, hn::LoadU(f, from + j));
    return sum;
}

// How many of a patch's pixels, and theirs a tap away, lie within [0, size): at `at` along one
// axis.
int both_inside(int at, int tap, int patch, int size) {
    const int first = std::max({at - patch, 0, -tap}),
              last = std::min({at + patch, size - 1, size - 1 - tap});
    return std::max(0, last - first + 1);
}

// Colour distances of a block for one tap: those of patches.
class Patches {
  public:
    Patches(const Similarity& by, Block block, SimilarityScratch& scratch)
        : by_(by), block_(block), scratch_(scratch) {
        const size_t rows = size_t(block.y1 - block.y0 + 2 * by.patch);
        wide_ = whole_vectors(size_t(block.x1 - block.x0 + 2 * by.patch));
        pitch_ = wide_ + lanes;
        for (auto* values : {&scratch.distances, &scratch.known})
            values->assign(rows * pitch_ + lanes, 0.0f);
        for (auto* values : {&scratch.box, &scratch.known_box})
            values->assign(pitch_ + lanes, 0.0f);
        across_.assign(whole_vectors(size_t(block.x1 - block.x0)), 1.0f);
    }

    void start(const Tap& tap) {
        tap_ = tap;
        const Planes& planes = by_.planes;
        for (int y = block_.y0 - by_.patch; y < block_.y1 + by_.patch; ++y) {
            const size_t to = size_t(y - block_.y0 + by_.patch) * pitch_;
            float* distances = &scratch_.distances[to];
            float* known = &scratch_.known[to];
            if (y < 0 || y >= planes.height || y + tap.dy < 0 || y + tap.dy >= planes.height) {
                std::fill_n(distances, wide_, 0.0f);
                std::fill_n(known, wide_, 0.0f);
                continue;
            }
            const Row at{block_.x0 - by_.patch, y, tap.dx, tap.dy};
            const Pair seen(planes, by_.known, at);
            each_distance(planes, by_.color, by_.apart, at, wide_, [&](size_t i, VF d) HWY_ATTR {
                const VF both = hn::Mul(hn::LoadU(f, seen.a + i), hn::LoadU(f, seen.b + i));
                hn::StoreU(hn::IfThenElseZero(hn::Gt(both, hn::Zero(f)), d), f, distances + i);
                if (by_.holes) hn::StoreU(both, f, known + i);
            });
        }
        if (!by_.holes)
            for (int x = block_.x0; x < block_.x1; ++x)
                across_[size_t(x - block_.x0)] =
                    1 / float(std::max(1, both_inside(x, tap.dx, by_.patch, planes.width)));
    }

    // Of row y, n pixels.
    void row(int y, size_t n, float* to) {
        const size_t from = size_t(y - block_.y0) * pitch_;
        add_rows(&scratch_.distances[from], pitch_, by_.patch, wide_, scratch_.box.data());
        if (by_.holes)
            add_rows(&scratch_.known[from], pitch_, by_.patch, wide_, scratch_.known_box.data());
        const int down = both_inside(y, tap_.dy, by_.patch, by_.planes.height);
        const VF zero = hn::Zero(f), one = hn::Set(f, 1.0f),
                 per_row = hn::Set(f, 1.0f / float(std::max(1, down)));
        for (size_t i = 0; i < n; i += lanes) {
            const VF sum = add_columns(&scratch_.box[i], by_.patch);
            const VF mean =
                by_.holes
                    ? hn::Div(sum, hn::Max(one, add_columns(&scratch_.known_box[i], by_.patch)))
                    : hn::Mul(sum, hn::Mul(hn::LoadU(f, &across_[i]), per_row));
            hn::StoreU(hn::Max(zero, mean), f, to + i);
        }
    }

  private:
    const Similarity& by_;
    Block block_;
    SimilarityScratch& scratch_;
    size_t wide_, pitch_;
    Tap tap_;
    std::vector<float> across_;
};

// Weighted sums of a block's pixels: planes in a row's order, then the next row.
class Sums {
  public:
    Sums(const Similarity& by, Block block, std::vector<float>& values)
        : by_(by), block_(block), values_(values), planes_(size_t(output_planes(by))) {
        pitch_ = whole_vectors(size_t(block.x1 - block.x0));
        values.assign(pitch_ * planes_ * size_t(block.y1 - block.y0), 0.0f);
    }
    size_t pitch() const { return pitch_; }

    void add(int y, const Tap& tap, const float* exponent) {
        const Planes& planes = by_.planes;
        const int y_there = y + tap.dy, x_there = block_.x0 + tap.dx;
        const float* known = planes.row(by_.known, y_there) + x_there;
        float* total = plane(y, planes_ - 1);
        const VF weight = hn::Set(f, tap.weight), last = hn::Set(f, last_exponent);
        const auto channels = size_t(by_.channels), variances = planes_ - 1 - channels;
        for (size_t i = 0; i < pitch_; i += lanes) {
            const VF e = exp_of_minus(hn::Min(hn::LoadU(f, exponent + i), last));
            const VF w = hn::Mul(hn::Mul(weight, hn::LoadU(f, known + i)), e);
            hn::StoreU(hn::Add(hn::LoadU(f, total + i), w), f, total + i);
            const auto sum = [&](size_t to, int from, VF by) HWY_ATTR {
                float* place = plane(y, to) + i;
                const VF v = hn::LoadU(f, planes.row(from, y_there) + x_there + i);
                hn::StoreU(hn::MulAdd(by, v, hn::LoadU(f, place)), f, place);
            };
            for (size_t c = 0; c < channels; ++c) sum(c, int(c), w);
            for (size_t c = 0; c < variances; ++c)
                sum(channels + c, by_.variances + int(c), hn::Mul(w, w));
        }
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
    const VF zero = hn::Zero(f);
    Sums sums(by, block, scratch.sums);
    const size_t n = sums.pitch();
    scratch.exponent.assign(n, 0.0f);
    float* exponent = scratch.exponent.data();
    const bool colors = by.color.components > 0;
    Patches patches(by, block, scratch);
    for (const Tap& tap : by.taps) {
        const int y0 = std::max(block.y0, -tap.dy), y1 = std::min(block.y1, planes.height - tap.dy);
        if (y0 >= y1 || block.x1 + tap.dx <= 0 || block.x0 + tap.dx >= planes.width) continue;
        if (colors && by.patch > 0) patches.start(tap);
        for (int y = y0; y < y1; ++y) {
            const Row at{block.x0, y, tap.dx, tap.dy};
            if (!colors)
                std::fill_n(exponent, n, 0.0f);
            else if (by.patch > 0)
                patches.row(y, n, exponent);
            else
                each_distance(planes, by.color, by.apart, at, n, [&](size_t i, VF d) HWY_ATTR {
                    const Pair seen(planes, by.known, at);
                    const VF both = hn::Mul(hn::LoadU(f, seen.a + i), hn::LoadU(f, seen.b + i));
                    hn::StoreU(hn::IfThenElseZero(hn::Gt(both, zero), hn::Max(zero, d)), f,
                               exponent + i);
                });
            for (const Term& feature : by.features)
                each_distance(planes, feature, false, at, n, [&](size_t i, VF d) HWY_ATTR {
                    hn::StoreU(hn::Add(hn::LoadU(f, exponent + i), hn::Max(zero, d)), f,
                               exponent + i);
                });
            sums.add(y, tap, exponent);
        }
    }
    sums.put(out);
}

}  // namespace weft::kernel::WEFT_ISA
