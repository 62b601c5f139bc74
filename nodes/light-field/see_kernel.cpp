// What reproject, same-surface-cluster, coverage and filter-visible make of a location, in one go.
#include <algorithm>
#include <cmath>

#include "light-field/front_surface.h"
#include "light-field/grid_reach.h"
#include "light-field/kernels.h"
#include "light-field/layers.h"
#include "light-field/location_number.h"
#include "light-field/path_vectors.h"
#include "light-field/projected_entries.h"
#include "light-field/simd.h"
#include "light-field/surrounded.h"
#include "light-field/weighted_mean.h"

namespace weft::light_field::WEFT_ISA {
namespace {

// Whether samples' traits (Projection) differ so little from some model's that no two of them can
// conflict: each byte is the `span` at most below a `top`, counted around a circle of 256.
struct Likeness {
    VU half, span;  // of each byte
    Likeness(std::int32_t slopes, std::int32_t velocities, bool moving) {
        const bool never = slopes < 0 || (moving && velocities < 0);
        const auto bytes = [&](auto&& of) {
            const std::uint32_t slope = of(slopes), velocity = moving ? of(velocities) : of(255);
            return hn::Set(un, never ? 0 : slope | velocity << 8 | velocity << 16);
        };
        half = bytes([](std::int32_t way) { return std::uint32_t(std::max(way, 0) / 2); });
        span = bytes([](std::int32_t way) {
            return way >= 254 ? 255 : std::uint32_t(std::max(way, 0) / 2 * 2);
        });
    }
    HWY_INLINE VU top(std::uint32_t model) const {
        const auto way = hn::BitCast(un8, half), middle = hn::BitCast(un8, hn::Set(un, model));
        return hn::BitCast(un, hn::SaturatedAdd(hn::Max(middle, way), way));
    }
    template <class M>
    HWY_INLINE VU add(VU below, VU top, VU traits, M in) const {
        const VU way = hn::BitCast(un, hn::Sub(hn::BitCast(un8, top), hn::BitCast(un8, traits)));
        const VU counts = hn::IfThenElseZero(hn::RebindMask(un, in), way);
        return hn::BitCast(un, hn::Max(hn::BitCast(un8, below), hn::BitCast(un8, counts)));
    }
    HWY_INLINE bool holds(VU below) const {
        const auto limit = hn::BitCast(un8, span);
        return hn::AllTrue(un8, hn::Eq(hn::Max(hn::BitCast(un8, below), limit), limit));
    }
};

template <int power>
class Seeing {
  public:
    Seeing(const Projection& p, const Locations& at, const SeeSettings& set, SeeScratch& scratch,
           Colors& out, std::uint32_t* nearest)
        : p_(p),
          h_(*p.hierarchy),
          at_(at),
          set_(set),
          c_(scratch),
          out_(out),
          nearest_(nearest),
          weight_(set.tent.radius),
          limit_(hn::Set(f, set.radius * set.radius)),
          near_(hn::Set(f, set.cover_radius * set.cover_radius)),
          enough_(thin_near * samples_in(set.cover_radius, h_)) {
        // No two candidates can conflict where their spread (Candidates::spread) is at most this.
        const auto bound = [&](float way, float step) {
            return std::int32_t(std::floor(std::clamp(
                way > 0 ? set.test.tolerance / (way * step) - 1.0f : 1e9f, -1.0f, 255.0f)));
        };
        slopes_ = bound(set.test.box * std::max(1.0f, h_.lens.aspect), p.slope_step);
        velocities_ = bound(0.5f * set.test.box, p.velocity_step);
        c_.visibility.decision.assign(at.size(), Decision::one);
        for (auto* values : {&c_.cell, &c_.across, &c_.rows}) values->resize(at.size() + lanes);
        find_reach(p, at.x.data(), at.y.data(), at.size(), set.radius,
                   {c_.cell.data(), c_.across.data(), c_.rows.data()});
    }

    // First look: most locations have one surface only.
    void look() {
        if (alike(p_.spread))
            nearest_ ? look_at_each<false, true>() : look_at_each<false, false>();
        else
            nearest_ ? look_at_each<true, true>() : look_at_each<true, false>();
        for (size_t i = 0; i < c_.open.size(); ++i) settle_front(c_.open[i], c_.colored[i]);
    }

    // Final look, with samples from farther around.
    void look_finally() {
        for (size_t l = 0; l < at_.size(); ++l) settle(l);
    }

  private:
    // `each`: surfaces are asked about location by location; else no two samples of the projection
    // can be told apart. `nearest`: which sample is nearest is asked too.
    template <bool each, bool nearest>
    void look_at_each() {
        constexpr size_t usual = Projection::padding;
        const size_t n = at_.size(), pitch = size_t(p_.columns) + 1;
        const Projection::Entry* entries = p_.entries.data();
        const float *rgba = p_.rgba.data(), *at_x = at_.x.data(), *at_y = at_.y.data();
        const std::uint32_t* start = p_.start.data();
        const Likeness likeness(slopes_, velocities_, h_.moving);
        c_.open.resize(n);
        c_.colored.resize(n);
        std::uint32_t* opens = c_.open.data();
        std::uint8_t* colors = c_.colored.data();
        float* to = out_.rgba.data();
        const VF limit = limit_;
        const TentWeight<power> tent = weight_;
        const bool opaque = h_.opaque;
        size_t open = 0;
        std::uint64_t looked_at = 0;
        for (size_t l = 0; l < n; ++l, to += 4) {
            const std::uint32_t* row = start + c_.cell[l];
            const size_t across = c_.across[l], rows = c_.rows[l];
            const VF x = hn::Set(f, at_x[l]), y = hn::Set(f, at_y[l]);
            VU top = hn::Zero(un), below = top;
            // The model is one of those about the middle, which as a rule is like all others. (If
            // its traits do not fit, the fourth byte, it is like none.)
            if constexpr (each)
                top = likeness.top(entries[row[rows / 2 * pitch + across / 2]].traits & 0xffffff);
            Sums sums;
            VF least = limit;
            VU found = hn::Set(un, none);
            const auto add = [&](size_t i) HWY_ATTR {
                const EntryVectors entry(entries + i);
                const VF d2 = squared(hn::Sub(x, entry.x()), hn::Sub(y, entry.y()));
                if constexpr (each)
                    below = likeness.add(below, top, entry.traits(), hn::Lt(d2, limit));
                if constexpr (nearest) {
                    const auto nearer = hn::RebindMask(un, hn::Lt(d2, least));
                    found = hn::IfThenElse(nearer, hn::Set(un, std::uint32_t(i)), found);
                    least = hn::Min(least, d2);
                }
                sums.add(tent(d2), rgba + 4 * i);
            };
            // Most rows hold no more than is usual: what is beyond is left for the end.
            const std::uint32_t* last = row + rows * pitch;
            std::uint32_t longest = 0;
            for (const std::uint32_t* of = row; of != last; of += pitch) {
                for (size_t done = 0; done < usual; done += lanes) add(of[0] + done);
                longest = std::max(longest, of[across] - of[0]);
                looked_at += of[across] - of[0];
            }
            for (; longest > usual && row != last; row += pitch)
                for (size_t i = row[0] + usual; i < row[across]; i += lanes) add(i);
            if constexpr (nearest) nearest_[l] = nearest_of(least, found, entries);
            const bool colored = sums.mean(opaque, to) > 0;
            // No branch: it would be known late, and often be foreseen wrongly.
            opens[open] = std::uint32_t(l);
            colors[open] = colored;
            open += !(colored & (!each || likeness.holds(below)));
        }
        std::fill_n(out_.valid.begin(), n, std::uint8_t(1));
        c_.open.resize(open);
        c_.colored.resize(open);
        out_.candidates += looked_at;
    }

    // The sample of the least distance, given how far it is in each lane and in which entries it
    // was found there; of equal ones the first.
    HWY_INLINE static std::uint32_t nearest_of(VF least, VU found,
                                               const Projection::Entry* entries) {
        alignas(64) std::uint32_t first[lanes];
        hn::Store(found, un, first);
        std::uint32_t entry = none;
        for (unsigned bits = bits_of(f, hn::Eq(least, hn::MinOfLanes(f, least))); bits;
             bits &= bits - 1) {
            const size_t lane = size_t(__builtin_ctz(bits));
            if (first[lane] == none) break;  // nothing is within the limit, here nor elsewhere
            entry = std::min(entry, first[lane] + std::uint32_t(lane % 4 * (lanes / 4) + lane / 4));
        }
        return entry == none ? none : entries[entry].sample;
    }

    bool still(std::uint32_t spread) const {
        return !h_.moving ||
               (spread != 0xffffffffu && std::int32_t(spread >> 8 & 255) <= velocities_ &&
                std::int32_t(spread >> 16 & 255) <= velocities_);
    }
    bool alike(std::uint32_t spread) const {
        return spread != 0xffffffffu && still(spread) && std::int32_t(spread & 255) <= slopes_;
    }

    // The candidates of location l, side by side; their spread.
    std::uint32_t gather(size_t l) {
        const size_t pitch = size_t(p_.columns) + 1, across = c_.across[l];
        const std::uint32_t* first = p_.start.data() + c_.cell[l];
        const std::uint32_t* last = first + (c_.rows[l] - 1) * pitch;
        size_t most = 4 * lanes;
        for (const std::uint32_t* row = first; row <= last; row += pitch)
            most += row[across] - row[0];
        c_.grow(most);
        const VF at_x = hn::Set(f, at_.x[l]), at_y = hn::Set(f, at_.y[l]);
        Spread spread;
        n_ = 0;
        for (const std::uint32_t* row = first; row <= last; row += pitch)
            for (size_t i = row[0]; i < row[across]; i += lanes) {
                const EntryVectors entries(&p_.entries[i]);
                const VF dx = hn::Sub(in_order(entries.x()), at_x),
                         dy = hn::Sub(in_order(entries.y()), at_y);
                const auto in = hn::Lt(squared(dx, dy), limit_);
                const Pack pack(in);
                pack.store(dx, &c_.found_x[n_]);
                pack.store(dy, &c_.found_y[n_]);
                pack.store(in_order(entries.sample()), &c_.found[n_]);
                spread.add(in_order(entries.traits()), in);
                n_ += pack.count;
            }
        return n_ ? spread.between() : 0;
    }

    // Puts the candidates in order of depth, with what they do at the location.
    Layers layers(size_t l, std::uint32_t spread) {
        const float u = p_.u, v = p_.v, box = set_.test.box;
        const bool moving = !still(spread);
        const VF c0 = hn::Set(f, h_.lens.c0 * box), c1 = hn::Set(f, h_.lens.c1 * box),
                 one = hn::Set(f, 1.0f);
        const VF time = hn::Set(f, p_.t - 0.5f), way = hn::Set(f, 0.5f * box);
        const VF at_x = hn::Set(f, at_.x[l] - h_.lens.c1 * u * h_.lens.aspect),
                 at_y = hn::Set(f, at_.y[l] - h_.lens.c1 * v);
        for (size_t i = 0; i < n_; i += lanes) {
            VF depth;
            if (h_.moving) {
                const PathVectors path(h_.paths.data(), &c_.found[i], n_ - i);
                depth = hn::MulAdd(time, path.VW, path.W);
                if (moving) {
                    const VF inverse = hn::Div(way, depth);
                    const VF x = hn::Add(at_x, hn::LoadU(f, &c_.found_x[i])),
                             y = hn::Add(at_y, hn::LoadU(f, &c_.found_y[i]));
                    hn::StoreU(hn::Mul(inverse, hn::NegMulAdd(path.VW, x, path.VX)), f,
                               &c_.found_velocity_x[i]);
                    hn::StoreU(hn::Mul(inverse, hn::NegMulAdd(path.VW, y, path.VY)), f,
                               &c_.found_velocity_y[i]);
                }
            } else {
                depth = hn::GatherIndex(f, h_.W.data(), samples_of(&c_.found[i], n_ - i));
            }
            hn::StoreU(depth, f, &c_.found_depth[i]);
            hn::StoreU(hn::MulAdd(c0, hn::Div(one, depth), c1), f, &c_.found_slope[i]);
        }
        rank_by_depth(c_.found_depth.data(), n_, c_.rank.data());
        for (size_t i = 0; i < n_; ++i) {
            const size_t to = c_.rank[i];
            c_.x[to] = c_.found_x[i];
            c_.y[to] = c_.found_y[i];
            c_.slope[to] = c_.found_slope[i];
            c_.sample[to] = c_.found[i];
        }
        for (size_t i = 0; i < n_ && moving; ++i) {
            const size_t to = c_.rank[i];
            c_.velocity_x[to] = c_.found_velocity_x[i];
            c_.velocity_y[to] = c_.found_velocity_y[i];
        }
        return {c_, n_, h_.lens.aspect, set_.test.tolerance, moving};
    }

    // The front surface, if it is the only one or surrounds the location. `colored`: the colour of
    // all is there.
    void settle_front(size_t l, bool colored) {
        const std::uint32_t spread = gather(l);
        if (n_ == 0) return leave(l);
        if (n_ < 2 || alike(spread)) {
            if (!colored) filter(l, c_.found_x.data(), c_.found_y.data(), c_.found.data(), n_);
            return;
        }
        if (n_ <= 2 * lanes)
            return still(spread) ? settle_few<false>(l, colored) : settle_few<true>(l, colored);
        const size_t end = layers(l, spread).next(0);
        if (end == n_ && colored) return;
        if (end == n_) return filter(l, c_.x.data(), c_.y.data(), c_.sample.data(), n_);
        Hull hull;
        size_t near = 0;
        for (size_t i = 0; i < end; i += lanes) {
            const VF x = hn::LoadU(f, &c_.x[i]), y = hn::LoadU(f, &c_.y[i]);
            hull.add(x, y, hn::FirstN(f, end - i));
            near += hn::CountTrue(f, hn::And(hn::FirstN(f, end - i), hn::Lt(squared(x, y), near_)));
        }
        if (float(near) < enough_ || !hull.inside()) return leave(l);
        c_.visibility.decision[l] = Decision::covered;
        filter(l, c_.x.data(), c_.y.data(), c_.sample.data(), end);
    }

    template <bool moving>
    void settle_few(size_t l, bool colored) {
        if (n_ <= lanes)
            settle_front_of<moving, 1>(l, colored);
        else
            settle_front_of<moving, 2>(l, colored);
    }

    // As settle_front, of candidates few enough for `vectors` vectors.
    template <bool moving, size_t vectors>
    void settle_front_of(size_t l, bool colored) {
        const FrontSurface<moving, vectors> front(p_, at_, l, set_.test, n_, c_);
        if (front.all && colored) return;
        if (!front.all) {
            Hull hull;
            size_t near = 0;
            for (size_t k = 0; k < vectors; ++k) {
                const VF x = front.x[k], y = front.y[k];
                hull.add(x, y, front.seen[k]);
                near += hn::CountTrue(f, hn::And(front.seen[k], hn::Lt(squared(x, y), near_)));
            }
            if (float(near) < enough_ || !hull.inside()) return leave(l);
            c_.visibility.decision[l] = Decision::covered;
        }
        size_t n = 0;
        for (size_t k = 0; k < vectors; ++k) {
            const Pack pack(front.seen[k]);
            pack.store(front.x[k], &c_.x[n]);
            pack.store(front.y[k], &c_.y[n]);
            pack.store(hn::LoadU(un, &c_.found[k * lanes]), &c_.sample[n]);
            n += pack.count;
        }
        filter(l, c_.x.data(), c_.y.data(), c_.sample.data(), n);
    }

    // Front to back: the first surface that surrounds the location, else the last; thin ones before
    // it by the part of the location that they cover.
    void settle(size_t l) {
        const std::uint32_t spread = gather(l);
        out_.candidates += n_;
        if (n_ == 0) return leave(l);
        if (n_ < 2 || alike(spread))
            return filter(l, c_.found_x.data(), c_.found_y.data(), c_.found.data(), n_);
        const Layers layer = layers(l, spread);
        float left = 1, sum[4] = {};
        // Of several surfaces one is chosen, as often as its share says.
        float until = nearest_ ? location_number(at_.x[l], at_.y[l], p_.u, p_.t) : 0;
        std::uint32_t chosen = none;
        for (size_t first = 0, end = 0; left > 0; first = end) {
            end = layer.next(first);
            const bool last = end == n_;
            const float share = last ? left : left * part_covered(first, end);
            if (share > 0) {
                filter(l, &c_.x[first], &c_.y[first], &c_.sample[first], end - first);
                if (nearest_ && until >= 0) chosen = nearest_[l];
                until -= share;
                for (size_t k = 0; k < 4; ++k) sum[k] += share * out_.rgba[4 * l + k];
                left -= share;
            }
            if (last) break;
        }
        std::copy_n(sum, 4, &out_.rgba[4 * l]);
        if (nearest_) nearest_[l] = chosen;
    }

    // How much of the location candidates [first, end) cover, a surface.
    float part_covered(size_t first, size_t end) {
        const float radius = set_.cover_radius;
        const VF wide = hn::Set(f, 4 * radius * radius), per_radius = hn::Set(f, 1 / radius);
        VF sum = hn::Zero(f);
        size_t around = 0;
        for (size_t i = first; i < end; i += lanes) {
            const auto in = hn::FirstN(f, end - i);
            const VF d2 = squared(hn::LoadU(f, &c_.x[i]), hn::LoadU(f, &c_.y[i]));
            around += hn::CountTrue(f, hn::And(in, hn::Lt(d2, wide)));
            const VF tent =
                hn::Max(hn::Zero(f), hn::NegMulAdd(hn::Sqrt(d2), per_radius, hn::Set(f, 1.0f)));
            sum = hn::Add(sum, hn::IfThenElseZero(in, hn::Mul(tent, tent)));
        }
        if (float(around) >= thin_around * samples_in(2 * radius, h_))
            return surrounds(first, end) ? 1.0f : 0.0f;
        return std::min(1.0f, hn::GetLane(hn::SumOfLanes(f, sum)) /
                                  (squared_tent_mean * samples_in(radius, h_)));
    }

    // Whether candidates [first, end) surround the location.
    bool surrounds(size_t first, size_t end) {
        size_t near = 0, n = 0;
        const VF limit = hn::Set(f, set_.cover_radius * set_.cover_radius);
        float *x = c_.coverage.x.data(), *y = c_.coverage.y.data();
        for (const bool inside : {true, false}) {
            for (size_t i = first; i < end; i += lanes) {
                const VF dx = hn::LoadU(f, &c_.x[i]), dy = hn::LoadU(f, &c_.y[i]);
                const auto within = hn::Le(squared(dx, dy), limit);
                const Pack pack(hn::And(hn::FirstN(f, end - i), inside ? within : hn::Not(within)));
                pack.store(dx, x + n);
                pack.store(dy, y + n);
                n += pack.count;
            }
            if (inside) near = n;
        }
        return surrounded(x, y, near, n, set_.cover_radius, c_.coverage);
    }

    // Writes the mean of n samples under the tent; where all weights vanish, the nearest's colour.
    void filter(size_t l, const float* x, const float* y, const std::uint32_t* sample, size_t n) {
        size_t seen = 0;
        if (nearest_) nearest_[l] = sample[nearest(x, y, n)];
        for (size_t i = 0; i < n; i += lanes) {
            const VF weight = weight_(squared(hn::LoadU(f, x + i), hn::LoadU(f, y + i)));
            const Pack pack(hn::And(hn::FirstN(f, n - i), hn::Gt(weight, hn::Zero(f))));
            pack.store(weight, &c_.weight[seen]);
            pack.store(hn::LoadU(un, sample + i), &c_.seen[seen]);
            seen += pack.count;
        }
        float* to = &out_.rgba[4 * l];
        out_.valid[l] = 1;
        if (seen == 0)
            write_nearest(h_.rgba.data(), sample, x, y, n, to);
        else
            write_mean(h_.rgba.data(), c_.seen.data(), c_.weight.data(), seen, to);
    }

    void leave(size_t l) {
        std::fill_n(&out_.rgba[4 * l], 4, 0.0f);
        out_.valid[l] = 0;
        c_.visibility.decision[l] = Decision::undecided;
        if (nearest_) nearest_[l] = none;
    }

    static constexpr std::uint32_t none = 0xffffffff;
    const Projection& p_;
    const Hierarchy& h_;
    const Locations& at_;
    const SeeSettings& set_;
    SeeScratch& c_;
    Colors& out_;
    std::uint32_t* nearest_;
    const TentWeight<power> weight_;
    const VF limit_, near_;
    const float
        enough_;  // samples of a surface that is not too thin to be seen to surround a location
    std::int32_t slopes_ = 0, velocities_ = 0;
    size_t n_ = 0;  // candidates of the location at hand
};

template <int power>
void see_all(const Projection& p, const Locations& at, const SeeSettings& set, SeeScratch& scratch,
             Colors& out, std::uint32_t* nearest) {
    Seeing<power> seeing(p, at, set, scratch, out, nearest);
    if (set.final)
        seeing.look_finally();
    else
        seeing.look();
}

}  // namespace

void see(const Projection& p, const Locations& at, const SeeSettings& set, SeeScratch& scratch,
         Colors& out, std::uint32_t* nearest) {
    const size_t n = at.size();
    out.rgba.resize(4 * n);
    out.valid.resize(n);
    out.color_space = &p.hierarchy->color_space;
    out.candidates = 0;
    if (set.tent.exponent == 1)
        see_all<1>(p, at, set, scratch, out, nearest);
    else if (set.tent.exponent == 2)
        see_all<2>(p, at, set, scratch, out, nearest);
    else
        see_all<4>(p, at, set, scratch, out, nearest);
}

}  // namespace weft::light_field::WEFT_ISA
