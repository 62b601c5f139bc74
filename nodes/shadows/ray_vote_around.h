// ray_vote() of locations one by one, with a search of their own around each.
#pragma once
#include <cmath>

#include "light-field/projected.h"
#include "shadows/ray_vote_kernel.h"

namespace weft::shadows {

class RayVoteAround {
  public:
    // Of light samples as of passing-rays.
    RayVoteAround(const Hierarchy& hierarchy, const Samples& lights, const LightView& view,
                  const RayVote& set)
        : planes(hierarchy, lights.values("z_gradient"), lights.z(), view),
          end(lights.values("end")),
          set_(set) {}

    struct Scratch {
        RayVoteScratch vote;
        light_field::Block block;
        Locations at;
        Candidates found;
        ShadowQueries queries;
        LightShares shares;
    };

    // By candidates that are there.
    void vote(const Candidates& candidates, const ShadowQueries& queries, Scratch& s,
              LightShares& shares) const {
        ray_vote(candidates, queries, planes, end, set_, s.vote, shares);
    }
    // By what is within `scale` R.
    void look(const Locations& at, const ShadowQueries& queries, float scale, Scratch& s,
              LightShares& shares) const {
        s.found.pixels = at.pixels;
        light_field::gather_around(planes.hierarchy(), at, scale, s.block, s.found);
        vote(s.found, queries, s, shares);
    }
    // Looks farther around, `times` twice as far as before, for those that found nobody within
    // `scale` R.
    void widen(const Locations& at, const ShadowQueries& queries, float scale, int times,
               Scratch& s, LightShares& shares) const {
        for (int k = 1; k <= times && take_lonely(at, queries, shares, s); ++k) {
            s.shares.pixels = s.at.pixels;
            look(s.at, s.queries, std::ldexp(scale, k), s, s.shares);
            for (size_t i = 0; i < s.at.size(); ++i) {
                const std::uint32_t l = s.at.own_parents[i];
                shares.share[l] = s.shares.share[i];
                shares.votes[l] = s.shares.votes[i];
            }
        }
    }

    const Planes planes;
    const std::span<const float> end;

  private:
    // Those that were asked for and found no ray; false if there are none.
    static bool take_lonely(const Locations& at, const ShadowQueries& queries,
                            const LightShares& shares, Scratch& s) {
        Locations& to = s.at;
        for (auto* values : {&to.x, &to.y, &to.u, &to.v, &to.t, &to.ratio, &s.queries.inverse_depth,
                             &s.queries.slope_x, &s.queries.slope_y})
            values->clear();
        to.own_pixels.clear(), to.own_parents.clear();
        to.shared = false;
        float x0 = 1e30f, y0 = 1e30f, x1 = -1e30f, y1 = -1e30f;
        for (size_t l = 0; l < at.size(); ++l) {
            if (shares.votes[l] > 0 || !(queries.inverse_depth[l] > 0)) continue;
            to.x.push_back(at.x[l]), to.y.push_back(at.y[l]);
            to.u.push_back(at.u_of(l)), to.v.push_back(at.v_of(l)), to.t.push_back(at.t_of(l));
            if (!at.ratio.empty()) to.ratio.push_back(at.ratio[l]);
            to.own_pixels.push_back(at.pixels[l]);
            to.own_parents.push_back(std::uint32_t(l));
            s.queries.inverse_depth.push_back(queries.inverse_depth[l]);
            s.queries.slope_x.push_back(queries.slope_x[l]);
            s.queries.slope_y.push_back(queries.slope_y[l]);
            x0 = std::min(x0, at.x[l]), x1 = std::max(x1, at.x[l]);
            y0 = std::min(y0, at.y[l]), y1 = std::max(y1, at.y[l]);
        }
        to.pixels = to.own_pixels;
        if (to.size() == 0) return false;
        to.x0 = int(std::floor(x0)), to.y0 = int(std::floor(y0));
        to.x1 = int(std::floor(x1)) + 1, to.y1 = int(std::floor(y1)) + 1;
        return true;
    }

    const RayVote set_;
};

}  // namespace weft::shadows
