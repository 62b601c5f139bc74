// Votes of rays (ray_vote_kernel.h) with searches of their own: for passes where something stops the
// light, and farther around where nobody is near.
#pragma once
#include <cmath>

#include "light-field/projected.h"
#include "shadows/ray_vote_kernel.h"

namespace weft::shadows {

class RayVoteAround {
  public:
    RayVoteAround(const Hierarchy& hits, const Hierarchy& passes, const LightView& view,
                  const RayVote& set)
        : voting_(hits, passes, view, set) {}

    struct Scratch {
        // What is near some locations.
        struct Near {
            Locations at;
            light_field::Block block;
            Candidates found;
        } hits, passes;
        Candidates inside;  // of hits, those in ellipses
        std::vector<std::uint32_t> open;
        RayVoteScratch vote;
        ShadowQueries queries;
        LightShares shares;
    };

    // By hits that are there, and by passes within `scale` R; where the queries have a metric, by
    // what of these is nearer than `reach` R by it.
    void vote(const Candidates& hits, const Locations& at, const ShadowQueries& queries,
              float scale, float reach, Scratch& s, LightShares& shares) const {
        const bool round = queries.metric.empty();
        if (!round) keep_inside(hits, queries, reach, s.inside);
        const Candidates& near = round ? hits : s.inside;
        voting_.by_hits(near, queries, shares, s.open);
        if (voting_.passes().size() == 0 || !choose(at, s.open, s.passes.at)) return;
        look_near(voting_.passes(), s.passes.at, scale, s.passes);
        voting_.by_passes(near, s.passes.found, s.open, queries, s.vote, shares);
    }
    // By what is within `scale` R.
    void look(const Locations& at, const ShadowQueries& queries, float scale, float reach,
              Scratch& s, LightShares& shares) const {
        look_near(voting_.hits(), at, scale, s.hits);
        vote(s.hits.found, at, queries, scale, reach, s, shares);
    }
    // Looks farther around, `times` twice as far as before, for those that found nobody within
    // `scale` R.
    void widen(const Locations& at, const ShadowQueries& queries, float scale, int times,
               Scratch& s, LightShares& shares) const {
        for (int k = 1; k <= times; ++k) {
            s.open.clear();
            for (size_t l = 0; l < at.size(); ++l)
                if (shares.votes[l] == 0 && queries.inverse_depth[l] > 0)
                    s.open.push_back(std::uint32_t(l));
            if (!choose(at, s.open, s.hits.at)) return;
            choose(queries, s.open, s.queries);
            s.shares.pixels = s.hits.at.pixels;
            look(s.hits.at, s.queries, std::ldexp(scale, k), std::ldexp(1.0f, k), s, s.shares);
            for (size_t i = 0; i < s.hits.at.size(); ++i) {
                const std::uint32_t l = s.hits.at.own_parents[i];
                shares.share[l] = s.shares.share[i];
                shares.votes[l] = s.shares.votes[i];
            }
        }
    }

  private:
    static void keep_inside(const Candidates& from, const ShadowQueries& queries, float reach,
                            Candidates& to) {
        to = from;
        std::uint32_t kept = 0;
        for (size_t l = 0; l < from.size(); ++l) {
            const float radius = reach * from.hierarchy->radius * from.ratio_of(l);
            for (std::uint32_t i = from.offset[l]; i < from.offset[l + 1]; ++i) {
                if (!(queries.metric[l].square(from.dx[i], from.dy[i]) < radius * radius)) continue;
                to.dx[kept] = from.dx[i], to.dy[kept] = from.dy[i];
                to.sample[kept++] = from.sample[i];
            }
            to.offset[l + 1] = kept;
        }
    }
    static void look_near(const Hierarchy& h, const Locations& at, float scale,
                          Scratch::Near& near) {
        near.found.pixels = at.pixels;
        light_field::gather_around(h, at, scale, near.block, near.found);
    }
    // Some of the locations, whose places there are their parents here; false if these are none.
    static bool choose(const Locations& from, std::span<const std::uint32_t> which,
                       Locations& to) {
        for (auto* values : {&to.x, &to.y, &to.u, &to.v, &to.t, &to.ratio}) values->clear();
        to.own_pixels.clear();
        to.own_parents.assign(which.begin(), which.end());
        to.shared = false;
        float x0 = 1e30f, y0 = 1e30f, x1 = -1e30f, y1 = -1e30f;
        for (const std::uint32_t l : which) {
            to.x.push_back(from.x[l]), to.y.push_back(from.y[l]);
            to.u.push_back(from.u_of(l)), to.v.push_back(from.v_of(l)), to.t.push_back(from.t_of(l));
            if (!from.ratio.empty()) to.ratio.push_back(from.ratio[l]);
            to.own_pixels.push_back(from.pixels[l]);
            x0 = std::min(x0, from.x[l]), x1 = std::max(x1, from.x[l]);
            y0 = std::min(y0, from.y[l]), y1 = std::max(y1, from.y[l]);
        }
        to.pixels = to.own_pixels;
        if (which.empty()) return false;
        to.x0 = int(std::floor(x0)), to.y0 = int(std::floor(y0));
        to.x1 = int(std::floor(x1)) + 1, to.y1 = int(std::floor(y1)) + 1;
        return true;
    }
    static void choose(const ShadowQueries& from, std::span<const std::uint32_t> which,
                       ShadowQueries& to) {
        for (auto* values : {&to.inverse_depth, &to.slope_x, &to.slope_y}) values->clear();
        to.metric.clear();
        for (const std::uint32_t l : which) {
            if (!from.metric.empty()) to.metric.push_back(from.metric[l]);
            to.inverse_depth.push_back(from.inverse_depth[l]);
            to.slope_x.push_back(from.slope_x[l]);
            to.slope_y.push_back(from.slope_y[l]);
        }
    }

    const RayVoting voting_;
};

}  // namespace weft::shadows
