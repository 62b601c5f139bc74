// Tangent planes of what a light sees, and which of two surfaces stands before the other.
// A plane is linear in 1/w over the film, from any point l of the light: with slope h at l = 0 it
// has there h / (1 + C0 h.l). Where that divisor is below 0.1 it is seen edge-on and counts as
// level.
#pragma once
#include <algorithm>
#include <cmath>

#include "light-field/hierarchy.h"
#include "shadows/light_view.h"

namespace weft::shadows {

// When a light sample's surface shadows a receiver.
enum class DepthTest {
    both_planes,  // it lies before the receiver by its own tangent plane and by the receiver's, by
                  // more than it is away from the receiver on the film: what is nearer to both
                  // planes may be the receiver's own surface, which bends
    inverse_depth,  // by its own, inverse depth being linear over the film
    linear,         // by its own, depth taken for linear over the film (Lehtinen et al. 2011)
};

// Change of 1/w a px of film.
struct Slope {
    float x = 0, y = 0;
};

// A receiver as it is seen from a point of the light, at a time.
struct Seen {
    float inverse = 0;  // 1/w
    Slope slope;
};

// The surfaces of light samples.
class Planes {
  public:
    // Of a sample's surface beside it, depth a pixel's width: what is steeper is a rim, and says
    // nothing of what lies beyond.
    static constexpr float steepest = 4;

    // Of a hierarchy of light samples: those of whose surface nothing is known lie level.
    Planes(const Hierarchy& hierarchy, const LightView& view)
        : h_(hierarchy),
          c0x_(float(view.c0x())),
          c0y_(float(view.c0y())),
          steepest_(steepest / float(view.k)),
          px_(1 / float(view.k)) {}

    const Hierarchy& hierarchy() const { return h_; }
    // As seen from the light's point (lx, ly), given the slope from its middle.
    Slope from(Slope h, float lx, float ly) const {
        const float divisor = 1 + c0x_ * h.x * lx + c0y_ * h.y * ly;
        if (!(std::abs(divisor) >= 0.1f)) return {};
        return {h.x / divisor, h.y / divisor};
    }
    // That of sample s of the hierarchy at 1/w = inverse.
    Slope own(std::uint32_t s, float inverse, float lx, float ly) const {
        const Slope h = slope(s);
        const float divisor = std::max(1 + c0x_ * h.x * lx + c0y_ * h.y * ly, 1e-6f);
        const float steep = std::sqrt(h.x * h.x + h.y * h.y) / divisor, most = steepest_ * inverse;
        const float scale = (steep > most ? most / steep : 1) / divisor;
        return {h.x * scale, h.y * scale};
    }
    // Slope of 1/w of sample s of the hierarchy, seen from l = 0.
    Slope slope(std::uint32_t s) const {
        if (h_.plane_x.empty()) return {};
        return {h_.plane_x[s], h_.plane_y[s]};
    }
    // w of sample s of the hierarchy, d = t - 1/2.
    float depth_at(std::uint32_t s, float d) const {
        return h_.W[s] + d * h_.velocity(s).w;
    }
    // w of its plane (dx, dy) px away: at a place from which the sample lies at (dx, dy).
    float depth_beside(std::uint32_t s, float dx, float dy, float lx, float ly, float d) const {
        const float inverse = 1 / depth_at(s, d);
        const Slope h = own(s, inverse, lx, ly);
        return 1 / (inverse - (h.x * dx + h.y * dy));
    }

    // Whether the surface of sample s of the hierarchy, (dx, dy) px from a receiver on the film as
    // seen from (lx, ly) at 1/2 + d, stands before it by more than `bias`: relative, or world units
    // where the test is linear. Source: Lehtinen et al. 2011, Sec. 4.  Departures: inverse depth,
    // in which planes are exact; the receiver's own plane, behind which a surface that bends away
    // from the light never shadows itself.
    bool before(const Seen& receiver, std::uint32_t s, float dx, float dy, float lx, float ly,
                float d, DepthTest test, float bias) const {
        const float w = depth_at(s, d);
        if (test == DepthTest::linear) {
            const Slope h = slope(s);  // dw = -w^2 d(1/w)
            return 1 / receiver.inverse - bias > w + w * w * (h.x * dx + h.y * dy);
        }
        const float inverse = 1 / w,
                    bend = test == DepthTest::both_planes ? px_ * std::sqrt(dx * dx + dy * dy) : 0,
                    limit = receiver.inverse + (bias + bend) * receiver.inverse;
        if (test == DepthTest::both_planes &&
            limit + (receiver.slope.x * dx + receiver.slope.y * dy) >= inverse)
            return false;
        const Slope h = test == DepthTest::both_planes ? own(s, inverse, lx, ly)
                                                       : from(slope(s), lx, ly);
        return limit < inverse - (h.x * dx + h.y * dy);
    }

  private:
    const Hierarchy& h_;
    float c0x_, c0y_, steepest_;
    float px_;  // as wide as a px of film, a unit away
};

}  // namespace weft::shadows
