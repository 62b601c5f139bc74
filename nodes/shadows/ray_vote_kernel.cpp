#include "shadows/ray_vote_kernel.h"

#include <algorithm>
#include <cmath>

namespace weft::shadows {

// A location, and what it sees as the light's point does.
struct RayVoting::Receiver {
    Seen seen;
    float lx, ly, time;
    FilmMetric metric;
};

RayVoting::RayVoting(const Hierarchy& hits, const Hierarchy& passes, const LightView& view,
                     const RayVote& set)
    : hits_(hits, view),
      passes_(passes, view),
      set_(set),
      lens_x_(hits.lens.c0 * hits.lens.aspect),
      lens_y_(hits.lens.c0),
      // Of 1/w, what moves a sample by a pixel over the light's half extent.
      level_(1 / std::max({std::abs(lens_x_), std::abs(lens_y_), 1e-30f})),
      angle_(1 / float(view.k)) {}

RayVoting::Receiver RayVoting::receiver(const Candidates& hits, const ShadowQueries& queries,
                                        size_t l) const {
    const float lx = hits.u_of(l), ly = hits.v_of(l);
    return {{queries.inverse_depth[l],
             hits_.from({queries.slope_x[l], queries.slope_y[l]}, lx, ly)},
            lx,
            ly,
            hits.t_of(l) - 0.5f,
            queries.metric_of(l)};
}

bool RayVoting::before(const Receiver& r, const Planes& planes, const Candidates& of,
                       std::uint32_t i) const {
    return planes.before(r.seen, of.sample[i], of.dx[i], of.dy[i], r.lx, r.ly, r.time, set_.test,
                         set_.bias);
}

void RayVoting::by_hits(const Candidates& hits, const ShadowQueries& queries, LightShares& out,
                        std::vector<std::uint32_t>& open) const {
    const size_t n = hits.size();
    out.share.assign(n, 1);
    out.votes.assign(n, 0);
    open.clear();
    for (size_t l = 0; l < n; ++l) {
        if (!(queries.inverse_depth[l] > 0)) continue;
        const Receiver at = receiver(hits, queries, l);
        out.votes[l] = std::uint32_t(hits.of(l));
        for (std::uint32_t i = hits.offset[l]; i < hits.offset[l + 1] && out.share[l] > 0; ++i)
            if (before(at, hits_, hits, i)) out.share[l] = 0;
        if (out.share[l] == 0 || out.votes[l] == 0) open.push_back(std::uint32_t(l));
    }
}

void RayVoting::by_passes(const Candidates& hits, const Candidates& passes,
                          std::span<const std::uint32_t> open, const ShadowQueries& queries,
                          RayVoteScratch& scratch, LightShares& out) const {
    const Hierarchy& h = passes_.hierarchy();
    for (size_t k = 0; k < open.size(); ++k) {
        const size_t l = open[k];
        out.votes[l] += std::uint32_t(passes.of(k));
        if (out.share[l] > 0) continue;
        const Receiver at = receiver(hits, queries, l);
        scratch.passes.clear();
        for (std::uint32_t i = passes.offset[k]; i < passes.offset[k + 1]; ++i) {
            if (!before(at, passes_, passes, i)) continue;
            const std::uint32_t s = passes.sample[i], j = h.order[s];
            RayVoteScratch::Pass pass{
                passes.dx[i], passes.dy[i], 1 / passes_.depth_at(s, at.time), 0, 0, 1 / h.end[s], 0};
            if (!h.uv.empty()) {
                pass.way_x = lens_x_ * (at.lx - h.uv[2 * j]);
                pass.way_y = lens_y_ * (at.ly - h.uv[2 * j + 1]);
                // Squared, the angle between the rays.
                const float part = angle_ * pass.inverse;
                pass.bulge = h.bulge[s] * part * part *
                             (pass.way_x * pass.way_x + pass.way_y * pass.way_y);
            }
            scratch.passes.push_back(pass);
        }
        bool stopped = false;
        for (std::uint32_t i = hits.offset[l]; i < hits.offset[l + 1] && !stopped; ++i)
            stopped = before(at, hits_, hits, i) && !free_of(at, hits, i, scratch.passes);
        out.share[l] = stopped ? 0 : 1;
    }
}

// Whether one of `passes` is free of the surface of candidate `hit`, and nearer than it.
bool RayVoting::free_of(const Receiver& r, const Candidates& hits, std::uint32_t hit,
                        std::span<const RayVoteScratch::Pass> passes) const {
    if (passes.empty()) return false;
    const float x = hits.dx[hit], y = hits.dy[hit], far = std::sqrt(r.metric.square(x, y));
    const float inverse = 1 / hits_.depth_beside(hits.sample[hit], x, y, r.lx, r.ly, r.time);
    for (const RayVoteScratch::Pass& pass : passes) {
        const float move = inverse - pass.inverse;
        // It goes on well behind the surface; or behind it and was seen to pass it.
        const float behind = inverse - pass.end;
        if (!(behind > level_ || (behind > 0 && std::abs(move) < level_))) continue;
        const float px = pass.x + move * pass.way_x, py = pass.y + move * pass.way_y;
        if (std::sqrt(r.metric.square(px, py)) + pass.bulge < far) return true;
    }
    return false;
}

}  // namespace weft::shadows
