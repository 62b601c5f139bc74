#include "shadows/passing_rays_kernel.h"

#include <algorithm>
#include <cmath>

#include "light-field/kernels.h"
#include "light-field/local_radius.h"
#include "light-field/sample_order.h"
#include "light-field/streams.h"
#include "shadows/planes.h"

namespace weft::shadows {
namespace {

// Rays that are looked at together: near each other on the film.
constexpr size_t batch_size = 64, batches_at_once = 64;
constexpr int block = 8;  // px

struct Pass {
    std::uint32_t ray, surface;  // samples of the buffer: whose ray, past whose surface
    float depth;                 // w of the surface's plane where the ray goes by
};

// Light samples by blocks of film, as their rays see it.
LargeArray<std::uint32_t> in_blocks(const Samples& samples, Context& ctx) {
    const auto xy = samples.xy();
    LargeArray<std::uint64_t> keys(samples.size());
    const std::uint64_t columns = std::uint64_t(samples.width / block) + 1;
    ctx.parallel(samples.size(), 65536, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            keys[i] = std::uint64_t(std::max(xy[2 * i + 1], 0.0f)) / block * columns +
                      std::uint64_t(std::max(xy[2 * i], 0.0f)) / block;
    });
    return light_field::sorted(std::move(keys), ctx);
}

class Finder {
  public:
    Finder(const Samples& samples, const Hierarchy& hierarchy, std::span<const float> density,
           const LightView& view, const PassingRays& set)
        : samples_(samples),
          density_(density),
          planes_(hierarchy, samples.values("z_gradient"), samples.z(), view),
          set_(set),
          source_(samples.find("source")) {}

    struct Scratch {
        Locations at;
        light_field::Block block;
        Candidates candidates;
        Surfaces surfaces;
        light_field::ClusterScratch cluster;
    };

    // Appends what the rays of samples `of` pass.
    void find(std::span<const std::uint32_t> of, Scratch& scratch, std::vector<Pass>& found) const {
        using namespace light_field;
        const Hierarchy& h = planes_.hierarchy();
        Locations& at = scratch.at;
        ask(of, at);
        const float radius = set_.radius_scale * light_field::largest_radius(h, at);
        light_field::collect(h, at.x0, at.y0, at.x1, at.y1, radius, scratch.block);
        for (Batch* batch : std::initializer_list<Batch*>{&scratch.candidates, &scratch.surfaces})
            batch->pixels = at.pixels;
        Candidates& c = scratch.candidates;
        WEFT_PICK(gather_each)(h, scratch.block, at, radius, c);
        light_field::narrow(set_.radius_scale, at, c);
        keep_before(of, c);
        WEFT_PICK(cluster)(c, {}, scratch.cluster, scratch.surfaces);
        // Of each surface the sample that lands nearest.
        for (size_t l = 0; l < of.size(); ++l)
            for (std::uint16_t k = 0; k < scratch.surfaces.count_of[l]; ++k) {
                float least = 1e38f;
                std::uint32_t nearest = 0;
                for (std::uint32_t i = c.offset[l]; i < c.offset[l + 1]; ++i) {
                    if (scratch.surfaces.surface[i] != k) continue;
                    const float d2 = c.dx[i] * c.dx[i] + c.dy[i] * c.dy[i];
                    if (d2 < least) least = d2, nearest = i;
                }
                found.push_back(
                    {of[l], h.order[c.sample[nearest]],
                     planes_.depth_beside(c.sample[nearest], c.dx[nearest], c.dy[nearest],
                                          c.u_of(l), c.v_of(l), c.t_of(l) - 0.5f)});
            }
    }

  private:
    // The rays as places on the film.
    void ask(std::span<const std::uint32_t> of, Locations& at) const {
        const auto xy = samples_.xy(), uv = samples_.uv(), t = samples_.t();
        const size_t n = of.size();
        for (auto* values : {&at.x, &at.y, &at.u, &at.v, &at.t}) values->resize(n);
        at.ratio.resize(density_.empty() ? 0 : n);
        at.own_pixels.assign(n, 0);
        at.pixels = at.own_pixels;
        at.shared = false;
        float x0 = 1e30f, y0 = 1e30f, x1 = -1e30f, y1 = -1e30f;
        for (size_t l = 0; l < n; ++l) {
            const std::uint32_t j = of[l];
            at.x[l] = xy[2 * j], at.y[l] = xy[2 * j + 1];
            at.u[l] = uv.empty() ? 0 : uv[2 * j], at.v[l] = uv.empty() ? 0 : uv[2 * j + 1];
            at.t[l] = t.empty() ? 0.5f : t[j];
            if (!density_.empty()) at.ratio[l] = std::sqrt(density_[source_ ? source_->ids[j] : j]);
            x0 = std::min(x0, at.x[l]), x1 = std::max(x1, at.x[l]);
            y0 = std::min(y0, at.y[l]), y1 = std::max(y1, at.y[l]);
        }
        at.x0 = int(std::floor(x0)), at.y0 = int(std::floor(y0));
        at.x1 = int(std::floor(x1)) + 1, at.y1 = int(std::floor(y1)) + 1;
    }
    // Leaves each ray the samples whose surfaces stand before its hit.
    void keep_before(std::span<const std::uint32_t> of, Candidates& c) const {
        std::uint32_t kept = 0;
        for (size_t l = 0; l < of.size(); ++l) {
            const std::uint32_t j = of[l];
            const float lx = c.u_of(l), ly = c.v_of(l), d = c.t_of(l) - 0.5f;
            const Seen hit{1 / samples_.z()[j], planes_.from(planes_.slope(j), lx, ly)};
            const std::uint32_t begin = std::exchange(c.offset[l], kept);
            const std::uint32_t end = c.offset[l + 1];
            for (std::uint32_t i = begin; i < end; ++i) {
                if (!planes_.before(hit, c.sample[i], c.dx[i], c.dy[i], lx, ly, d,
                                    DepthTest::both_planes, set_.bias))
                    continue;
                c.dx[kept] = c.dx[i], c.dy[kept] = c.dy[i], c.sample[kept] = c.sample[i];
                ++kept;
            }
        }
        c.offset[of.size()] = kept;
    }

    const Samples& samples_;
    std::span<const float> density_;
    Planes planes_;
    PassingRays set_;
    const Channel* source_;
};

template <class T>
std::vector<T> grown(std::span<const T> values, size_t size) {
    std::vector<T> out;
    out.reserve(size);
    out.assign(values.begin(), values.end());
    out.resize(size);
    return out;
}

}  // namespace

Samples with_passes(const Samples& samples, const Hierarchy& hierarchy,
                    std::span<const float> density, const LightView& view, const PassingRays& set,
                    Context& ctx) {
    const size_t n = samples.size();
    const LargeArray<std::uint32_t> order = in_blocks(samples, ctx);
    const Finder finder(samples, hierarchy, density, view, set);
    constexpr size_t part = batch_size * batches_at_once;
    std::vector<std::vector<Pass>> found((n + part - 1) / part);
    ctx.parallel(found.size(), 1, [&](size_t begin, size_t end) {
        Finder::Scratch scratch;
        for (size_t p = begin; p < end; ++p)
            for (size_t i = p * part; i < std::min((p + 1) * part, n); i += batch_size)
                finder.find(std::span(order.data() + i, std::min(batch_size, n - i)), scratch,
                            found[p]);
    });
    size_t size = n;
    for (const auto& passes : found) size += passes.size();

    Samples out = samples;
    out.set_size(size);
    const auto xy = samples.xy(), uv = samples.uv(), t = samples.t(), z = samples.z(),
               motion = samples.motion(), gradient = samples.values("z_gradient");
    // Where the ray goes by, and how deep the surface is there and how it moves.
    const auto extend = [&](std::string_view name, int components, std::span<const float> values,
                            auto&& write) {
        if (values.empty()) return;
        std::vector<float> all = grown(values, size * size_t(components));
        size_t to = n;
        for (const auto& passes : found)
            for (const Pass& pass : passes) write(pass, &all[size_t(components) * to++]);
        out.add(std::string(name), components, std::move(all));
    };
    const auto pair = [](std::span<const float> from, std::uint32_t j, float* at) {
        at[0] = from[2 * j], at[1] = from[2 * j + 1];
    };
    extend("xy", 2, xy, [&](const Pass& p, float* at) { pair(xy, p.ray, at); });
    extend("uv", 2, uv, [&](const Pass& p, float* at) { pair(uv, p.ray, at); });
    extend("t", 1, t, [&](const Pass& p, float* at) { *at = t[p.ray]; });
    extend("z", 1, z, [&](const Pass& p, float* at) { *at = p.depth; });
    extend("motion", 3, motion,
           [&](const Pass& p, float* at) { std::copy_n(&motion[3 * p.surface], 3, at); });
    extend("z_gradient", 2, gradient,
           [&](const Pass& p, float* at) { pair(gradient, p.surface, at); });
    std::vector<float> end(n, 0);
    end.reserve(size);
    for (const auto& passes : found)
        for (const Pass& pass : passes) end.push_back(z[pass.ray]);
    out.add("end", 1, std::move(end));
    if (const Channel* source = samples.find("source")) {
        std::vector<std::uint32_t> all = grown(source->ids.view(), size);
        size_t to = n;
        for (const auto& passes : found)
            for (const Pass& pass : passes) all[to++] = source->ids[pass.ray];
        out.add_ids("source", std::move(all));
    }
    std::vector<std::uint64_t> first(out.pixels() + 1, 0);
    first.back() = size;
    out.first = std::move(first);
    out.meta = out.meta_object();
    return out;
}

}  // namespace weft::shadows
