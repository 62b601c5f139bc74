#include "shadows/depth_vote_kernel.h"

#include <cmath>

namespace weft::shadows {
namespace {

struct Slope {
    float x, y;
};
// Of a plane's inverse depth, seen from l instead of l = 0.
Slope seen_from(Slope h, float lx, float ly, const VoteSettings& set) {
    const float divisor = 1 + float(set.c0x) * h.x * lx + float(set.c0y) * h.y * ly;
    if (!(std::abs(divisor) >= 0.1f)) return {0, 0};
    return {h.x / divisor, h.y / divisor};
}

class Voters {
  public:
    Voters(const Candidates& c, const ShadowQueries& queries, std::span<const float> gradient,
           std::span<const float> depth, const VoteSettings& set)
        : c_(c),
          h_(*c.hierarchy),
          queries_(queries),
          gradient_(gradient),
          depth_(depth),
          set_(set) {}

    void at(size_t l) {
        l_ = l;
        time_ = c_.t_of(l) - 0.5f;
        inverse_ = queries_.inverse_depth[l];
        own_ = seen_from({queries_.slope_x[l], queries_.slope_y[l]}, c_.u_of(l), c_.v_of(l), set_);
    }
    bool lit(std::uint32_t i) const {
        const std::uint32_t s = c_.sample[i], j = h_.order[s];
        const float w = h_.W[s] + (h_.moving ? time_ * h_.VW[s] : 0.0f);
        const float dx = c_.dx[i], dy = c_.dy[i];
        const float gx = gradient_.empty() ? 0.0f : gradient_[2 * j],
                    gy = gradient_.empty() ? 0.0f : gradient_[2 * j + 1];
        if (set_.test == DepthTest::linear)
            return 1 / inverse_ - set_.bias <= w - (gx * dx + gy * dy);
        const float at_depth = depth_[j], square = -1 / (at_depth * at_depth), inverse = 1 / w;
        const Slope slope = seen_from({gx * square, gy * square}, c_.u_of(l_), c_.v_of(l_), set_);
        const float limit = set_.bias * inverse_;
        if (inverse_ + limit >= inverse - (slope.x * dx + slope.y * dy)) return true;
        return set_.test == DepthTest::both_planes &&
               inverse_ + (own_.x * dx + own_.y * dy) + limit >= inverse;
    }

  private:
    const Candidates& c_;
    const Hierarchy& h_;
    const ShadowQueries& queries_;
    std::span<const float> gradient_, depth_;
    const VoteSettings& set_;
    size_t l_ = 0;
    float time_ = 0, inverse_ = 0;
    Slope own_{0, 0};
};

}  // namespace

void depth_vote(const Candidates& c, const Surfaces& s, const Visibility& v,
                const ShadowQueries& queries, std::span<const float> gradient,
                std::span<const float> depth, const VoteSettings& set, LightShares& out) {
    const size_t n = c.size();
    out.share.assign(n, 1);
    out.votes.assign(n, 0);
    Voters voters(c, queries, gradient, depth, set);
    size_t part = 0;
    for (size_t l = 0; l < n; ++l) {
        const float radius = set.tent * c.hierarchy->radius * c.ratio_of(l);
        const bool asked = queries.inverse_depth[l] > 0 && v.decision[l] != Decision::undecided;
        if (asked) voters.at(l);
        float lit = 0;
        std::uint32_t votes = 0;
        v.each_seen(l, part, [&](std::uint16_t first, std::uint16_t last, float share) {
            if (!asked) return;
            float sum = 0, yes = 0, least = 1e38f;
            std::uint32_t nearest = 0;
            for (std::uint32_t i = c.offset[l]; i < c.offset[l + 1]; ++i) {
                if (s.surface[i] < first || s.surface[i] > last) continue;
                const float d2 = c.dx[i] * c.dx[i] + c.dy[i] * c.dy[i];
                if (d2 < least) least = d2, nearest = i;
                const float weight = 1 - std::sqrt(d2) / radius;
                if (!(weight > 0)) continue;
                ++votes;
                sum += weight;
                if (voters.lit(i)) yes += weight;
            }
            if (sum > 0) {
                // Votes of one mind are exact.
                lit += share * (yes == sum ? 1 : yes / sum);
            } else if (least < 1e38f) {
                ++votes;
                lit += share * (voters.lit(nearest) ? 1.0f : 0.0f);
            }
        });
        if (votes == 0) continue;
        out.share[l] = lit < 1 ? lit : 1;
        out.votes[l] = votes;
    }
}

}  // namespace weft::shadows
