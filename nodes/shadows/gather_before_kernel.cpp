#include "shadows/gather_before_kernel.h"

#include <algorithm>

#include "light-field/group_test.h"
#include "light-field/path_vectors.h"
#include "shadows/plane_vectors.h"

namespace weft::shadows::WEFT_ISA {
namespace {

// Where samples [j, j + lanes) are at (u, v) and 1/2 + d; W is 0 or less of those that are not.
struct At {
    VF x, y, inverse, W;
    HWY_INLINE At(const Hierarchy& h, size_t j, float u, float v, float d) {
        const VF time = hn::Set(f, d);
        VF X = hn::LoadU(f, &h.X[j]), Y = hn::LoadU(f, &h.Y[j]);
        W = hn::LoadU(f, &h.W[j]);
        if (h.moving) {
            const light_field::WEFT_ISA::PathVectors path(&h.paths[4 * j]);
            X = hn::MulAdd(time, path.VX, X);
            Y = hn::MulAdd(time, path.VY, Y);
            W = hn::MulAdd(time, path.VW, W);
        }
        inverse = hn::Div(hn::Set(f, 1.0f), W);
        const VF slope = hn::MulAdd(hn::Set(f, h.lens.c0), inverse, hn::Set(f, h.lens.c1));
        x = hn::MulAdd(slope, hn::Set(f, u * h.lens.aspect), hn::Mul(X, inverse));
        y = hn::MulAdd(slope, hn::Set(f, v), hn::Mul(Y, inverse));
    }
};

}  // namespace

void gather_before(const Hierarchy& h, const light_field::Block& block,
                   std::span<const float> nearest, const LightView& view, const Locations& at,
                   const ShadowQueries& ask, float scale, float bias, Candidates& out) {
    const size_t n = at.size();
    out.hierarchy = &h;
    out.offset.resize(n + 1);
    out.offset[0] = 0;
    out.spread.assign(n, 0xffffffffu);
    out.slope_step = out.velocity_step = 1;
    out.x = at.x, out.y = at.y, out.u = at.u, out.v = at.v, out.t = at.t;
    out.shared = false;
    out.ratio = at.ratio;
    out.radius = 0;
    const bool planes = !h.plane_x.empty();
    const VF zero = hn::Zero(f);
    size_t k = 0;
    for (size_t l = 0; l < n; ++l) {
        const float radius = scale * h.radius * (at.ratio.empty() ? 1.0f : at.ratio[l]);
        out.radius = std::max(out.radius, radius);
        const float u = at.u[l], v = at.v[l], d = at.t[l] - 0.5f;
        const PlaneVectors from(view, u, v, bias);
        const Seen seen = from.seen(ask.inverse_depth[l], {ask.slope_x[l], ask.slope_y[l]});
        const float least = from.least(seen, radius);
        const light_field::WEFT_ISA::GroupTest test(h, u, v, d, at.x[l] - radius,
                                                    at.x[l] + radius, at.y[l] - radius,
                                                    at.y[l] + radius);
        const VF limit = hn::Set(f, radius * radius), px = hn::Set(f, at.x[l]),
                 py = hn::Set(f, at.y[l]);
        for (size_t i = 0; i < block.groups; i += lanes)
            for (unsigned bits = bits_of(f, test(block, i)); bits; bits &= bits - 1) {
                const std::uint32_t group = block.group[i + size_t(__builtin_ctz(bits))];
                if (nearest[group] <= least) continue;
                const size_t begin = size_t(group) * Hierarchy::group_size;
                if (out.sample.size() < k + Hierarchy::group_size + lanes) {
                    const size_t size = 2 * (k + Hierarchy::group_size + lanes);
                    out.dx.resize(size), out.dy.resize(size), out.sample.resize(size);
                }
                for (size_t j = begin; j < begin + Hierarchy::group_size; j += lanes) {
                    const At place(h, j, u, v, d);
                    const VF dx = hn::Sub(place.x, px), dy = hn::Sub(place.y, py);
                    const auto near = hn::And(hn::Lt(hn::MulAdd(dx, dx, hn::Mul(dy, dy)), limit),
                                              hn::Gt(place.W, zero));
                    // (Most of it is of the surface that the ray ends at.)
                    const auto in = hn::And(near, from.nearer(seen, dx, dy, place.inverse));
                    if (hn::AllFalse(f, in)) continue;
                    // (The last group's planes end with its samples.)
                    const size_t last = planes ? h.plane_x.size() - std::min(j, h.plane_x.size()) : 0;
                    const auto plane = [&](const LargeArray<float>& of) HWY_ATTR {
                        if (last >= lanes) return hn::LoadU(f, &of[j]);
                        alignas(64) float rest[lanes] = {};
                        std::copy_n(of.data() + j, last, rest);
                        return hn::Load(f, rest);
                    };
                    const auto before = from.before(
                        seen,
                        {dx, dy, place.inverse, planes ? plane(h.plane_x) : zero,
                         planes ? plane(h.plane_y) : zero},
                        planes);
                    const Pack pack(hn::And(in, before.which));
                    pack.store(dx, &out.dx[k]);
                    pack.store(dy, &out.dy[k]);
                    pack.store(numbers_from(std::uint32_t(j)), &out.sample[k]);
                    k += pack.count;
                }
            }
        out.offset[l + 1] = std::uint32_t(k);
    }
    if (out.sample.size() < k + lanes)
        out.dx.resize(k + lanes), out.dy.resize(k + lanes), out.sample.resize(k + lanes);
}

}  // namespace weft::shadows::WEFT_ISA
