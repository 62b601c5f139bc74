// What tests of shadows share: light samples of scenes whose shadows are known exactly, and the
// share of the light that a receiver sees, reconstructed from them.
//   light       centre at the origin, facing +w, half extent `half`; a quad or a disc
//   receivers   the plane w = d1, unless said otherwise; a light pixel there is d1 / k units
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "light-field/build_hierarchy_kernel.h"
#include "light-field/kernels.h"
#include "light-field/local_radius.h"
#include "samples/random.h"
#include "shadows/depth_vote_kernel.h"
#include "shadows/light_samples.h"
#include "shadows/passing_rays_kernel.h"
#include "shadows/ray_vote_around.h"
#include "tests/run_node.h"

namespace weft {

inline constexpr double pi_d = 3.14159265358979323846;

// Where the way from a light point to a receiver is stopped at a time, in light space, with the
// normal of what stops it and its motion over the shutter.
struct Stop {
    Point3 at, normal, motion;
};
using Occluder = std::function<std::optional<Stop>(Point3 light, Point3 receiver, double t)>;

// An occluder in the plane w = depth: what of it is there, at a time.
inline Occluder flat_occluder(double depth, std::function<bool(double x, double y, double t)> there,
                              Point3 motion = {}) {
    return [=](Point3 light, Point3 receiver, double t) -> std::optional<Stop> {
        const double part = (depth - light.z) / (receiver.z - light.z);
        if (!(part > 0 && part < 1)) return std::nullopt;
        const Point3 p = light + (receiver - light) * part;
        if (!there(p.x, p.y, t)) return std::nullopt;
        return Stop{p, {0, 0, 1}, motion};
    };
}
inline Occluder sphere_occluder(Point3 centre, double radius) {
    return [=](Point3 light, Point3 receiver, double) -> std::optional<Stop> {
        const Point3 way = receiver - light, from = light - centre;
        const double a = dot(way, way), b = dot(way, from), c = dot(from, from) - radius * radius,
                     d = b * b - a * c;
        if (d < 0) return std::nullopt;
        const double s = (-b - std::sqrt(d)) / a;
        if (!(s > 0 && s < 1)) return std::nullopt;
        const Point3 p = light + way * s;
        return Stop{p, p - centre, {}};
    };
}

struct ShadowSetup {
    LightView::Shape shape = LightView::Shape::quad;
    double half = 1, d1 = 10, k = 100, focus = 7.5;
    Point3 normal{0, 0, 1};  // of the receiver plane through (0, 0, d1)
    double reach = 3;        // receivers lie in [-reach, reach]^2
    int spp = 16;            // light samples a light pixel
    bool timed = false;
    double open = 0, close = 1;  // of the samples' and the receivers' times
    unsigned seed = 1;
    bool rays = true;   // by rays; else by triangles, as published
    double search = 1;  // R, by rays
    Occluder occluder;

    double depth_at(double x, double y) const {
        return d1 - (normal.x * x + normal.y * y) / normal.z;
    }
};

class ShadowTest {
  public:
    explicit ShadowTest(const ShadowSetup& setup, double radius_scale = 1) : set_(setup) {
        view_.shape = setup.shape;
        view_.ax = view_.ay = setup.half;
        view_.k = setup.k, view_.focus = setup.focus, view_.spp = setup.spp;
        view_.nearest = 1e-3 * setup.d1;
        const double side = (2 * setup.reach + 0.6 * setup.d1) * setup.k / setup.d1;
        view_.width = view_.height = int(std::ceil(side)) + 8;
        view_.cx = view_.cy = 0.5 * view_.width;
        make_samples();
        PlainContext ctx;
        hierarchy_ = light_field::build_hierarchy(samples_, light_field::Arrangement::layers,
                                                  radius_scale, ctx);
        if (!set_.rays) return;
        passes_ = light_field::build_hierarchy(shadows::passes(hierarchy_, {}, {}, view_, {}, ctx),
                                               light_field::Arrangement::layers, radius_scale, ctx);
    }

    const LightView& view() const { return view_; }
    const Samples& samples() const { return samples_; }
    const Hierarchy& hierarchy() const { return hierarchy_; }

    // Shares of the light that the receiver at (x, y) sees: from points^2 points of the light, at
    // as many times.
    std::vector<float> shares(double x, double y, int points,
                              const shadows::VoteSettings& vote) const {
        std::mt19937 random(set_.seed * 7919 + unsigned(int(x * 1000)) * 31 +
                            unsigned(int(y * 1000)));
        std::uniform_real_distribution<double> unit(0, 1);
        Locations at;
        ShadowQueries ask;
        const Point3 p{x, y, set_.depth_at(x, y)};
        const auto slope = view_.inverse_depth_gradient(p, set_.normal);
        const size_t n = size_t(points) * size_t(points);
        at.own_pixels.assign(n, 0);
        at.pixels = at.own_pixels;
        // Times are even over the shutter, and over each row and column of the light's points.
        const size_t turn = random() % size_t(points);
        for (size_t i = 0; i < n; ++i) {
            const auto l = view_.point((double(i % size_t(points)) + unit(random)) / points,
                                       (double(i / size_t(points)) + unit(random)) / points, p);
            const auto q = view_.project(p, l[0], l[1]);
            at.x.push_back(float(q[0])), at.y.push_back(float(q[1]));
            at.u.push_back(float(l[0])), at.v.push_back(float(l[1]));
            const size_t slot = (i / size_t(points) + i + turn) % size_t(points);
            at.t.push_back(float(set_.open + (set_.close - set_.open) *
                                                 (double(slot) + unit(random)) / points));
        }
        ask.inverse_depth.assign(n, float(1 / p.z));
        ask.slope_x.assign(n, float(slope[0]));
        ask.slope_y.assign(n, float(slope[1]));
        ask.sample.assign(n, 0);
        const auto [x0, x1] = std::minmax_element(at.x.begin(), at.x.end());
        const auto [y0, y1] = std::minmax_element(at.y.begin(), at.y.end());
        at.x0 = int(*x0), at.y0 = int(*y0), at.x1 = int(*x1) + 1, at.y1 = int(*y1) + 1;
        return run(at, ask, vote).share;
    }
    double share(double x, double y = 0, int points = 16,
                 const shadows::VoteSettings& vote = {}) const {
        const std::vector<float> all = shares(x, y, points, vote);
        double sum = 0;
        for (const float s : all) sum += double(s);
        return sum / double(all.size());
    }

    // Stage by stage, as parts/soft-shadow-z-reconstruct.json has them.
    LightShares run(const Locations& at, const ShadowQueries& ask,
                    const shadows::VoteSettings& vote) const {
        using namespace light_field;
        Block block;
        Candidates candidates;
        Surfaces surfaces;
        Visibility visibility;
        light_field::ClusterScratch cluster;
        light_field::CoverageScratch coverage;
        LightShares shares;
        for (Batch* batch :
             std::initializer_list<Batch*>{&candidates, &surfaces, &visibility, &shares})
            batch->pixels = at.pixels;
        const float wide = set_.rays ? float(set_.search) : 2.0f,
                    radius = wide * light_field::largest_radius(hierarchy_, at);
        light_field::collect(hierarchy_, at.x0, at.y0, at.x1, at.y1, radius, block);
        WEFT_PICK(gather_each)(hierarchy_, block, at, radius, candidates);
        light_field::narrow(wide, at, candidates);
        if (set_.rays) {
            const shadows::RayVoteAround rays(hierarchy_, passes_, view_, {vote.test, vote.bias});
            shadows::RayVoteAround::Scratch scratch;
            rays.vote(candidates, at, ask, wide, 1, scratch, shares);
            return shares;
        }
        WEFT_PICK(cluster)(candidates, {}, cluster, surfaces);
        WEFT_PICK(cover_finally)(candidates, surfaces, hierarchy_.radius, coverage, visibility);
        shadows::depth_vote(candidates, surfaces, visibility, ask, {hierarchy_, view_}, vote,
                            shares);
        return shares;
    }

  private:
    void make_samples() {
        std::mt19937 random(set_.seed);
        std::uniform_real_distribution<double> unit(0, 1);
        const double reach = set_.reach + 0.2 * set_.d1, pixel = set_.d1 / set_.k;
        const int side = int(std::ceil(2 * reach / pixel));
        shadows::LightSampleArrays made(size_t(side) * size_t(side) * size_t(set_.spp));
        const int strata = int(std::lround(std::sqrt(set_.spp)));
        size_t place = 0;
        shadows::Unseen unseen;
        for (int j = 0; j < side; ++j)
            for (int i = 0; i < side; ++i)
                for (int s = 0; s < set_.spp; ++s, ++place) {
                    // Stratified in the pixel where spp is a square; the light's points over blocks
                    // of pixels.
                    const bool square = strata * strata == set_.spp;
                    const double fx = square ? (s % strata + unit(random)) / strata : unit(random);
                    const double fy = square ? (s / strata + unit(random)) / strata : unit(random);
                    Point3 p{-reach + (i + fx) * pixel, -reach + (j + fy) * pixel, 0};
                    p.z = set_.depth_at(p.x, p.y);
                    shadows::LightHit hit;
                    hit.t = set_.timed ? set_.open + (set_.close - set_.open) * unit(random) : 0.5;
                    const auto l = view_.point(unit(random), unit(random), p);
                    hit.lx = l[0], hit.ly = l[1];
                    hit.at = p, hit.normal = set_.normal;
                    const Point3 light{view_.ax * l[0], view_.ay * l[1], 0};
                    if (set_.occluder)
                        if (const auto stop = set_.occluder(light, p, hit.t))
                            hit.at = stop->at, hit.normal = stop->normal, hit.motion = stop->motion;
                    if (shadows::LightSampleArrays::seen(view_, hit, unseen)) made.set(place, view_, hit);
                }
        Samples camera;
        samples_ = std::move(made).take(view_, camera);
    }

    ShadowSetup set_;
    LightView view_;
    Samples samples_;
    Hierarchy hierarchy_, passes_;
};

// Error over receivers (x, 0), x even in [low, high].
struct ShadowError {
    double rmse = 0, bias = 0;
};
inline ShadowError error_over(const ShadowTest& test, double low, double high, int count,
                              const std::function<double(double)>& exact,
                              const shadows::VoteSettings& vote = {}) {
    ShadowError e;
    for (int i = 0; i < count; ++i) {
        const double x = low + (high - low) * i / (count - 1),
                     d = test.share(x, 0, 16, vote) - exact(x);
        e.rmse += d * d / count;
        e.bias += d / count;
    }
    e.rmse = std::sqrt(e.rmse);
    return e;
}

// What is seen of a quad light, half extent 1, past a half-plane X < edge in w = d2.
inline double past_edge_quad(double x, double edge, double d1, double d2, double half = 1) {
    const double y = (edge - x * d2 / d1) / (1 - d2 / d1) / half;
    return std::clamp((1 - y) / 2, 0.0, 1.0);
}
inline double past_edge_disc(double x, double edge, double d1, double d2) {
    const double y = std::clamp((edge - x * d2 / d1) / (1 - d2 / d1), -1.0, 1.0);
    return (std::acos(y) - y * std::sqrt(1 - y * y)) / pi_d;
}
// Area that two discs, of radius 1 and r with centres d apart, have in common.
inline double common_area(double r, double d) {
    if (d >= 1 + r) return 0;
    if (d <= std::abs(1 - r)) return pi_d * std::min(1.0, r * r);
    const double a = std::acos((d * d + 1 - r * r) / (2 * d)),
                 b = std::acos((d * d + r * r - 1) / (2 * d * r));
    return a + r * r * b - 0.5 * std::sqrt((-d + 1 + r) * (d + 1 - r) * (d - 1 + r) * (d + 1 + r));
}
inline double past_disc(double x, double r, double d1, double d2) {
    const double share = d2 / d1;
    return 1 - common_area(r / (1 - share), std::abs(x) * share / (1 - share)) / pi_d;
}

}  // namespace weft
