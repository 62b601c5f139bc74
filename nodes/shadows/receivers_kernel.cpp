// Where the receivers of a batch are on a light's film.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "light-field/simd.h"
#include "shadows/plane_vectors.h"
#include "shadows/receivers.h"

namespace weft::shadows::WEFT_ISA {

using namespace light_field::WEFT_ISA;

namespace {

// Of a pixel's locations that look at the light together, one asks for all that see its surface.
void share_answers(const LightView& view, const Locations& at, ShadowQueries& ask) {
    const size_t n = at.x.size();
    ask.answer_of.clear();
    if (at.together < 2) return;
    ask.answer_of.resize(n);
    std::iota(ask.answer_of.begin(), ask.answer_of.end(), 0u);
    constexpr float rounding = 1e-5f;  // of depths, relative
    const auto one_surface = [&](size_t a, size_t b) {
        const PlaneVectors planes(view, at.u_of(a), at.v_of(a), rounding);
        return planes.one_surface(
            planes.seen(ask.inverse_depth[a], {ask.slope_x[a], ask.slope_y[a]}),
            at.x[b] - at.x[a], at.y[b] - at.y[a], ask.inverse_depth[b]);
    };
    const size_t pixels = n / at.together;
    for (size_t l = pixels; l < n; ++l) {
        if (!(ask.inverse_depth[l] > 0)) continue;
        for (size_t other = l % pixels; other < l; other += pixels) {
            if (!(ask.inverse_depth[other] > 0) || !one_surface(other, l)) continue;
            ask.answer_of[l] = std::uint32_t(other);
            ask.inverse_depth[l] = 0;
            break;
        }
    }
}

}  // namespace

void look_from_light(const LightView& view, const ReceiverBatch& r, Locations& at,
                     ShadowQueries& ask) {
    const size_t n = at.x.size();
    for (auto* values : {&ask.inverse_depth, &ask.slope_x, &ask.slope_y}) values->resize(n);
    const VF zero = hn::Zero(f), one = hn::Set(f, 1.0f), k = hn::Set(f, float(view.k));
    const VF cx = hn::Set(f, float(view.cx)), cy = hn::Set(f, float(view.cy)),
             c0x = hn::Set(f, float(view.c0x())), c0y = hn::Set(f, float(view.c0y())),
             c1x = hn::Set(f, float(view.c1x())), c1y = hn::Set(f, float(view.c1y()));
    const VF width = hn::Set(f, float(view.width)), height = hn::Set(f, float(view.height));
    VF left = hn::Set(f, 1e30f), top = left, right = hn::Neg(left), bottom = right;
    const bool shared = r.u.empty();
    VF u = shared ? hn::Set(f, at.u[0]) : zero, v = shared ? hn::Set(f, at.v[0]) : zero;
    for (size_t l = 0; l < n; l += lanes) {
        if (!shared) u = hn::LoadU(f, &r.u[l]), v = hn::LoadU(f, &r.v[l]);
        const VF x = hn::LoadU(f, &r.x[l]), y = hn::LoadU(f, &r.y[l]), w = hn::LoadU(f, &r.w[l]);
        const auto front = hn::And(hn::Gt(w, zero), hn::FirstN(f, n - l));
        const auto put = [&](VF value, std::vector<float>& to) HWY_ATTR {
            if (l + lanes <= n) return hn::StoreU(value, f, &to[l]);
            alignas(64) float all[lanes];
            hn::Store(value, f, all);
            std::copy_n(all, n - l, &to[l]);
        };
        if (hn::AllFalse(f, front)) {
            for (auto* values : {&ask.inverse_depth, &ask.slope_x, &ask.slope_y}) put(zero, *values);
            if (!at.ratio.empty()) put(one, at.ratio);
            continue;
        }
        const VF inverse = hn::Div(one, hn::IfThenElse(front, w, one));
        const auto on_film = [&](VF centre, VF across, VF c0, VF c1, VF point) HWY_ATTR {
            return hn::MulAdd(hn::MulAdd(c0, inverse, c1), point,
                              hn::MulAdd(hn::Mul(k, across), inverse, centre));
        };
        const VF qx = on_film(cx, x, c0x, c1x, u), qy = on_film(cy, y, c0y, c1y, v);
        const auto in = hn::And(front, hn::And(hn::And(hn::Ge(qx, zero), hn::Lt(qx, width)),
                                               hn::And(hn::Ge(qy, zero), hn::Lt(qy, height))));
        ask.outside += hn::CountTrue(f, hn::AndNot(in, front));
        // 1/w over the film, of the plane through the point (LightView::inverse_depth_gradient).
        const VF nx = hn::LoadU(f, &r.normal_x[l]), ny = hn::LoadU(f, &r.normal_y[l]);
        const VF plane = hn::MulAdd(
            nx, x, hn::MulAdd(ny, y, hn::Mul(hn::LoadU(f, &r.normal_w[l]), w)));
        const auto known = hn::And(in, hn::Gt(hn::Abs(plane), hn::Mul(hn::Set(f, 1e-3f), w)));
        const VF rise = hn::Div(one, hn::IfThenElse(known, hn::Mul(k, plane), one));
        put(hn::IfThenElseZero(in, inverse), ask.inverse_depth);
        put(hn::IfThenElseZero(known, hn::Mul(nx, rise)), ask.slope_x);
        put(hn::IfThenElseZero(known, hn::Mul(ny, rise)), ask.slope_y);
        put(qx, at.x);
        put(qy, at.y);
        if (!at.ratio.empty())
            put(hn::IfThenElse(in, hn::LoadU(f, &r.ratio[l]), one), at.ratio);
        left = hn::Min(left, hn::IfThenElse(in, qx, left));
        top = hn::Min(top, hn::IfThenElse(in, qy, top));
        right = hn::Max(right, hn::IfThenElse(in, qx, right));
        bottom = hn::Max(bottom, hn::IfThenElse(in, qy, bottom));
    }
    share_answers(view, at, ask);
    float x0 = hn::GetLane(hn::MinOfLanes(f, left)), y0 = hn::GetLane(hn::MinOfLanes(f, top)),
          x1 = hn::GetLane(hn::MaxOfLanes(f, right)), y1 = hn::GetLane(hn::MaxOfLanes(f, bottom));
    if (x1 < x0) x0 = y0 = x1 = y1 = 0;
    for (size_t l = 0; l < n; ++l) {
        const bool asked = ask.inverse_depth[l] != 0;
        at.x[l] = asked ? at.x[l] : x0, at.y[l] = asked ? at.y[l] : y0;
    }
    at.x0 = int(std::floor(x0)), at.y0 = int(std::floor(y0));
    at.x1 = int(std::floor(x1)) + 1, at.y1 = int(std::floor(y1)) + 1;
}

}  // namespace weft::shadows::WEFT_ISA
