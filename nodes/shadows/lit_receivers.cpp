// lit-receivers: which of the camera's samples see all of a light, whatever point of it is asked
// for (lit_receivers_kernel.h).
#include <algorithm>
#include <cmath>

#include "runtime/node.h"
#include "shadows/lit_receivers_kernel.h"
#include "shadows/planes.h"

namespace weft {
namespace shadows {

void LightBounds::resize(size_t n) {
    for (auto* values : {&x_low, &y_low}) values->resize(n + spare, 2e30f);
    for (auto* values : {&x_high, &y_high}) values->resize(n + spare, -2e30f);
    nearest.resize(n + spare, 0);
    for (auto* values : {&top, &rise_x, &rise_y}) values->resize(n + spare, 0);
    group.resize(n + spare);
}

std::vector<LightBounds> bounds_of(const Hierarchy& h) {
    const auto add = [](LightBounds& to, size_t i, float x0, float x1, float y0, float y1, float nearest) {
        to.x_low[i] = std::min(to.x_low[i], x0), to.x_high[i] = std::max(to.x_high[i], x1);
        to.y_low[i] = std::min(to.y_low[i], y0), to.y_high[i] = std::max(to.y_high[i], y1);
        to.nearest[i] = std::max(to.nearest[i], nearest);
    };
    // Whole blocks of the level above may be read.
    const auto make = [](size_t size) {
        LightBounds level;
        level.size = size;
        level.resize(size + Hierarchy::fan_out);
        return level;
    };
    std::vector<LightBounds> levels{make(h.groups.size())};
    LightBounds& groups = levels[0];
    struct Place {
        float x, y, inverse;
    };
    std::vector<Place> places;
    for (size_t g = 0; g < groups.size; ++g) {
        const size_t begin = g * Hierarchy::group_size,
                     end = std::min(begin + Hierarchy::group_size, h.size());
        places.clear();
        bool anywhere = false;
        for (size_t s = begin; s < end; ++s) {
            const Hierarchy::Velocity v = h.velocity(s);
            for (const float d : {-0.5f, 0.5f}) {
                if (d > 0 && !h.groups.moves[g]) continue;
                const float W = h.W[s] + d * v.w;
                // (What the light's plane passes may be anywhere.)
                if (!(W > 0)) {
                    add(groups, g, -1e30f, 1e30f, -1e30f, 1e30f, 1e30f);
                    anywhere = true;
                    continue;
                }
                const float inverse = 1 / W, x = (h.X[s] + d * v.x) * inverse,
                            y = (h.Y[s] + d * v.y) * inverse;
                add(groups, g, x, x, y, y, inverse);
                places.push_back({x, y, inverse});
            }
            if (h.plane_x.empty()) continue;
            groups.rise_x[g] += h.plane_x[s] / float(end - begin);
            groups.rise_y[g] += h.plane_y[s] / float(end - begin);
        }
        const float x = 0.5f * (groups.x_low[g] + groups.x_high[g]),
                    y = 0.5f * (groups.y_low[g] + groups.y_high[g]);
        groups.top[g] = anywhere ? 1e30f : 0;
        for (const Place& p : places)
            groups.top[g] = std::max(groups.top[g], p.inverse - groups.rise_x[g] * (p.x - x) -
                                                        groups.rise_y[g] * (p.y - y));
    }
    constexpr size_t few = 64;
    do {
        const LightBounds& below = levels.back();
        LightBounds above = make((below.size + Hierarchy::fan_out - 1) / Hierarchy::fan_out);
        for (size_t i = 0; i < below.size; ++i)
            add(above, i / Hierarchy::fan_out, below.x_low[i], below.x_high[i], below.y_low[i],
                below.y_high[i], below.nearest[i]);
        levels.push_back(std::move(above));
    } while (levels.back().size > few);
    return levels;
}

}  // namespace shadows

namespace {
using namespace shadows;

struct LitReceivers {
    DepthTest test = DepthTest::both_planes;
    float bias = 1e-5f, search = 1, wide = 2;

    static void declare(Ports<LitReceivers>& node) {
        node.about(
                "finds the camera's samples that see all of a light for sure: locate-receivers asks "
                "nothing for locations that see one of them")
            .in<Hierarchy>("hits", "of the light samples")
            .in<Hierarchy>("hierarchy", "of the camera's samples")
            .in<Samples>("samples", "the same, with light_density as in the search to come")
            .in<LightView>("light-view", "of the same samples")
            .out<Samples>("samples", "the same and all_lit: of those, how far around nothing comes, in R, `search` "
                          "or `wide`; 0 of all others")
            .choice("test", &LitReceivers::test, {"both-planes", "inverse-depth", "linear"},
                    {.about = "of the vote; all others than both-planes: none is found"})
            .param("bias", &LitReceivers::bias,
                   {.min = 0, .max = 1e6, .about = "of the vote; relative"})
            .param("search", &LitReceivers::search,
                   {.unit = "R", .min = 0.05, .max = 32, .about = "how far light samples are looked for"})
            .param("wide", &LitReceivers::wide,
                   {.unit = "R",
                    .min = 0.05,
                    .max = 32,
                    .about = "if nothing comes within so much more, that is told, too: passing-rays "
                             "looks farther"});
    }
    Cost cost(const Shapes& in) const {
        const double n = double(in["samples"].records);
        return {{{"samples", {0, 0, 0, std::int64_t(n), 4 * n}}}, 2 * n, 300 * n};
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Hierarchy &hits = in.get<Hierarchy>("hits"), &camera = in.get<Hierarchy>("hierarchy");
        const Samples& samples = in.get<Samples>("samples");
        const LightView& view = in.get<LightView>("light-view");
        const Receivers receivers(camera, samples, view);
        std::vector<float> lit(samples.size(), 0);
        // Points of balls differ from receiver to receiver, and R where its density is not known.
        const bool able = test == DepthTest::both_planes && view.same_points() &&
                          (receivers.ratios() || hits.radii.empty());
        if (able) find(hits, camera, receivers, view, lit, ctx);
        Samples with = samples;
        with.add("all_lit", 1, std::move(lit));
        out.set("samples", std::move(with));
    }

  private:
    void find(const Hierarchy& hits, const Hierarchy& camera, const Receivers& receivers,
              const LightView& view, std::vector<float>& lit, Context& ctx) const {
        const std::vector<LightBounds> levels = bounds_of(hits);
        LitSettings set;
        set.c0x = std::abs(hits.lens.c0 * hits.lens.aspect), set.c0y = std::abs(hits.lens.c0);
        set.round = view.shape == LightView::Shape::disc;
        set.px = 1 / float(view.k);
        // Less by what the vote's own numbers are rounded by.
        set.bias = std::max(0.0f, bias - 2e-6f);
        // Farther searches may be for ellipses.
        set.sure = search <= 1 ? 0.99f : 0.1f;
        const float farthest = std::max(search, wide);
        set.search = search / farthest;
        constexpr size_t group = Hierarchy::group_size;
        ctx.parallel((camera.size() + group - 1) / group, 256, [&](size_t begin, size_t end) {
            LitScratch scratch;
            std::array<StillReceiver, group> still;
            std::array<std::uint32_t, group> sample;
            std::array<std::uint8_t, group> found;
            for (size_t g = begin; g < end; ++g) {
                size_t n = 0;
                for (size_t s = g * group; s < std::min((g + 1) * group, camera.size()); ++s) {
                    const Receiver r = receivers.of(std::uint32_t(s));
                    sample[n] = r.sample;
                    n += as_still(r, view, set, farthest * hits.radius, still[n]);
                }
                WEFT_PICK(find_lit)
                (hits, levels, set, std::span(still).first(n), scratch, found.data());
                for (size_t i = 0; i < n; ++i)
                    lit[sample[i]] = found[i] == 0 ? 0 : found[i] == 1 ? search : farthest;
            }
        });
    }

    // False where it is none, or is not on the film from all points of the light.
    bool as_still(const Receiver& r, const LightView& view, const LitSettings& set, float radius,
                  StillReceiver& out) const {
        const float w = r.open[2];
        if (r.sample == SeenSamples::none || !(w > 0)) return false;
        for (const float way : r.way)
            if (!(std::abs(way) <= 1e-5f * w)) return false;
        out.far = 1 / std::max(w, w + r.way[2]), out.near = 1 / std::min(w, w + r.way[2]);
        const auto on_film = [&](size_t axis, double centre, float& low, float& high) {
            const float open = float(centre + view.k * double(r.open[axis]) / double(w)),
                        close = float(centre + view.k * double(r.open[axis] + r.way[axis]) /
                                                   double(w + r.way[2]));
            low = std::min(open, close), high = std::max(open, close);
        };
        on_film(0, view.cx, out.x_low, out.x_high), on_film(1, view.cy, out.y_low, out.y_high);
        const float across = std::abs(float(view.c0x()) / w + float(view.c1x())),
                    down = std::abs(float(view.c0y()) / w + float(view.c1y()));
        if (!(out.x_low - across > 0.1f && out.x_high + across < float(view.width) - 0.1f &&
              out.y_low - down > 0.1f && out.y_high + down < float(view.height) - 0.1f))
            return false;
        // Planes that are nearly seen edge-on count as level or not, by rounding.
        const float plane = r.normal[0] * r.open[0] + r.normal[1] * r.open[1] + r.normal[2] * w,
                    facing = std::abs(plane) / w;
        if (facing > 0.9e-3f && facing < 1.1e-3f) return false;
        const float rise = facing > 1e-3f ? 1 / (float(view.k) * plane) : 0;
        out.slope_x = r.normal[0] * rise, out.slope_y = r.normal[1] * rise;
        out.turn = 1 - std::abs(set.c0x * out.slope_x) - std::abs(set.c0y * out.slope_y);
        if (!(out.turn > 0.15f)) return false;
        // A little more, for rounding.
        out.radius = radius * r.ratio * 1.0001f + 1e-3f;
        out.behind = (std::abs(out.slope_x) + std::abs(out.slope_y)) * out.radius / out.turn;
        return true;
    }
};

WEFT_NODE(LitReceivers, "lit-receivers", 1)

}  // namespace
}  // namespace weft
