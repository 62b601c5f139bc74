// A light sample j and a receiver r, as a point l of the light sees them, are
//   D(l) = D(0) + C0 (1/w_j - 1/w_r) l
// apart on its film; so all ways from the light to a receiver are a cone of film and 1/w, and its
// samples are those within R of it. Of these the ones stop light that lie before the receiver's
// plane (Planes::before), which with h = d(1/w_r)/dq and g = 1 + C0 h.l is
//   1/w_j - 1/w_r - h.D(0) > g (bias + px |D(l)|) / w_r:
// the left side is the same from everywhere. Here |D(l)| and g are the least that they may be.
#include "shadows/lit_receivers_kernel.h"

#include <algorithm>
#include <cmath>

#include "light-field/path_vectors.h"
#include "light-field/simd.h"

namespace weft::shadows::WEFT_ISA {
namespace {
using namespace light_field::WEFT_ISA;

// Whether bounds may come near receivers, which have bounds themselves.
struct NearTest {
    VF left, right, top, bottom, far, least, behind, reach, c0x, c0y;
    NearTest(const LitSettings& set, const StillReceiver& r)
        : left(hn::Set(f, r.x_low)),
          right(hn::Set(f, r.x_high)),
          top(hn::Set(f, r.y_low)),
          bottom(hn::Set(f, r.y_high)),
          far(hn::Set(f, r.far)),
          least(hn::Set(f, r.far - r.behind)),
          behind(hn::Set(f, r.behind)),
          reach(hn::Set(f, r.radius)),
          c0x(hn::Set(f, set.c0x)),
          c0y(hn::Set(f, set.c0y)) {}
    HWY_INLINE hn::Mask<F> operator()(const LightBounds& b, size_t i) const {
        const VF nearest = hn::LoadU(f, &b.nearest[i]),
                 before = hn::Max(hn::Sub(nearest, far), behind);
        const VF across = hn::MulAdd(c0x, before, reach), down = hn::MulAdd(c0y, before, reach);
        const auto in_x =
            hn::And(hn::Le(hn::LoadU(f, &b.x_low[i]), hn::Add(right, across)),
                    hn::Ge(hn::LoadU(f, &b.x_high[i]), hn::Sub(left, across)));
        const auto in_y =
            hn::And(hn::Le(hn::LoadU(f, &b.y_low[i]), hn::Add(bottom, down)),
                    hn::Ge(hn::LoadU(f, &b.y_high[i]), hn::Sub(top, down)));
        return hn::And(hn::And(in_x, in_y), hn::Ge(nearest, least));
    }
};

// Whether anything that groups hold may stand before a receiver, wherever it is: by the plane before
// which nothing of them lies. Most of what is not far is of the receiver's own surface, and does not.
struct StopTest {
    VF x, y, x_range, y_range, slope_x, slope_y, least;
    StopTest(const LitSettings& set, const StillReceiver& r)
        : x(hn::Set(f, 0.5f * (r.x_low + r.x_high))),
          y(hn::Set(f, 0.5f * (r.y_low + r.y_high))),
          x_range(hn::Set(f, 0.5f * (r.x_high - r.x_low))),
          y_range(hn::Set(f, 0.5f * (r.y_high - r.y_low))),
          slope_x(hn::Set(f, r.slope_x)),
          slope_y(hn::Set(f, r.slope_y)),
          least(hn::Set(f, r.far + r.far * (r.turn * set.bias - rounding))) {}
    HWY_INLINE hn::Mask<F> operator()(const LightBounds& b, size_t i) const {
        const auto off = [](VF low, VF high, VF at, VF range, VF slope, VF rise) HWY_ATTR {
            const VF half = hn::Set(f, 0.5f), middle = hn::Mul(half, hn::Add(low, high)),
                     side = hn::Mul(half, hn::Sub(high, low));
            return hn::Sub(hn::MulAdd(hn::Abs(hn::Sub(rise, slope)), side, hn::Mul(hn::Abs(slope), range)),
                           hn::Mul(slope, hn::Sub(middle, at)));
        };
        const auto load = [i](const std::vector<float>& from) HWY_ATTR { return hn::LoadU(f, &from[i]); };
        const VF off_x = off(load(b.x_low), load(b.x_high), x, x_range, slope_x, load(b.rise_x)),
                 off_y = off(load(b.y_low), load(b.y_high), y, y_range, slope_y, load(b.rise_y));
        // (What is not known may.)
        return hn::Not(hn::Le(hn::Add(load(b.top), hn::Add(off_x, off_y)), least));
    }

  private:
    static constexpr float rounding = 1e-6f;  // of these numbers
};

// What holds them all.
StillReceiver around(std::span<const StillReceiver> receivers) {
    StillReceiver all = receivers[0];
    for (const StillReceiver& r : receivers.subspan(1)) {
        all.x_low = std::min(all.x_low, r.x_low), all.x_high = std::max(all.x_high, r.x_high);
        all.y_low = std::min(all.y_low, r.y_low), all.y_high = std::max(all.y_high, r.y_high);
        all.far = std::min(all.far, r.far), all.near = std::max(all.near, r.near);
        all.radius = std::max(all.radius, r.radius);
        all.behind = std::max(all.behind, r.behind);
    }
    all.behind += all.near - all.far;
    return all;
}

// The groups that may come near.
void collect(std::span<const LightBounds> levels, const NearTest& test, LitScratch& scratch) {
    auto &open = scratch.open, &below = scratch.below;
    const LightBounds &top = levels.back(), &groups = levels[0];
    open.clear();
    for (size_t i = 0; i < top.size; i += lanes)
        for (unsigned bits = bits_of(f, test(top, i)); bits; bits &= bits - 1)
            open.push_back(std::uint32_t(i) + std::uint32_t(__builtin_ctz(bits)));
    for (size_t level = levels.size() - 2; level > 0; --level, std::swap(open, below)) {
        below.clear();
        for (const std::uint32_t of : open)
            for (size_t i = of * Hierarchy::fan_out; i < (of + 1) * Hierarchy::fan_out; i += lanes)
                for (unsigned bits = bits_of(f, test(levels[level], i)); bits; bits &= bits - 1)
                    below.push_back(std::uint32_t(i) + std::uint32_t(__builtin_ctz(bits)));
    }
    LightBounds& found = scratch.near;
    const size_t most = open.size() * Hierarchy::fan_out;
    if (found.x_low.size() < most + LightBounds::spare) found.resize(2 * most);
    size_t n = 0;
    for (const std::uint32_t of : open)
        for (size_t g = of * Hierarchy::fan_out; g < (of + 1) * Hierarchy::fan_out; g += lanes) {
            const Pack pack(test(groups, g));
            const auto keep = [&](const std::vector<float>& from, std::vector<float>& to)
                                  HWY_ATTR { pack.store(hn::LoadU(f, &from[g]), &to[n]); };
            keep(groups.x_low, found.x_low), keep(groups.x_high, found.x_high);
            keep(groups.y_low, found.y_low), keep(groups.y_high, found.y_high);
            keep(groups.nearest, found.nearest), keep(groups.top, found.top);
            keep(groups.rise_x, found.rise_x), keep(groups.rise_y, found.rise_y);
            pack.store(numbers_from(std::uint32_t(g)), &found.group[n]);
            n += pack.count;
        }
    found.size = n;
}

struct Glance {
    bool stopped = false;  // something may stop light
    bool passed = false;   // something comes within the radius
    bool near = false;     // something is near from everywhere, always
};

class Looking {
  public:
    Looking(const Hierarchy& h, const LitSettings& set) : h_(h), set_(set) {}

    void look(const StillReceiver& r, size_t group, Glance& out) const {
        const bool moves = h_.groups.moves[group];
        const size_t begin = group * Hierarchy::group_size;
        for (size_t i = begin; i < begin + Hierarchy::group_size; i += lanes)
            moves ? look_at<true>(r, i, out) : look_at<false>(r, i, out);
    }

  private:
    template <bool moving>
    HWY_INLINE void look_at(const StillReceiver& r, size_t i, Glance& out) const {
        const VF zero = hn::Zero(f), one = hn::Set(f, 1.0f), half = hn::Set(f, 0.5f);
        VF X = hn::LoadU(f, &h_.X[i]), Y = hn::LoadU(f, &h_.Y[i]);
        const VF W = hn::LoadU(f, &h_.W[i]);
        auto there = hn::Gt(W, zero), always = there;
        VF nearest, farthest, x_low, x_high, y_low, y_high;
        if constexpr (moving) {
            const PathVectors path(&h_.paths[4 * i]);
            const VF open = hn::NegMulAdd(half, path.VW, W), close = hn::MulAdd(half, path.VW, W);
            there = hn::Or(hn::Gt(open, zero), hn::Gt(close, zero));
            always = hn::And(hn::Gt(open, zero), hn::Gt(close, zero));
            const VF first = hn::Div(one, open), last = hn::Div(one, close);
            const VF x0 = hn::Mul(hn::NegMulAdd(half, path.VX, X), first),
                     x1 = hn::Mul(hn::MulAdd(half, path.VX, X), last),
                     y0 = hn::Mul(hn::NegMulAdd(half, path.VY, Y), first),
                     y1 = hn::Mul(hn::MulAdd(half, path.VY, Y), last);
            x_low = hn::Min(x0, x1), x_high = hn::Max(x0, x1);
            y_low = hn::Min(y0, y1), y_high = hn::Max(y0, y1);
            nearest = hn::Max(first, last), farthest = hn::Min(first, last);
        } else {
            nearest = farthest = hn::Div(one, hn::IfThenElse(there, W, one));
            x_low = x_high = hn::Mul(X, nearest);
            y_low = y_high = hn::Mul(Y, nearest);
        }
        const VF left = hn::Sub(x_low, hn::Set(f, r.x_high)),
                 right = hn::Sub(x_high, hn::Set(f, r.x_low)),
                 top = hn::Sub(y_low, hn::Set(f, r.y_high)),
                 bottom = hn::Sub(y_high, hn::Set(f, r.y_low));
        // How much nearer than its plane.
        const VF before = hn::Sub(nearest, hn::Set(f, r.far));
        const VF slope_x = hn::Set(f, r.slope_x), slope_y = hn::Set(f, r.slope_y);
        const VF plane = hn::Add(hn::Min(hn::Mul(slope_x, left), hn::Mul(slope_x, right)),
                                 hn::Min(hn::Mul(slope_y, top), hn::Mul(slope_y, bottom)));
        const VF nearer = hn::Sub(before, plane);
        const auto needed = [&](VF away) HWY_ATTR {
            return hn::Mul(hn::Set(f, r.turn * r.far),
                           hn::MulAdd(hn::Set(f, set_.px), away, hn::Set(f, set_.bias)));
        };
        // Most of what is not far is of the receiver's own surface, and does not stand before it
        // wherever it is.
        const auto anywhere = hn::AndNot(always, there);
        const bool may_stop = !hn::AllFalse(
            f, hn::Or(anywhere, hn::And(there, hn::Gt(nearer, needed(zero)))));
        if (!may_stop && out.near) return;

        const VF apart = hn::Max(hn::Abs(before), hn::Abs(hn::Sub(farthest, hn::Set(f, r.near))));
        const VF across = hn::Mul(hn::Set(f, set_.c0x), apart),
                 down = hn::Mul(hn::Set(f, set_.c0y), apart);
        const auto length = [](VF x, VF y)
                                HWY_ATTR { return hn::Sqrt(hn::MulAdd(x, x, hn::Mul(y, y))); };
        const VF radius = hn::Set(f, r.radius), search = hn::Set(f, set_.search);
        if (may_stop) {
            const auto outside = [zero](VF low, VF high, VF by) HWY_ATTR {
                return hn::Max(zero, hn::Sub(hn::Max(low, hn::Neg(high)), by));
            };
            VF away = length(outside(left, right, across), outside(top, bottom, down));
            if (set_.round)
                away = hn::Max(away, hn::Sub(length(outside(left, right, zero),
                                                    outside(top, bottom, zero)),
                                             hn::Max(across, down)));
            const auto stands = hn::And(hn::And(there, hn::Gt(nearer, needed(away))),
                                        hn::Lt(away, radius));
            if (!hn::AllFalse(f, hn::Or(stands, anywhere))) {
                out.passed = true;
                out.stopped |= !hn::AllFalse(
                    f, hn::Or(anywhere, hn::And(stands, hn::Lt(away, hn::Mul(radius, search)))));
            }
            if (out.near) return;
        }
        const auto farthest_away = [](VF low, VF high, VF by)
                                       HWY_ATTR { return hn::Add(hn::Max(hn::Neg(low), high), by); };
        const VF most = length(farthest_away(left, right, across), farthest_away(top, bottom, down));
        const auto within = hn::Lt(most, hn::Mul(radius, hn::Set(f, set_.search * set_.sure)));
        out.near = !hn::AllFalse(f, hn::And(always, within));
    }

    const Hierarchy& h_;
    const LitSettings& set_;
};

}  // namespace

void find_lit(const Hierarchy& hits, std::span<const LightBounds> levels, const LitSettings& set,
              std::span<const StillReceiver> receivers, LitScratch& scratch, std::uint8_t* lit) {
    if (receivers.empty()) return;
    collect(levels, NearTest(set, around(receivers)), scratch);
    const LightBounds& near = scratch.near;
    const Looking looking(hits, set);
    // What stops a receiver's light, or is near, most often does so for the next one.
    constexpr std::uint32_t none = 0xffffffff;
    std::uint32_t stopping = none, beside = none;
    for (size_t k = 0; k < receivers.size(); ++k) {
        const NearTest is_near(set, receivers[k]);
        const StopTest may_stop(set, receivers[k]);
        Glance glance;
        // What may stop light; then, of the rest, one that is near will do.
        const auto look = [&](std::uint32_t group) {
            const bool was_near = glance.near;
            looking.look(receivers[k], group, glance);
            if (glance.stopped) stopping = group;
            if (glance.near && !was_near) beside = group;
        };
        if (stopping != none) look(stopping);
        scratch.others.assign(beside != none, beside);
        for (size_t i = 0; i < near.size && !glance.stopped; i += lanes) {
            const auto all = hn::And(is_near(near, i), hn::FirstN(f, near.size - i));
            if (hn::AllFalse(f, all)) continue;
            const auto some = may_stop(near, i);
            for (unsigned bits = bits_of(f, hn::And(all, some)); bits && !glance.stopped; bits &= bits - 1)
                look(near.group[i + size_t(__builtin_ctz(bits))]);
            for (unsigned bits = bits_of(f, hn::AndNot(some, all)); bits; bits &= bits - 1)
                scratch.others.push_back(near.group[i + size_t(__builtin_ctz(bits))]);
        }
        for (size_t i = 0; i < scratch.others.size() && !glance.stopped && !glance.near; ++i)
            look(scratch.others[i]);
        lit[k] = !glance.near || glance.stopped ? 0 : glance.passed ? 1 : 2;
    }
}

}  // namespace weft::shadows::WEFT_ISA
