#include "light-field/smooth_radiance_kernel.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "light-field/simd.h"
#include "light-field/surroundings.h"

namespace weft::light_field::WEFT_ISA {
namespace {

constexpr size_t widths = Smoothing::widths, treatments = Smoothing::treatments;

// work(at, n) for the samples of each block, a vector at once: n of them, from `at` on, after their
// surroundings were found.
template <class Around, class Work>
HWY_INLINE void each_vector(const SampleField& s, size_t first, size_t last, Around& around,
                            Work&& work) {
    for (size_t block = first; block < last; ++block) {
        const size_t begin = s.blocks[block].begin - s.first, end = s.blocks[block].end - s.first;
        around.find(begin, end);
        for (size_t at = begin; at < end; at += lanes) work(at, std::min(end - at, lanes));
    }
}

// Writes n lanes: what follows is another block's.
HWY_INLINE void put(VF value, size_t n, float* to) {
    if (n == lanes) return hn::StoreU(value, f, to);
    alignas(64) float all[lanes];
    hn::Store(value, f, all);
    std::copy_n(all, n, to);
}

struct Color {
    VF r, g, b;
};
// Of a vector of samples from `at` on.
template <class Of>
HWY_INLINE Color color_at(const Of& of, size_t at) {
    return {hn::LoadU(f, &of.r[at]), hn::LoadU(f, &of.g[at]), hn::LoadU(f, &of.b[at])};
}
HWY_INLINE Color operator-(const Color& a, const Color& b) {
    return {hn::Sub(a.r, b.r), hn::Sub(a.g, b.g), hn::Sub(a.b, b.b)};
}
HWY_INLINE Color chosen(hn::Mask<F> which, const Color& yes, const Color& no) {
    return {hn::IfThenElse(which, yes.r, no.r), hn::IfThenElse(which, yes.g, no.g),
            hn::IfThenElse(which, yes.b, no.b)};
}
// Sum of squares, each by its weight.
HWY_INLINE VF squares(const Color& of, const Color& weight) {
    const VF r = hn::Mul(hn::Mul(of.r, of.r), weight.r), g = hn::Mul(hn::Mul(of.g, of.g), weight.g),
             b = hn::Mul(hn::Mul(of.b, of.b), weight.b);
    return hn::Add(hn::Add(r, g), b);
}

// Weighted sums of radiance.
struct Sums {
    VF w = hn::Zero(f), r = hn::Zero(f), g = hn::Zero(f), b = hn::Zero(f);
    HWY_INLINE void add(VF weight, VF red, VF green, VF blue) {
        w = hn::Add(w, weight);
        r = hn::MulAdd(weight, red, r);
        g = hn::MulAdd(weight, green, g);
        b = hn::MulAdd(weight, blue, b);
    }
    HWY_INLINE Color over(VF all) const {
        return {hn::Div(r, all), hn::Div(g, all), hn::Div(b, all)};
    }
};

// Sums of sharpened radiance, and of the weights' share in those of the samples they are of.
struct Sharp {
    Sums sums;
    VF overlap = hn::Zero(f);
};

// Of the changes that treatments make to what is around: weighted sums, and those of gains squared.
struct Gains {
    std::array<VF, treatments - 1> gain, spread, way;
    Gains() {
        for (auto* sums : {&gain, &spread, &way}) sums->fill(hn::Zero(f));
    }
};

// Least and greatest of radiances.
struct Range {
    VF least = hn::Set(f, std::numeric_limits<float>::max()), greatest = hn::Neg(least);
    HWY_INLINE void add(hn::Mask<F> which, VF value) {
        least = hn::IfThenElse(which, hn::Min(least, value), least);
        greatest = hn::IfThenElse(which, hn::Max(greatest, value), greatest);
    }
    // Past the ends by a quarter of the least: the same at both, so that what is too dark and what
    // is too bright cancel.
    HWY_INLINE VF limit(VF value) const {
        const VF past = hn::Mul(hn::Set(f, 0.25f), hn::Abs(least));
        return hn::Min(hn::Max(value, hn::Sub(least, past)), hn::Add(greatest, past));
    }
};

// (1 - distance / width)^2, 0 past the width.
HWY_INLINE VF squared_tent(VF d2, VF per_width) {
    const VF part = hn::Max(hn::Zero(f), hn::NegMulAdd(hn::Sqrt(d2), per_width, hn::Set(f, 1.0f)));
    return hn::Mul(part, part);
}
// 1 - (distance / width)^2, 0 past the width; of a squared width.
HWY_INLINE VF paraboloid(VF d2, VF per_square) {
    return hn::Max(hn::Zero(f), hn::NegMulAdd(d2, per_square, hn::Set(f, 1.0f)));
}
// 2 y - mean
HWY_INLINE VF sharpened(VF y, VF mean) {
    return hn::MulSub(hn::Set(f, 2.0f), y, mean);
}

// What is left of samples when predictions are taken off them that they have a share in: leaving
// them out stretches the difference.
struct Left {
    Color own, mean;  // the widest

    HWY_INLINE Color by(const Color& guess, VF share) const {
        const VF one = hn::Set(f, 1.0f), stretch = hn::Div(one, hn::Sub(one, share));
        // A sample all alone is predicted by the widest mean, which is itself.
        const auto alone = hn::Ge(share, hn::Set(f, 0.999f));
        const auto part = [&](VF y, VF guessed, VF around) HWY_ATTR {
            return hn::IfThenElse(alone, hn::Sub(y, around), hn::Mul(hn::Sub(y, guessed), stretch));
        };
        return {part(own.r, guess.r, mean.r), part(own.g, guess.g, mean.g),
                part(own.b, guess.b, mean.b)};
    }
};

}  // namespace

void filter_samples(const SampleField& s, const Smoothing& by, size_t first, size_t last,
                    Filtered& out) {
    const VF per_width = hn::Set(f, 1.0f / by.width[0]);
    Surroundings<1> around(s, by, std::span(by.width).first(1));
    each_vector(s, first, last, around, [&](size_t at, size_t n) HWY_ATTR {
        const Sums sums = around.each(
            0, Places(s, at), Sums(), [&](Sums& of, size_t i, VF d2, auto on_surface) HWY_ATTR {
                of.add(on_surface(squared_tent(d2, per_width)), hn::Set(f, s.r[i]),
                       hn::Set(f, s.g[i]), hn::Set(f, s.b[i]));
            });
        const Color mean = sums.over(sums.w);  // 1 at least, the sample's own
        put(sums.w, n, &out.weight[at]);
        put(mean.r, n, &out.r[at]);
        put(mean.g, n, &out.g[at]);
        put(mean.b, n, &out.b[at]);
    });
}

void find_errors(const SampleField& s, const Filtered& filtered, const Smoothing& by, size_t first,
                 size_t last, Changes& out) {
    const VF per_width = hn::Set(f, 1.0f / by.width[0]);
    VF per_square[widths];
    for (size_t k = 0; k < widths; ++k)
        per_square[k] = hn::Set(f, 1.0f / (by.width[k] * by.width[k]));
    const VF one = hn::Set(f, 1.0f), floor = hn::Set(f, by.epsilon * by.epsilon);
    Surroundings<widths> around(s, by, by.width);
    each_vector(s, first, last, around, [&](size_t at, size_t n) HWY_ATTR {
        const Places places(s, at);
        const auto look_near = [&](Sharp& of, size_t i, VF d2, auto on_surface) HWY_ATTR {
            const VF weight = on_surface(squared_tent(d2, per_width));
            const auto doubled =
                [i](std::span<const float> y, std::span<const float> mean)
                    HWY_ATTR { return sharpened(hn::Set(f, y[i]), hn::Set(f, mean[i])); };
            of.sums.add(weight, doubled(s.r, filtered.r), doubled(s.g, filtered.g),
                        doubled(s.b, filtered.b));
            of.overlap = hn::Add(of.overlap,
                                 hn::Div(hn::Mul(weight, weight), hn::Set(f, filtered.weight[i])));
        };
        const Sharp sharp = around.each(0, places, Sharp(), look_near);
        Sums wide[widths];
        // The widths from `least` on, in the rings that they reach.
        const auto look = [&](size_t ring, auto least) HWY_ATTR {
            using Reached = std::array<Sums, widths - least>;
            Reached sums;
            std::copy_n(wide + least, sums.size(), sums.begin());
            sums = around.each_alike(
                ring, places, sums, [&](Reached& of, size_t i, VF d2, auto on_surface) HWY_ATTR {
                    const VF r = hn::Set(f, s.r[i]), g = hn::Set(f, s.g[i]), b = hn::Set(f, s.b[i]);
                    for (size_t k = 0; k < of.size(); ++k)
                        of[k].add(on_surface(paraboloid(d2, per_square[least + k])), r, g, b);
                });
            std::copy_n(sums.begin(), sums.size(), wide + least);
        };
        static_assert(widths == 3);
        look(0, std::integral_constant<size_t, 1>());
        look(1, std::integral_constant<size_t, 1>());
        look(2, std::integral_constant<size_t, 2>());

        Color mean[widths];
        for (size_t k = 1; k < widths; ++k) mean[k] = wide[k].over(wide[k].w);
        const Left left{color_at(s, at), mean[widths - 1]};
        const auto per_level = [&](VF level) HWY_ATTR {
            return hn::Div(one, hn::MulAdd(level, level, floor));
        };
        const Color weights{per_level(left.mean.r), per_level(left.mean.g), per_level(left.mean.b)};
        const VF narrow = hn::LoadU(f, &filtered.weight[at]);
        const Color as_is = left.by(color_at(filtered, at), hn::Div(one, narrow));
        const VF error = squares(as_is, weights);
        const auto put_change = [&](size_t k, const Color& guess, VF share) HWY_ATTR {
            // (One that stands alone says nothing of a treatment.)
            const auto alone = hn::Ge(share, hn::Set(f, 0.999f));
            const Color here = chosen(alone, as_is, left.by(guess, share));
            // Where they differ by rounding only (of two samples, each is predicted by the other),
            // the lesser treatment is the better.
            const VF gain =
                hn::NegMulAdd(hn::Set(f, 1 - 1e-5f * float(k)), error, squares(here, weights));
            put(gain, n, &out.of[k - 1].gain[at]);
            put(squares(here - as_is, weights), n, &out.of[k - 1].way[at]);
        };
        for (size_t k = 1; k < widths; ++k) {
            put_change(k, mean[k], hn::Div(one, wide[k].w));
            put(mean[k].r, n, &out.of[k - 1].r[at]);
            put(mean[k].g, n, &out.of[k - 1].g[at]);
            put(mean[k].b, n, &out.of[k - 1].b[at]);
        }
        // Of H + H (1 - H), with H_ij = w_ij / W_i.
        put_change(widths, sharp.sums.over(narrow),
                   hn::Div(hn::Sub(hn::Set(f, 2.0f), sharp.overlap), narrow));
    });
}

void treat(const SampleField& s, const Filtered& filtered, const Changes& changes,
           const Smoothing& by, size_t first, size_t last, std::span<float> rgb) {
    const VF zero = hn::Zero(f), one = hn::Set(f, 1.0f),
             square = hn::Set(f, by.width[0] * by.width[0]),
             per_window = hn::Set(f, 1.0f / (by.window * by.window));
    Surroundings<2> around(s, by, std::array{by.width[0], by.window});
    each_vector(s, first, last, around, [&](size_t at, size_t n) HWY_ATTR {
        const Places places(s, at);
        const auto weigh = [&](Gains& of, size_t i, VF d2, auto on_surface) HWY_ATTR {
            const VF weight = on_surface(paraboloid(d2, per_window));
            for (size_t k = 0; k < treatments - 1; ++k) {
                const VF gain = hn::Mul(weight, hn::Set(f, changes.of[k].gain[i]));
                of.gain[k] = hn::Add(of.gain[k], gain);
                of.spread[k] = hn::MulAdd(gain, gain, of.spread[k]);
                of.way[k] = hn::MulAdd(weight, hn::Set(f, changes.of[k].way[i]), of.way[k]);
            }
        };
        const Gains gains =
            around.each_alike(1, places, around.each_alike(0, places, Gains(), weigh), weigh);
        VF least = zero, part = zero;
        VU kind = hn::Zero(un);
        for (size_t k = 1; k < treatments; ++k) {
            const VF caution = hn::Set(f, k == widths ? by.sharp_caution : by.caution);
            const VF gain = hn::MulAdd(caution, hn::Sqrt(gains.spread[k - 1]), gains.gain[k - 1]);
            const VF way = gains.way[k - 1];
            // Part a of the way from the sample as it is changes the error by a (gain - way) + a^2
            // way.
            const VF less = hn::Sub(gain, way),
                     a = hn::Min(one, hn::Div(less, hn::Mul(hn::Set(f, -2.0f), way)));
            const VF score = hn::Mul(a, hn::MulAdd(a, way, less));
            const auto better =
                hn::And(hn::And(hn::Lt(less, zero), hn::Gt(way, zero)), hn::Lt(score, least));
            least = hn::IfThenElse(better, score, least);
            part = hn::IfThenElse(better, a, part);
            kind = hn::IfThenElse(hn::RebindMask(un, better), hn::Set(un, std::uint32_t(k)), kind);
        }
        const auto is = [&](size_t k) HWY_ATTR {
            return hn::RebindMask(f, hn::Eq(kind, hn::Set(un, std::uint32_t(k))));
        };
        const Color own = color_at(s, at);
        Color treated = own;
        for (size_t k = 1; k < widths; ++k)
            treated = chosen(is(k), color_at(changes[k], at), treated);
        // (Lanes past the block's end say nothing.)
        if (!hn::AllFalse(f, hn::And(hn::FirstN(f, n), is(widths)))) {
            // Within what its neighbours are, or else one bright sample leaves dark ones around it
            // and grows itself.
            const auto look = [&](std::array<Range, 3>& of, size_t i, VF d2,
                                  auto on_surface) HWY_ATTR {
                const auto near = hn::Gt(on_surface(hn::Sub(square, d2)), zero);
                of[0].add(near, hn::Set(f, s.r[i]));
                of[1].add(near, hn::Set(f, s.g[i]));
                of[2].add(near, hn::Set(f, s.b[i]));
            };
            const auto [red, green, blue] = around.each(0, places, std::array<Range, 3>(), look);
            const Color mean = color_at(filtered, at);
            treated =
                chosen(is(widths),
                       {red.limit(sharpened(own.r, mean.r)), green.limit(sharpened(own.g, mean.g)),
                        blue.limit(sharpened(own.b, mean.b))},
                       treated);
        }
        const Color way = treated - own;
        alignas(64) float r[lanes], g[lanes], b[lanes];
        hn::Store(hn::MulAdd(part, way.r, own.r), f, r);
        hn::Store(hn::MulAdd(part, way.g, own.g), f, g);
        hn::Store(hn::MulAdd(part, way.b, own.b), f, b);
        for (size_t j = 0; j < n; ++j) {
            float* to = &rgb[3 * size_t(s.order[s.first + at + j])];
            to[0] = r[j], to[1] = g[j], to[2] = b[j];
        }
    });
}

}  // namespace weft::light_field::WEFT_ISA
