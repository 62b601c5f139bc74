// The front surface of a location that has few candidates. For kernels (weft_kernels).
#pragma once
#include "light-field/kernels.h"
#include "light-field/path_vectors.h"
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {

// The front surface among n candidates (SeeScratch::found) that stay in `vectors` registers, in no
// order: it ends at the nearest that conflicts with a nearer one. `moving`: velocities can tell
// some apart.
template <bool moving, size_t vectors>
class FrontSurface {
  public:
    VF x[vectors], y[vectors];  // from the location
    hn::Mask<F> seen[vectors];  // which are of the front surface
    bool all = true;            // of all n

    HWY_INLINE FrontSurface(const Projection& p, const Locations& at, size_t l,
                            const SameSurface& by, size_t n, SeeScratch& scratch)
        : c_(scratch),
          n_(n),
          limit_(hn::Set(f, by.tolerance)),
          stretch_(hn::Set(f, p.hierarchy->lens.aspect)) {
        place(p, at, l, by.box);
        // What conflicts with the nearest of all ends the surface as a rule, and only what lies
        // before that can end it sooner.
        const size_t nearest = find_nearest();
        test(nearest);
        VF border = find_border();
        if (suspects(nearest, border)) {
            for (size_t k = 0; k < vectors; ++k)
                for (unsigned bits = bits_of(f, before(k, border)); bits; bits &= bits - 1)
                    test(k * lanes + size_t(__builtin_ctz(bits)));
            border = find_border();
        }
        take_before(border);
    }

  private:
    using Mask = hn::Mask<F>;

    HWY_INLINE Mask in(size_t k) const { return hn::FirstN(f, n_ - k * lanes); }

    // Where the candidates are and what they do at the location, scaled as Layers has it.
    HWY_INLINE void place(const Projection& p, const Locations& at, size_t l, float box) {
        const Hierarchy& h = *p.hierarchy;
        const VF c0 = hn::Set(f, h.lens.c0 * box), c1 = hn::Set(f, h.lens.c1 * box);
        const VF time = hn::Set(f, p.t - 0.5f);
        for (size_t k = 0, i = 0; k < vectors; ++k, i += lanes) {
            found_[k] = hn::MaskFromVec(hn::Zero(f));
            x[k] = hn::LoadU(f, &c_.found_x[i]);
            y[k] = hn::LoadU(f, &c_.found_y[i]);
            if (h.moving) {
                const PathVectors path(h.paths.data(), &c_.found[i], n_ - i);
                depth_[k] = hn::MulAdd(time, path.VW, path.W);
                if constexpr (moving) {
                    const VF at_x = hn::Set(f, at.x[l] - h.lens.c1 * p.u * h.lens.aspect),
                             at_y = hn::Set(f, at.y[l] - h.lens.c1 * p.v);
                    const VF inverse = hn::Div(hn::Set(f, 0.5f * box), depth_[k]);
                    vx_[k] = hn::Mul(inverse, hn::NegMulAdd(path.VW, hn::Add(at_x, x[k]), path.VX));
                    vy_[k] = hn::Mul(inverse, hn::NegMulAdd(path.VW, hn::Add(at_y, y[k]), path.VY));
                    hn::StoreU(vx_[k], f, &c_.velocity_x[i]);
                    hn::StoreU(vy_[k], f, &c_.velocity_y[i]);
                }
            } else {
                depth_[k] = hn::GatherIndex(f, h.W.data(), samples_of(&c_.found[i], n_ - i));
            }
            slope_[k] = hn::MulAdd(c0, hn::Div(hn::Set(f, 1.0f), depth_[k]), c1);
            hn::StoreU(depth_[k], f, &c_.depth[i]);
            hn::StoreU(slope_[k], f, &c_.slope[i]);
        }
    }

    // The first of the least depth. (Lanes past the end are as deep as the first of their vector.)
    HWY_INLINE size_t find_nearest() const {
        VF least = depth_[0];
        for (size_t k = 1; k < vectors; ++k) least = hn::Min(least, depth_[k]);
        least = hn::MinOfLanes(f, least);
        for (size_t k = 0; k < vectors; ++k)
            if (const unsigned is = bits_of(f, hn::Eq(depth_[k], least)))
                return k * lanes + size_t(__builtin_ctz(is));
        return 0;  // depths that are no numbers
    }

    // Adds those that conflict with candidate j, where it is nearer, to what is found.
    HWY_INLINE void test(size_t j) {
        const VF depth = hn::Set(f, c_.depth[j]), slope = hn::Set(f, c_.slope[j]);
        const VF at_x = hn::Set(f, c_.found_x[j]), at_y = hn::Set(f, c_.found_y[j]);
        for (size_t k = 0; k < vectors; ++k) {
            VF way_y = hn::AbsDiff(slope, slope_[k]), way_x = hn::Mul(way_y, stretch_);
            if constexpr (moving) {
                way_x = hn::Max(way_x, hn::AbsDiff(hn::Set(f, c_.velocity_x[j]), vx_[k]));
                way_y = hn::Max(way_y, hn::AbsDiff(hn::Set(f, c_.velocity_y[j]), vy_[k]));
            }
            const Mask cross = hn::Or(hn::Lt(hn::Add(hn::AbsDiff(at_x, x[k]), limit_), way_x),
                                      hn::Lt(hn::Add(hn::AbsDiff(at_y, y[k]), limit_), way_y));
            // Of equal depths the first is the nearer.
            const Mask later = hn::AndNot(hn::FirstN(f, j + 1 > k * lanes ? j + 1 - k * lanes : 0),
                                          hn::Eq(depth, depth_[k]));
            found_[k] = hn::Or(found_[k], hn::And(cross, hn::Or(hn::Lt(depth, depth_[k]), later)));
        }
    }

    // The depth of the nearest that is found.
    HWY_INLINE VF find_border() {
        VF least = hn::Set(f, 1e38f);
        for (size_t k = 0; k < vectors; ++k) {
            found_[k] = hn::And(found_[k], in(k));
            least = hn::Min(least, hn::IfThenElse(found_[k], depth_[k], hn::Set(f, 1e38f)));
        }
        return hn::MinOfLanes(f, least);
    }

    HWY_INLINE Mask before(size_t k, VF border) const {
        return hn::And(in(k), hn::AndNot(found_[k], hn::Le(depth_[k], border)));
    }

    // Whether two before the border may conflict: slopes ascend with depth or descend with it, so
    // that the nearest's differs most; of velocities, none differ by more than twice what they
    // differ from the nearest's by.
    HWY_INLINE bool suspects(size_t nearest, VF border) const {
        const VF half = hn::Mul(hn::Set(f, 0.5f), limit_),
                 whole = hn::Div(limit_, hn::Max(stretch_, hn::Set(f, 1.0f)));
        const auto way = [&](const std::vector<float>& of, VF value)
                             HWY_ATTR { return hn::AbsDiff(hn::Set(f, of[nearest]), value); };
        Mask some = hn::MaskFromVec(hn::Zero(f));
        for (size_t k = 0; k < vectors; ++k) {
            Mask far = hn::Gt(way(c_.slope, slope_[k]), whole);
            if constexpr (moving) {
                far = hn::Or(far, hn::Gt(way(c_.velocity_x, vx_[k]), half));
                far = hn::Or(far, hn::Gt(way(c_.velocity_y, vy_[k]), half));
            }
            some = hn::Or(some, hn::And(before(k, border), far));
        }
        return !hn::AllFalse(f, some);
    }

    // Sees what is nearer than the border, or as near and before the first found there.
    HWY_INLINE void take_before(VF border) {
        bool past = false;
        for (size_t k = 0; k < vectors; ++k) {
            const Mask level = hn::And(in(k), hn::Eq(depth_[k], border));
            seen[k] = hn::And(in(k), hn::Lt(depth_[k], border));
            if (const unsigned ends = bits_of(f, hn::And(found_[k], level)); !past) {
                seen[k] = hn::Or(
                    seen[k],
                    ends ? hn::And(level, hn::FirstN(f, size_t(__builtin_ctz(ends)))) : level);
                past = ends != 0;
            }
            all = all && hn::AllTrue(f, hn::Or(seen[k], hn::Not(in(k))));
        }
    }

    SeeScratch& c_;
    const size_t n_;
    const VF limit_, stretch_;
    VF depth_[vectors], slope_[vectors], vx_[vectors], vy_[vectors];
    Mask found_[vectors];  // conflict with a nearer one
};

}  // namespace weft::light_field::WEFT_ISA
