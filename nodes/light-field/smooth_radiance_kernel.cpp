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
HWY_INLINE void put(const Color& value, size_t n, const Rgb& to, size_t at) {
    put(value.r, n, &to.r[at]), put(value.g, n, &to.g[at]), put(value.b, n, &to.b[at]);
}
// Of a vector of samples from `at` on.
HWY_INLINE Color color_at(const Rgb& of, size_t at) {
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

// Of one sample, for all places.
HWY_INLINE Color color_of(const Rgb& of, size_t i) {
    return {hn::Set(f, of.r[i]), hn::Set(f, of.g[i]), hn::Set(f, of.b[i])};
}

// Weighted sums of radiances.
template <size_t colors>
struct Sums {
    VF w = hn::Zero(f);
    std::array<Color, colors> of;
    Sums() { of.fill({hn::Zero(f), hn::Zero(f), hn::Zero(f)}); }
    HWY_INLINE void add(size_t c, VF weight, const Color& color) {
        of[c] = {hn::MulAdd(weight, color.r, of[c].r), hn::MulAdd(weight, color.g, of[c].g),
                 hn::MulAdd(weight, color.b, of[c].b)};
    }
    HWY_INLINE void add(VF weight, const std::array<Color, colors>& all) {
        w = hn::Add(w, weight);
        for (size_t c = 0; c < colors; ++c) add(c, weight, all[c]);
    }
    HWY_INLINE Color over(size_t c, VF all) const {
        return {hn::Div(of[c].r, all), hn::Div(of[c].g, all), hn::Div(of[c].b, all)};
    }
};

// Sums of sharpened radiance, and of the weights' share in those of the samples they are of.
template <size_t colors>
struct Sharp {
    Sums<colors> sums;
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
HWY_INLINE Color sharpened(const Color& y, const Color& mean) {
    const VF two = hn::Set(f, 2.0f);
    return {hn::MulSub(two, y.r, mean.r), hn::MulSub(two, y.g, mean.g), hn::MulSub(two, y.b, mean.b)};
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

template <size_t colors>
void filter_all(const SampleField& s, const Smoothing& by, size_t first, size_t last,
                Filtered& out) {
    const VF per_width = hn::Set(f, 1.0f / by.width[0]);
    Surroundings<1> around(s, by, std::span(by.width).first(1));
    each_vector(s, first, last, around, [&](size_t at, size_t n) HWY_ATTR {
        const Sums<colors> sums = around.each(
            0, Places(s, at), Sums<colors>(),
            [&](Sums<colors>& of, size_t i, VF d2, auto on_surface) HWY_ATTR {
                const VF weight = on_surface(squared_tent(d2, per_width));
                of.w = hn::Add(of.w, weight);
                for (size_t c = 0; c < colors; ++c) of.add(c, weight, color_of(s.color[c], i));
            });
        put(sums.w, n, &out.weight[at]);  // 1 at least, the sample's own
        for (size_t c = 0; c < colors; ++c) put(sums.over(c, sums.w), n, out.color[c], at);
    });
}

template <size_t colors>
void find_all_errors(const SampleField& s, const Filtered& filtered, const Smoothing& by,
                     size_t first, size_t last, Changes& out) {
    const VF per_width = hn::Set(f, 1.0f / by.width[0]);
    VF per_square[widths];
    for (size_t k = 0; k < widths; ++k)
        per_square[k] = hn::Set(f, 1.0f / (by.width[k] * by.width[k]));
    const VF one = hn::Set(f, 1.0f);
    Surroundings<widths> around(s, by, by.width);
    each_vector(s, first, last, around, [&](size_t at, size_t n) HWY_ATTR {
        const Places places(s, at);
        using Near = Sharp<colors>;
        const auto look_near = [&](Near& of, size_t i, VF d2, auto on_surface) HWY_ATTR {
            const VF weight = on_surface(squared_tent(d2, per_width));
            for (size_t c = 0; c < colors; ++c)
                of.sums.add(c, weight,
                            sharpened(color_of(s.color[c], i), color_of(filtered.color[c], i)));
            of.overlap = hn::Add(of.overlap,
                                 hn::Div(hn::Mul(weight, weight), hn::Set(f, filtered.weight[i])));
        };
        const Near sharp = around.each(0, places, Near(), look_near);
        Sums<colors> wide[widths];
        // The widths from `least` on, in the rings that they reach.
        const auto look = [&](size_t ring, auto least) HWY_ATTR {
            using Reached = std::array<Sums<colors>, widths - least>;
            Reached sums;
            std::copy_n(wide + least, sums.size(), sums.begin());
            sums = around.each_alike(
                ring, places, sums, [&](Reached& of, size_t i, VF d2, auto on_surface) HWY_ATTR {
                    std::array<Color, colors> here;
                    for (size_t c = 0; c < colors; ++c) here[c] = color_of(s.color[c], i);
                    for (size_t k = 0; k < of.size(); ++k)
                        of[k].add(on_surface(paraboloid(d2, per_square[least + k])), here);
                });
            std::copy_n(sums.begin(), sums.size(), wide + least);
        };
        static_assert(widths == 3);
        look(0, std::integral_constant<size_t, 1>());
        look(1, std::integral_constant<size_t, 1>());
        look(2, std::integral_constant<size_t, 2>());

        const VF narrow = hn::LoadU(f, &filtered.weight[at]);
        for (size_t c = 0; c < colors; ++c) {
            Color mean[widths];
            for (size_t k = 1; k < widths; ++k) mean[k] = wide[k].over(c, wide[k].w);
            const Left left{color_at(s.color[c], at), mean[widths - 1]};
            const VF floor = hn::Set(f, by.epsilon[c] * by.epsilon[c]);
            const auto per_level = [&](VF level) HWY_ATTR {
                return hn::Div(one, hn::MulAdd(level, level, floor));
            };
            const Color weights{per_level(left.mean.r), per_level(left.mean.g),
                                per_level(left.mean.b)};
            const Color as_is =
                left.by(color_at(filtered.color[c], at), hn::Div(one, narrow));
            const VF error = squares(as_is, weights);
            const auto put_change = [&](size_t k, const Color& guess, VF share) HWY_ATTR {
                // (One that stands alone says nothing of a treatment.)
                const auto alone = hn::Ge(share, hn::Set(f, 0.999f));
                const Color here = chosen(alone, as_is, left.by(guess, share));
                // Where they differ by rounding only (of two samples, each is predicted by the
                // other), the lesser treatment is the better.
                const VF gain =
                    hn::NegMulAdd(hn::Set(f, 1 - 1e-5f * float(k)), error, squares(here, weights));
                put(gain, n, &out.color[c][k - 1].gain[at]);
                put(squares(here - as_is, weights), n, &out.color[c][k - 1].way[at]);
            };
            for (size_t k = 1; k < widths; ++k) {
                put_change(k, mean[k], hn::Div(one, wide[k].w));
                put(mean[k], n, out.color[c][k - 1], at);
            }
            // Of H + H (1 - H), with H_ij = w_ij / W_i.
            put_change(widths, sharp.sums.over(c, narrow),
                       hn::Div(hn::Sub(hn::Set(f, 2.0f), sharp.overlap), narrow));
        }
    });
}

template <size_t colors>
void treat_all(const SampleField& s, const Filtered& filtered, const Changes& changes,
               const Smoothing& by, size_t first, size_t last, std::span<float>* rgb) {
    const VF zero = hn::Zero(f), one = hn::Set(f, 1.0f),
             square = hn::Set(f, by.width[0] * by.width[0]),
             per_window = hn::Set(f, 1.0f / (by.window * by.window));
    Surroundings<2> around(s, by, std::array{by.width[0], by.window});
    each_vector(s, first, last, around, [&](size_t at, size_t n) HWY_ATTR {
        const Places places(s, at);
        using All = std::array<Gains, colors>;
        const auto weigh = [&](All& of, size_t i, VF d2, auto on_surface) HWY_ATTR {
            const VF weight = on_surface(paraboloid(d2, per_window));
            for (size_t c = 0; c < colors; ++c)
                for (size_t k = 0; k < treatments - 1; ++k) {
                    const Change& change = changes.color[c][k];
                    const VF gain = hn::Mul(weight, hn::Set(f, change.gain[i]));
                    of[c].gain[k] = hn::Add(of[c].gain[k], gain);
                    of[c].spread[k] = hn::MulAdd(gain, gain, of[c].spread[k]);
                    of[c].way[k] = hn::MulAdd(weight, hn::Set(f, change.way[i]), of[c].way[k]);
                }
        };
        const All all = around.each_alike(1, places, around.each_alike(0, places, All(), weigh), weigh);
        for (size_t c = 0; c < colors; ++c) {
            const Gains& gains = all[c];
            const Rgb& given = s.color[c];
            VF least = zero, part = zero;
            VU kind = hn::Zero(un);
            for (size_t k = 1; k < treatments; ++k) {
                const VF caution = hn::Set(f, k == widths ? by.sharp_caution : by.caution);
                const VF gain =
                    hn::MulAdd(caution, hn::Sqrt(gains.spread[k - 1]), gains.gain[k - 1]);
                const VF way = gains.way[k - 1];
                // Part a of the way from the sample as it is changes the error by a (gain - way) +
                // a^2 way.
                const VF less = hn::Sub(gain, way),
                         a = hn::Min(one, hn::Div(less, hn::Mul(hn::Set(f, -2.0f), way)));
                const VF score = hn::Mul(a, hn::MulAdd(a, way, less));
                const auto better =
                    hn::And(hn::And(hn::Lt(less, zero), hn::Gt(way, zero)), hn::Lt(score, least));
                least = hn::IfThenElse(better, score, least);
                part = hn::IfThenElse(better, a, part);
                kind =
                    hn::IfThenElse(hn::RebindMask(un, better), hn::Set(un, std::uint32_t(k)), kind);
            }
            const auto is = [&](size_t k) HWY_ATTR {
                return hn::RebindMask(f, hn::Eq(kind, hn::Set(un, std::uint32_t(k))));
            };
            const Color own = color_at(given, at);
            Color treated = own;
            for (size_t k = 1; k < widths; ++k)
                treated = chosen(is(k), color_at(changes.color[c][k - 1], at), treated);
            // (Lanes past the block's end say nothing.)
            if (!hn::AllFalse(f, hn::And(hn::FirstN(f, n), is(widths)))) {
                // Within what its neighbours are, or else one bright sample leaves dark ones around
                // it and grows itself.
                const auto look = [&](std::array<Range, 3>& of, size_t i, VF d2,
                                      auto on_surface) HWY_ATTR {
                    const auto near = hn::Gt(on_surface(hn::Sub(square, d2)), zero);
                    const Color here = color_of(given, i);
                    of[0].add(near, here.r);
                    of[1].add(near, here.g);
                    of[2].add(near, here.b);
                };
                const auto [red, green, blue] =
                    around.each(0, places, std::array<Range, 3>(), look);
                const Color sharp = sharpened(own, color_at(filtered.color[c], at));
                treated = chosen(is(widths),
                                 {red.limit(sharp.r), green.limit(sharp.g), blue.limit(sharp.b)},
                                 treated);
            }
            const Color way = treated - own;
            alignas(64) float r[lanes], g[lanes], b[lanes];
            hn::Store(hn::MulAdd(part, way.r, own.r), f, r);
            hn::Store(hn::MulAdd(part, way.g, own.g), f, g);
            hn::Store(hn::MulAdd(part, way.b, own.b), f, b);
            for (size_t j = 0; j < n; ++j) {
                float* to = &rgb[c][3 * size_t(s.order[s.first + at + j])];
                to[0] = r[j], to[1] = g[j], to[2] = b[j];
            }
        }
    });
}

}  // namespace

void filter_samples(const SampleField& s, const Smoothing& by, size_t first, size_t last,
                    Filtered& out) {
    s.colors == 1 ? filter_all<1>(s, by, first, last, out) : filter_all<2>(s, by, first, last, out);
}
void find_errors(const SampleField& s, const Filtered& filtered, const Smoothing& by, size_t first,
                 size_t last, Changes& out) {
    s.colors == 1 ? find_all_errors<1>(s, filtered, by, first, last, out)
                  : find_all_errors<2>(s, filtered, by, first, last, out);
}
void treat(const SampleField& s, const Filtered& filtered, const Changes& changes,
           const Smoothing& by, size_t first, size_t last, std::span<float>* rgb) {
    s.colors == 1 ? treat_all<1>(s, filtered, changes, by, first, last, rgb)
                  : treat_all<2>(s, filtered, changes, by, first, last, rgb);
}

}  // namespace weft::light_field::WEFT_ISA
