#include "shadows/passing_rays_kernel.h"

#include <algorithm>
#include <cmath>

#include "light-field/kernels.h"
#include "light-field/local_radius.h"
#include "light-field/sample_order.h"
#include "light-field/streams.h"
#include "shadows/gather_before_kernel.h"
#include "shadows/planes.h"

namespace weft::light_field {
namespace {

void tell_surfaces(const Candidates& of, ClusterScratch& scratch, Surfaces& out) {
    WEFT_PICK(cluster)(of, {}, scratch, out);
}

}  // namespace
}  // namespace weft::light_field

namespace weft::shadows {
namespace {

// Rays that are looked at together: near each other on the film.
constexpr size_t batch_size = 64, batches_at_once = 64;
constexpr int block = 8;  // px

struct Pass {
    std::uint32_t ray, surface;  // samples of the hierarchy: whose ray, past whose surface
    float depth;                 // w of the surface's plane where the ray goes by
    float bulge;                 // px: half the radius of what bends there
};

// Light samples as rays: where, from where and when each was sent.
class Rays {
  public:
    explicit Rays(const Hierarchy& h) : h_(h) {}

    struct Ray {
        float x, y, u, v, t, depth;  // px; w where it ends
    };
    // Of sample s of the hierarchy.
    Ray operator[](std::uint32_t s) const {
        const size_t j = h_.order[s];
        Ray ray{0, 0, 0, 0, h_.t.empty() ? 0.5f : h_.t[j], 0};
        if (!h_.uv.empty()) ray.u = h_.uv[2 * j], ray.v = h_.uv[2 * j + 1];
        const float d = ray.t - 0.5f;
        const Hierarchy::Velocity velocity = h_.velocity(s);
        ray.depth = h_.W[s] + d * velocity.w;
        const float slope = h_.lens.c0 / ray.depth + h_.lens.c1;
        ray.x = (h_.X[s] + d * velocity.x) / ray.depth + slope * h_.lens.aspect * ray.u;
        ray.y = (h_.Y[s] + d * velocity.y) / ray.depth + slope * ray.v;
        return ray;
    }
    // By blocks of film.
    LargeArray<std::uint32_t> in_blocks(Context& ctx) const {
        LargeArray<std::uint64_t> keys(h_.size());
        const std::uint64_t columns = std::uint64_t(h_.width / block) + 1;
        ctx.parallel(h_.size(), 65536, [&](size_t begin, size_t end) {
            for (size_t s = begin; s < end; ++s) {
                const Ray ray = (*this)[std::uint32_t(s)];
                keys[s] = std::uint64_t(std::max(ray.y, 0.0f)) / block * columns +
                          std::uint64_t(std::max(ray.x, 0.0f)) / block;
            }
        });
        return light_field::sorted(std::move(keys), ctx);
    }

  private:
    const Hierarchy& h_;
};

class Finder {
  public:
    Finder(const Hierarchy& hits, std::span<const float> density, const LightView& view,
           const PassingRays& set)
        : rays_(hits), density_(density), planes_(hits, view), view_(view), set_(set) {
        // Of each group the greatest 1/w over the shutter.
        nearest_.resize(hits.groups.size());
        for (size_t g = 0; g < nearest_.size(); ++g) {
            float most = 0;
            const size_t begin = g * Hierarchy::group_size,
                         end = std::min(begin + Hierarchy::group_size, hits.size());
            for (size_t s = begin; s < end; ++s) {
                const float w = hits.W[s] - 0.5f * std::abs(hits.velocity(s).w);
                most = std::max(most, w > 0 ? 1 / w : 1e30f);
            }
            nearest_[g] = most;
        }
    }

    struct Scratch {
        Locations at;
        ShadowQueries ends;
        light_field::Block block;
        Candidates candidates;
        Surfaces surfaces;
        light_field::ClusterScratch cluster;
    };

    // Appends what the rays of samples `of` pass.
    void find(std::span<const std::uint32_t> of, Scratch& scratch, std::vector<Pass>& found) const {
        const Hierarchy& h = planes_.hierarchy();
        Locations& at = scratch.at;
        ask(of, at, scratch.ends);
        const float radius = set_.radius_scale * light_field::largest_radius(h, at);
        light_field::collect(h, at.x0, at.y0, at.x1, at.y1, radius, scratch.block);
        for (Batch* batch : std::initializer_list<Batch*>{&scratch.candidates, &scratch.surfaces})
            batch->pixels = at.pixels;
        Candidates& c = scratch.candidates;
        WEFT_PICK(gather_before)
        (h, scratch.block, nearest_, view_, at, scratch.ends, set_.radius_scale, set_.bias, c);
        light_field::tell_surfaces(c, scratch.cluster, scratch.surfaces);
        // Of each surface the samples that land nearest and farthest.
        for (size_t l = 0; l < of.size(); ++l)
            for (std::uint16_t k = 0; k < scratch.surfaces.count_of[l]; ++k) {
                float least = 1e38f, most = -1;
                std::uint32_t nearest = 0, farthest = 0;
                for (std::uint32_t i = c.offset[l]; i < c.offset[l + 1]; ++i) {
                    if (scratch.surfaces.surface[i] != k) continue;
                    const float d2 = c.dx[i] * c.dx[i] + c.dy[i] * c.dy[i];
                    if (d2 < least) least = d2, nearest = i;
                    if (d2 > most) most = d2, farthest = i;
                }
                const std::uint32_t s = c.sample[nearest];
                const float lx = c.u_of(l), ly = c.v_of(l), d = c.t_of(l) - 0.5f;
                const float tilt = tilt_of(s, lx, ly, d),
                            inner = tilt_of(c.sample[farthest], lx, ly, d);
                found.push_back(
                    {of[l], s, planes_.depth_beside(s, c.dx[nearest], c.dy[nearest], lx, ly, d),
                     0.5f * radius_of(std::sqrt(least), tilt, std::sqrt(most), inner)});
            }
    }

  private:
    // The squared tangent of the angle between a sample's normal and the ray to it.
    float tilt_of(std::uint32_t s, float lx, float ly, float d) const {
        const Slope h = planes_.from(planes_.slope(s), lx, ly);
        const float scale = planes_.depth_at(s, d) * float(view_.k);
        return (h.x * h.x + h.y * h.y) * scale * scale;
    }
    // The radius, px, of a surface that bends away to its outline between a ray that goes by and
    // two of its samples, `near` and `far` px from the ray; 0 if it does not bend. Near a ball's
    // outline the tilt is r / (2 px) so many px inside.
    static float radius_of(float near, float tilt, float far, float inner) {
        const float change = 1 / std::max(inner, 1e-6f) - 1 / std::max(tilt, 1e-6f);
        if (!(change > 0)) return 0;
        // A ray that goes by is about as far outside as the nearest sample is inside. Where the
        // samples' tilts differ by much less than that of a ball would, it is a face with an edge.
        const float by_both = 2 * (far - near) / change, by_nearest = near * tilt;
        return by_both > 4 * by_nearest ? 0 : by_both;
    }
    // The rays as places on the film, and what they meet.
    void ask(std::span<const std::uint32_t> of, Locations& at, ShadowQueries& ends) const {
        const Hierarchy& h = planes_.hierarchy();
        const size_t n = of.size();
        for (auto* values : {&at.x, &at.y, &at.u, &at.v, &at.t, &ends.inverse_depth,
                             &ends.slope_x, &ends.slope_y})
            values->resize(n);
        at.ratio.resize(density_.empty() ? 0 : n);
        at.own_pixels.assign(n, 0);
        at.pixels = at.own_pixels;
        at.shared = false;
        float x0 = 1e30f, y0 = 1e30f, x1 = -1e30f, y1 = -1e30f;
        for (size_t l = 0; l < n; ++l) {
            const Rays::Ray ray = rays_[of[l]];
            at.x[l] = ray.x, at.y[l] = ray.y;
            at.u[l] = ray.u, at.v[l] = ray.v, at.t[l] = ray.t;
            const Slope slope = planes_.slope(of[l]);
            ends.inverse_depth[l] = 1 / ray.depth;
            ends.slope_x[l] = slope.x, ends.slope_y[l] = slope.y;
            if (!density_.empty()) at.ratio[l] = std::sqrt(density_[h.source[h.order[of[l]]]]);
            x0 = std::min(x0, at.x[l]), x1 = std::max(x1, at.x[l]);
            y0 = std::min(y0, at.y[l]), y1 = std::max(y1, at.y[l]);
        }
        at.x0 = int(std::floor(x0)), at.y0 = int(std::floor(y0));
        at.x1 = int(std::floor(x1)) + 1, at.y1 = int(std::floor(y1)) + 1;
    }
    const Rays rays_;
    const std::span<const float> density_;
    const Planes planes_;
    const LightView& view_;
    const PassingRays set_;
    LargeArray<float> nearest_;
};

// As samples, in order.
Samples as_samples(const std::vector<std::vector<Pass>>& found, const Hierarchy& hits) {
    const Rays rays(hits);
    size_t n = 0;
    for (const auto& some : found) n += some.size();
    Samples out;
    out.width = hits.width, out.height = hits.height;
    out.domain = "light";
    out.color_space = hits.color_space;
    out.set_size(n);
    const bool lens = !hits.uv.empty(), tilted = !hits.plane_x.empty();
    if (lens) out.lens = hits.lens;
    // write(pass, its ray, where its numbers go).
    const auto add = [&](const char* name, size_t components, auto&& write) {
        std::vector<float> all(components * n);
        float* to = all.data();
        for (const auto& some : found)
            for (const Pass& pass : some) write(pass, rays[pass.ray], to), to += components;
        out.add(name, int(components), std::move(all));
    };
    using Ray = Rays::Ray;
    add("xy", 2, [](const Pass&, const Ray& ray, float* to) { to[0] = ray.x, to[1] = ray.y; });
    if (lens)
        add("uv", 2, [](const Pass&, const Ray& ray, float* to) { to[0] = ray.u, to[1] = ray.v; });
    if (hits.moving) {
        add("t", 1, [](const Pass&, const Ray& ray, float* to) { *to = ray.t; });
        add("motion", 3, [&](const Pass& pass, const Ray&, float* to) {
            const Hierarchy::Velocity velocity = hits.velocity(pass.surface);
            to[0] = velocity.x, to[1] = velocity.y, to[2] = velocity.w;
        });
    }
    add("z", 1, [](const Pass& pass, const Ray&, float* to) { *to = pass.depth; });
    if (tilted)
        add("z_gradient", 2, [&](const Pass& pass, const Ray&, float* to) {
            const float square = -pass.depth * pass.depth;
            to[0] = hits.plane_x[pass.surface] * square;
            to[1] = hits.plane_y[pass.surface] * square;
        });
    add("bulge", 1, [](const Pass& pass, const Ray&, float* to) { *to = pass.bulge; });
    add("end", 1, [](const Pass&, const Ray& ray, float* to) { *to = ray.depth; });
    std::vector<std::uint64_t> first(out.pixels() + 1, 0);
    first.back() = n;
    out.first = std::move(first);
    return out;
}

}  // namespace

Samples passes(const Hierarchy& hits, std::span<const float> density,
               std::span<const float> clear, const LightView& view, const PassingRays& set,
               Context& ctx) {
    LargeArray<std::uint32_t> order = Rays(hits).in_blocks(ctx);
    if (!clear.empty())
        std::erase_if(order, [&](std::uint32_t s) {
            return clear[hits.source[hits.order[s]]] >= set.radius_scale;
        });
    const size_t n = order.size();
    const Finder finder(hits, density, view, set);
    constexpr size_t part = batch_size * batches_at_once;
    std::vector<std::vector<Pass>> found((n + part - 1) / part);
    ctx.parallel(found.size(), 1, [&](size_t begin, size_t end) {
        Finder::Scratch scratch;
        for (size_t p = begin; p < end; ++p)
            for (size_t i = p * part; i < std::min((p + 1) * part, n); i += batch_size)
                finder.find(std::span(order.data() + i, std::min(batch_size, n - i)), scratch,
                            found[p]);
    });
    Samples out = as_samples(found, hits);
    // As dense as the rays are.
    Json light = Json::object();
    light.set("name", view.name);
    light.set("camera_spp", hits.mean_spp);
    out.meta = Json::object();
    out.meta.set("light", std::move(light));
    out.meta = out.meta_object();
    return out;
}

}  // namespace weft::shadows
