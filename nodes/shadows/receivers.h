// Receivers: where what the camera's samples show stands before a light, and is to be looked up on
// its film. Source: Lehtinen et al. 2011, Sec. 4.  Departure: the light's points are two further
// dimensions of the locations' own set (light-field/points.h), common to a slice as (u, v, t) is,
// so that light samples are carried there once for all of its locations.
#pragma once
#include <algorithm>
#include <cmath>

#include "graph/error.h"
#include "light-field/location_number.h"
#include "light-field/points.h"
#include "light-field/streams.h"
#include "runtime/isa.h"
#include "shadows/light_view.h"
#include "shadows/streams.h"

namespace weft::shadows {

// What the receivers of a batch are, location by location, in light space; w is 0 where nothing is
// asked. The arrays are longer than needed, for whole vectors.
struct ReceiverBatch {
    std::vector<float> x, y, w, normal_x, normal_y, normal_w, ratio;
    std::vector<float> u, v;  // the light's point; empty: that of the whole batch

    void resize(size_t n, bool own_points) {
        constexpr size_t spare = 16;
        for (auto* values : {&x, &y, &w, &normal_x, &normal_y, &normal_w, &ratio})
            values->resize(n + spare);
        for (auto* values : {&u, &v}) values->resize(own_points ? n + spare : 0);
    }
};

// Where these are on the film: x, y, the pixels around, and ratio where it has any; and how deep,
// and how their planes rise (ShadowQueries). What lies outside is not asked, and lies with others.
#define WEFT_RECEIVER_KERNELS(isa)                                                            \
    namespace isa {                                                                           \
    void look_from_light(const LightView& view, const ReceiverBatch& receivers, Locations& at, \
                         ShadowQueries& ask);                                                 \
    }
WEFT_RECEIVER_KERNELS(v2)
WEFT_RECEIVER_KERNELS(v3)
WEFT_RECEIVER_KERNELS(v4)

// By what light samples are near a receiver: px of film, or by FilmMetric.
enum class Nearness { round, ellipse };

// That in which the ellipse of J J^T = (xx, xy, yy) (light_jacobian_kernel.h), no longer than `most`
// times its width, is a disc.
inline FilmMetric film_metric(const float* jj, float most) {
    const double mean = 0.5 * (double(jj[0]) + double(jj[2])),
                 half = 0.5 * (double(jj[0]) - double(jj[2])), xy = double(jj[1]),
                 spread = std::hypot(half, xy);
    if (!(spread > 1e-6 * mean)) return {};
    const double least = std::max(mean - spread, 1e-12 * mean),
                 ratio = std::min(std::sqrt((mean + spread) / least), double(most));
    const double middle = 0.5 * (1 / ratio + ratio), way = 0.5 * (1 / ratio - ratio) / spread;
    return {float(middle + way * half), float(way * xy), float(middle - way * half)};
}

// What a sample of the camera shows, in light space. (In one line of the cache.)
struct alignas(64) Receiver {
    std::array<float, 3> open,
        way;  // where it is at the shutter's opening; how it moves till its close
    std::array<float, 3> normal;  // of length 1 or, not known, 0
    float ratio = 1;              // of R there to R where a light's pixel is a camera's
    FilmMetric metric;
    std::uint32_t sample =
        SeenSamples::none;  // of the camera's buffer; none: of the hierarchy, nothing to light
};

class Receivers {
  public:
    // `hierarchy` of the camera's `samples`; of these geometric_normal, light_density, light_metric
    // and all_lit, if there. `most`: how much longer than wide a pixel of the camera may be on the
    // film; 1: it is round.
    Receivers(const Hierarchy& hierarchy, const Samples& samples, const LightView& view,
              float most = 1)
        : h_(hierarchy),
          view_(view),
          most_(most),
          metric_(most > 1 ? samples.values("light_metric") : std::span<const float>()),
          normals_(samples.values("geometric_normal")),
          density_(samples.values("light_density")),
          lit_(samples.values("all_lit")) {
        if (h_.size() != samples.size())
            throw Error(
                "'samples' are not those of 'hierarchy': link the ones that build-hierarchy got, "
                "or the ones they were made of");
        if (most > 1 && metric_.empty() && samples.size() > 0)
            throw Error(
                "'samples' have no light_metric, which ellipses are made of; set 'metric' of "
                "light-jacobian");
        for (size_t end : {0, 1})
            to_light_[end] = view.world_to_light[end] * view.pixel_to_world[end];
    }
    bool ratios() const { return !density_.empty(); }

    // Of sample s of the hierarchy.
    Receiver of(std::uint32_t s) const {
        Receiver r;
        if (h_.W[s] >= 0x1p+39f) return r;  // the background
        r.sample = h_.order[s];
        const Point3 middle{double(h_.X[s]), double(h_.Y[s]), double(h_.W[s])};
        Point3 half;
        if (h_.moving) {
            const Hierarchy::Velocity v = h_.velocity(s);
            half = Point3{double(v.x), double(v.y), double(v.w)} * 0.5;
        }
        const Point3 open = to_light_[0].point(middle - half),
                     close = to_light_[1].point(middle + half);
        r.open = floats(open), r.way = floats(close - open);
        r.normal = {};
        if (!normals_.empty()) {
            const size_t i = 3 * size_t(r.sample);
            const Point3 normal = view_.world_to_light[0].vector(
                {double(normals_[i]), double(normals_[i + 1]), double(normals_[i + 2])});
            if (const double square = dot(normal, normal); square > 0)
                r.normal = floats(normal * (1 / std::sqrt(square)));
        }
        if (ratios()) r.ratio = std::sqrt(density_[r.sample]);
        if (!metric_.empty()) r.metric = film_metric(&metric_[3 * size_t(r.sample)], most_);
        return r;
    }

    // Looks for what locations `from` see, `seen` of each: where on the film, from which point of
    // the light, how deep. `receiver(s)` is of(s), and may have a fetch(s) that is called a while before.
    template <class Of>
    void locate(std::uint64_t seed, const Locations& from, std::span<const std::uint32_t> seen,
                Of&& receiver, ReceiverBatch& batch, Locations& at, ShadowQueries& ask) const {
        const size_t n = from.size();
        start(seed, from, n, at);
        batch.resize(n, !at.shared);
        ask.sample.assign(n, SeenSamples::none);
        ask.outside = 0;
        at.ratio.resize(ratios() ? n : 0);
        ask.metric.assign(metric_.empty() ? 0 : n, {});
        for (size_t l = 0; l < n; ++l) {
            if constexpr (requires { receiver.fetch(0u); })
                if (l + ahead < n && seen[l + ahead] != SeenSamples::none)
                    receiver.fetch(seen[l + ahead]);
            batch.w[l] = 0;
            if (seen[l] == SeenSamples::none) continue;
            if (const std::uint32_t i = h_.order[seen[l]]; !lit_.empty() && lit_[i] > 0) {
                ask.sample[l] = i;
                continue;
            }
            const Receiver& r = receiver(seen[l]);
            ask.sample[l] = r.sample;
            if (r.sample == SeenSamples::none) continue;
            const float t = from.t_of(l);
            batch.x[l] = r.open[0] + t * r.way[0];
            batch.y[l] = r.open[1] + t * r.way[1];
            batch.w[l] = r.open[2] + t * r.way[2];
            batch.normal_x[l] = r.normal[0];
            batch.normal_y[l] = r.normal[1];
            batch.normal_w[l] = r.normal[2];
            batch.ratio[l] = r.ratio;
            if (!metric_.empty()) ask.metric[l] = r.metric;
            if (!(batch.w[l] > 0)) {
                ask.outside +=
                    view_.shines_behind() && double(batch.w[l]) < -view_.nearest;
                continue;
            }
            if (at.shared) continue;
            const auto on_light = view_.point(
                number(seed, from, l, 0), number(seed, from, l, 1),
                {double(batch.x[l]), double(batch.y[l]), double(batch.w[l])});
            batch.u[l] = at.u[l] = float(on_light[0]), batch.v[l] = at.v[l] = float(on_light[1]);
        }
        WEFT_PICK(look_from_light)(view_, batch, at, ask);
    }

  private:
    static constexpr size_t ahead = 16;
    static std::array<float, 3> floats(Point3 p) { return {float(p.x), float(p.y), float(p.z)}; }
    void start(std::uint64_t seed, const Locations& from, size_t n, Locations& at) const {
        at.shared = from.shared && view_.same_points();
        at.number = from.number;
        at.together = from.together;
        at.x.resize(n);
        at.y.resize(n);
        const size_t sets = at.shared ? 1 : n;
        at.u.assign(sets, 0);
        at.v.assign(sets, 0);
        at.t.resize(sets);
        for (size_t l = 0; l < sets && n > 0; ++l) at.t[l] = from.t_of(l);
        if (!at.shared || n == 0) return;
        const auto on_light = view_.point(number(seed, from, 0, 0), number(seed, from, 0, 1), {});
        at.u[0] = float(on_light[0]), at.v[0] = float(on_light[1]);
    }
    // A location's number for the light's point, in one of two dimensions.
    static double number(std::uint64_t seed, const Locations& from, size_t l, int dimension) {
        if (from.shared)
            return double(light_field::light_number(seed, std::uint32_t(from.number), dimension));
        return double(light_field::location_number(from.x[l], from.y[l], from.u_of(l), from.t_of(l),
                                                   mix(seed + std::uint64_t(dimension))));
    }

    const Hierarchy& h_;
    const LightView& view_;
    const float most_;
    std::span<const float> metric_, normals_, density_, lit_;
    std::array<Map3, 2>
        to_light_;  // of homogeneous places in the picture, at both ends of the shutter
};

}  // namespace weft::shadows
