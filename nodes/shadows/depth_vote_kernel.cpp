#include "shadows/depth_vote_kernel.h"

#include <cmath>

namespace weft::shadows {
namespace {

class Voters {
  public:
    Voters(const Candidates& c, const ShadowQueries& queries, const Planes& planes,
           const VoteSettings& set)
        : c_(c), queries_(queries), planes_(planes), set_(set) {}

    void at(size_t l) {
        lx_ = c_.u_of(l), ly_ = c_.v_of(l);
        time_ = c_.t_of(l) - 0.5f;
        receiver_ = {queries_.inverse_depth[l],
                     planes_.from({queries_.slope_x[l], queries_.slope_y[l]}, lx_, ly_)};
    }
    bool lit(std::uint32_t i) const {
        return !planes_.before(receiver_, c_.sample[i], c_.dx[i], c_.dy[i], lx_, ly_, time_,
                               set_.test, set_.bias);
    }

  private:
    const Candidates& c_;
    const ShadowQueries& queries_;
    const Planes& planes_;
    const VoteSettings& set_;
    Seen receiver_;
    float lx_ = 0, ly_ = 0, time_ = 0;
};

}  // namespace

void depth_vote(const Candidates& c, const Surfaces& s, const Visibility& v,
                const ShadowQueries& queries, const Planes& planes, const VoteSettings& set,
                LightShares& out) {
    const size_t n = c.size();
    out.share.assign(n, 1);
    out.votes.assign(n, 0);
    Voters voters(c, queries, planes, set);
    size_t part = 0;
    for (size_t l = 0; l < n; ++l) {
        const float radius = set.tent * c.hierarchy->radius * c.ratio_of(l);
        const bool asked = queries.inverse_depth[l] > 0 && v.decision[l] != Decision::undecided;
        if (asked) voters.at(l);
        const FilmMetric metric = queries.metric_of(l);
        float lit = 0;
        std::uint32_t votes = 0;
        v.each_seen(l, part, [&](std::uint16_t first, std::uint16_t last, float share) {
            if (!asked) return;
            float sum = 0, yes = 0, least = 1e38f;
            std::uint32_t nearest = 0;
            for (std::uint32_t i = c.offset[l]; i < c.offset[l + 1]; ++i) {
                if (s.surface[i] < first || s.surface[i] > last) continue;
                const float d2 = metric.square(c.dx[i], c.dy[i]);
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
