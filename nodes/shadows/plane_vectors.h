// Planes::before of many samples at once. For kernels (weft_kernels).
#pragma once
#include <cmath>

#include "light-field/simd.h"
#include "shadows/planes.h"

namespace weft::shadows::WEFT_ISA {
using namespace light_field::WEFT_ISA;

// As the light's point (lx, ly) sees planes.
class PlaneVectors {
  public:
    PlaneVectors(const LightView& view, float lx, float ly, float bias)
        : lx_(lx),
          ly_(ly),
          c0x_(float(view.c0x())),
          c0y_(float(view.c0y())),
          steepest_(Planes::steepest / float(view.k)),
          px_(1 / float(view.k)),
          bias_(bias) {}

    // A receiver, given the slope of 1/w from l = 0.
    Seen seen(float inverse, Slope h) const {
        const float divisor = 1 + c0x_ * h.x * lx_ + c0y_ * h.y * ly_;
        if (!(std::abs(divisor) >= 0.1f)) return {inverse, {}};
        return {inverse, {h.x / divisor, h.y / divisor}};
    }

    // Whether what lies (dx, dy) px from a receiver at 1/w is of its surface: neither before its plane
    // nor behind it by more than what bends may be.
    bool one_surface(const Seen& receiver, float dx, float dy, float inverse) const {
        const float bend = bias_ + px_ * std::sqrt(dx * dx + dy * dy),
                    off = inverse - receiver.inverse -
                          (receiver.slope.x * dx + receiver.slope.y * dy);
        return std::abs(off) <= bend * receiver.inverse;
    }

    // Samples (dx, dy) px from a receiver: 1/w there, and the slopes of their planes from l = 0.
    struct Samples {
        VF dx, dy, inverse, plane_x, plane_y;
    };
    // Which stand before it, by both planes; and 1/w of their planes at the receiver.
    struct Before {
        hn::Mask<F> which;
        VF beside;
    };
    HWY_INLINE Before before(const Seen& receiver, const Samples& s, bool planes) const {
        if (!planes) return before(receiver, s.dx, s.dy, s.inverse, s.inverse);
        const Rise rise = own(s.inverse, s.plane_x, s.plane_y);
        return before(receiver, s.dx, s.dy, s.inverse,
                      beside(s.dx, s.dy, s.inverse, rise.x, rise.y));
    }

    // Which are nearer to the light than the receiver's plane: all that stand before it are.
    HWY_INLINE hn::Mask<F> nearer(const Seen& receiver, VF dx, VF dy, VF inverse) const {
        const VF plane = hn::Set(f, receiver.inverse + bias_ * receiver.inverse),
                 rise = hn::Add(hn::Mul(hn::Set(f, receiver.slope.x), dx),
                                hn::Mul(hn::Set(f, receiver.slope.y), dy));
        return hn::Lt(hn::Add(plane, rise), inverse);
    }

    // Planes::own: slopes of 1/w as the light's point sees them.
    struct Rise {
        VF x, y;
    };
    HWY_INLINE Rise own(VF inverse, VF plane_x, VF plane_y) const {
        const VF one = hn::Set(f, 1.0f);
        const VF turn =
            hn::Add(hn::Add(one, hn::Mul(hn::Mul(hn::Set(f, c0x_), plane_x), hn::Set(f, lx_))),
                    hn::Mul(hn::Mul(hn::Set(f, c0y_), plane_y), hn::Set(f, ly_)));
        const VF divisor = hn::Max(turn, hn::Set(f, 1e-6f));
        const VF steep = hn::Div(
            hn::Sqrt(hn::Add(hn::Mul(plane_x, plane_x), hn::Mul(plane_y, plane_y))), divisor);
        const VF most = hn::Mul(hn::Set(f, steepest_), inverse);
        const VF scale =
            hn::Div(hn::IfThenElse(hn::Gt(steep, most), hn::Div(most, steep), one), divisor);
        return {hn::Mul(plane_x, scale), hn::Mul(plane_y, scale)};
    }
    HWY_INLINE static VF beside(VF dx, VF dy, VF inverse, VF rise_x, VF rise_y) {
        return hn::Sub(inverse, hn::Add(hn::Mul(rise_x, dx), hn::Mul(rise_y, dy)));
    }
    // Given 1/w of their planes at the receiver.
    HWY_INLINE Before before(const Seen& receiver, VF dx, VF dy, VF inverse, VF beside) const {
        const VF own = hn::Set(f, receiver.inverse),
                 bend = hn::Mul(hn::Set(f, px_),
                                hn::Sqrt(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)))),
                 limit = hn::Add(own, hn::Mul(hn::Add(hn::Set(f, bias_), bend), own));
        const VF here = hn::Add(limit, hn::Add(hn::Mul(hn::Set(f, receiver.slope.x), dx),
                                               hn::Mul(hn::Set(f, receiver.slope.y), dy)));
        return {hn::And(hn::Lt(here, inverse), hn::Lt(limit, beside)), beside};
    }
    // 1/w that a sample has to exceed, to be before a receiver within a radius of it.
    float least(const Seen& receiver, float radius) const {
        const float steep = std::hypot(receiver.slope.x, receiver.slope.y);
        return receiver.inverse - std::max(0.0f, steep - px_ * receiver.inverse) * radius;
    }

  private:
    float lx_, ly_, c0x_, c0y_, steepest_, px_, bias_;
};

}  // namespace weft::shadows::WEFT_ISA
