#include "shadows/ray_vote_kernel.h"

#include <algorithm>
#include <cmath>

namespace weft::shadows {
namespace {

// One location's rays.
class Voters {
  public:
    Voters(const Candidates& c, const Planes& planes, std::span<const float> end)
        : c_(c), h_(planes.hierarchy()), planes_(planes), end_(end) {
        lens_x_ = h_.lens.c0 * h_.lens.aspect, lens_y_ = h_.lens.c0;
        // Of 1/w, what moves a sample by a pixel over the light's half extent.
        level_ = 1 / std::max({std::abs(lens_x_), std::abs(lens_y_), 1e-30f});
    }
    void at(size_t l) { lx_ = c_.u_of(l), ly_ = c_.v_of(l), time_ = c_.t_of(l) - 0.5f; }

    // Candidate i, a pass.
    RayVoteScratch::Pass pass(std::uint32_t i) const {
        const std::uint32_t j = h_.order[c_.sample[i]];
        RayVoteScratch::Pass out{c_.dx[i], c_.dy[i], 1 / planes_.depth_at(c_.sample[i], time_),
                                 0,        0,        1 / end_[j]};
        if (!h_.uv.empty())
            out.way_x = lens_x_ * (lx_ - h_.uv[2 * j]),
            out.way_y = lens_y_ * (ly_ - h_.uv[2 * j + 1]);
        return out;
    }
    // Whether one of `passes` is free of the surface of candidate `hit`, and nearer than it.
    bool free_of(std::uint32_t hit, std::span<const RayVoteScratch::Pass> passes) const {
        if (passes.empty()) return false;
        const float x = c_.dx[hit], y = c_.dy[hit], far = x * x + y * y;
        const float inverse = 1 / planes_.depth_beside(c_.sample[hit], x, y, lx_, ly_, time_);
        for (const RayVoteScratch::Pass& pass : passes) {
            const float move = inverse - pass.inverse;
            // It goes on well behind the surface; or behind it and was seen to pass it.
            const float behind = inverse - pass.end;
            if (!(behind > level_ || (behind > 0 && std::abs(move) < level_))) continue;
            const float px = pass.x + move * pass.way_x, py = pass.y + move * pass.way_y;
            if (px * px + py * py < far) return true;
        }
        return false;
    }

  private:
    const Candidates& c_;
    const Hierarchy& h_;
    const Planes& planes_;
    std::span<const float> end_;
    float lens_x_ = 0, lens_y_ = 0, level_ = 0;
    float lx_ = 0, ly_ = 0, time_ = 0;
};

}  // namespace

void ray_vote(const Candidates& c, const ShadowQueries& queries, const Planes& planes,
              std::span<const float> end, const RayVote& set, RayVoteScratch& scratch,
              LightShares& out) {
    const Hierarchy& h = planes.hierarchy();
    const size_t n = c.size();
    out.share.assign(n, 1);
    out.votes.assign(n, 0);
    Voters voters(c, planes, end);
    for (size_t l = 0; l < n; ++l) {
        if (!(queries.inverse_depth[l] > 0)) continue;
        const float lx = c.u_of(l), ly = c.v_of(l), d = c.t_of(l) - 0.5f;
        const Seen receiver{queries.inverse_depth[l],
                            planes.from({queries.slope_x[l], queries.slope_y[l]}, lx, ly)};
        auto& [hits, passes] = scratch;
        hits.clear(), passes.clear();
        voters.at(l);
        float least = 1e38f;
        for (std::uint32_t i = c.offset[l]; i < c.offset[l + 1]; ++i) {
            if (!planes.before(receiver, c.sample[i], c.dx[i], c.dy[i], lx, ly, d, set.test,
                               set.bias))
                continue;
            const bool passed = !end.empty() && end[h.order[c.sample[i]]] > 0;
            if (passed) {
                passes.push_back(voters.pass(i));
                continue;
            }
            hits.push_back(i);
            // The nearest first: most often it decides.
            const float d2 = c.dx[i] * c.dx[i] + c.dy[i] * c.dy[i];
            if (d2 < least) least = d2, std::swap(hits.front(), hits.back());
        }
        const bool open = std::all_of(hits.begin(), hits.end(), [&](std::uint32_t hit) {
            return voters.free_of(hit, passes);
        });
        out.share[l] = open ? 1 : 0;
        out.votes[l] = c.offset[l + 1] - c.offset[l];
    }
}

}  // namespace weft::shadows
