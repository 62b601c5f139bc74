// slope-layers: sheared filters of layers. What moves alike, or is as much out of focus, is a layer
// of its own; each is filtered along its own slopes, and covers those behind it by the share of
// samples that are its own, filtered alike: so a thing that passes before another does not make
// either's filter narrow. Layers are found tile by tile, from the paths that cross it.
// Source: derived from Egan et al. 2009, Sec. 4; layers ordered by mean depth.
#include <fmt/format.h>

#include <atomic>

#include "adaptive/sheared_filter_kernel.h"
#include "image/image.h"
#include "image/image_cost.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace adaptive;

constexpr int tile = 8;    // px
constexpr int rounds = 4;  // of k-means

struct Slope {
    float vx = 0, vy = 0, coc = 0;
    float distance2(const Slope& o) const {
        const float x = vx - o.vx, y = vy - o.vy, c = 2 * (coc - o.coc);  // a lens is 2 wide
        return x * x + y * y + c * c;
    }
};
struct Layer {
    Slope middle;
    double inverse_depth = 0;
    PixelSlopes slopes;
};

struct SlopeLayers {
    int layers = 4;
    float apart = 2, gain = 2;

    static void declare(Ports<SlopeLayers>& node) {
        node.about(
                "sheared filters of layers that move, or are out of focus, apart, laid over each "
                "other by depth")
            .in<Samples>("samples", "xy, z, rgb (t, motion; uv and a lens; weight)")
            .out<Image>("image", "R G B")
            .out<Image>("layers", "Y: how many each pixel was made of; 0: its own mean")
            .param("layers", &SlopeLayers::layers, {.min = 1, .max = 16, .about = "at most"})
            .param("apart", &SlopeLayers::apart,
                   {.unit = "px",
                    .min = 0.1,
                    .max = 1000,
                    .about = "slopes nearer than that, over shutter or lens, are of one layer"})
            .param("gain", &SlopeLayers::gain,
                   {.min = 1,
                    .max = 1e6,
                    .about = "times its own samples that a pixel must get of others to "
                             "take them"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"image", image_shape(s.width, s.height, 3)},
                 {"layers", image_shape(s.width, s.height, 1)}},
                16.0 * double(s.records),
                8000.0 * double(s.records)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        samples.require("slope-layers", {"xy", "z", "rgb"});
        if (samples.domain != "camera")
            ctx.fail(
                fmt::format("needs a camera's samples, these are of domain '{}'", samples.domain));
        const ShearedFilter filter(samples, nullptr, {});
        const int across = (samples.width + tile - 1) / tile,
                  down = (samples.height + tile - 1) / tile;
        const auto crossing = crossings(samples, filter.paths(), across, down);
        Image image(samples.width, samples.height, 3), used(samples.width, samples.height, 1);
        image.color_space = samples.color_space;
        used.color_space = "Raw";
        std::atomic<size_t> done = 0;
        ctx.parallel_for(crossing.size(), [&](size_t k) {
            ctx.check_cancelled();
            const std::vector<Layer> found = layers_of(samples, filter.paths(), crossing[k]);
            const int x0 = int(k % size_t(across)) * tile, y0 = int(k / size_t(across)) * tile;
            for (int y = y0; y < std::min(y0 + tile, samples.height); ++y)
                for (int x = x0; x < std::min(x0 + tile, samples.width); ++x) {
                    const ShearedFilter::Pixel pixel = composed(samples, filter, found, x, y);
                    for (int c = 0; c < 3; ++c) image.at(x, y)[c] = float(pixel.rgb[c]);
                    *used.at(x, y) = pixel.own_mean ? 0.0f : float(found.size());
                }
            ctx.progress(double(++done), double(crossing.size()), "tiles");
        });
        if (out.wanted("image")) out.set("image", std::move(image));
        if (out.wanted("layers")) out.set("layers", std::move(used));
    }

  private:
    // The samples that may be seen in each tile, at any time and from anywhere on the lens.
    static std::vector<std::vector<std::uint32_t>> crossings(const Samples& samples,
                                                             const SamplePaths& paths, int across,
                                                             int down) {
        std::vector<std::vector<std::uint32_t>> of(size_t(across) * size_t(down));
        for (size_t i = 0; i < samples.size(); ++i)
            paths.cross(i, 1, true, true, tile, across, down,
                        [&](size_t at) { of[at].push_back(std::uint32_t(i)); });
        return of;
    }

    static Slope slope_of(const SamplePaths& paths, size_t i) {
        const auto v = paths.velocity(i);
        return {v[0], v[1], paths.coc(i)};
    }
    static size_t nearest(const std::vector<Layer>& layers, const Slope& slope) {
        size_t best = 0;
        for (size_t k = 1; k < layers.size(); ++k)
            if (slope.distance2(layers[k].middle) < slope.distance2(layers[best].middle)) best = k;
        return best;
    }

    // By k-means; begun with slopes as far apart as there are.
    std::vector<Layer> layers_of(const Samples& samples, const SamplePaths& paths,
                                 const std::vector<std::uint32_t>& crossing) const {
        std::vector<Layer> found;
        std::vector<Slope> slopes;
        for (const std::uint32_t i : crossing) slopes.push_back(slope_of(paths, i));
        if (slopes.empty()) return found;
        found.emplace_back().middle = slopes.front();
        while (int(found.size()) < layers) {
            float farthest = apart * apart;
            const Slope* next = nullptr;
            for (const Slope& s : slopes) {
                const float off = s.distance2(found[nearest(found, s)].middle);
                if (off > farthest) farthest = off, next = &s;
            }
            if (!next) break;
            found.emplace_back().middle = *next;
        }
        for (int round = 0; round < rounds && found.size() > 1; ++round) {
            std::vector<std::array<double, 4>> sums(found.size());
            for (const Slope& s : slopes) {
                auto& sum = sums[nearest(found, s)];
                sum[0] += double(s.vx), sum[1] += double(s.vy), sum[2] += double(s.coc), ++sum[3];
            }
            for (size_t k = 0; k < found.size(); ++k)
                if (sums[k][3] > 0)
                    found[k].middle = {float(sums[k][0] / sums[k][3]),
                                       float(sums[k][1] / sums[k][3]),
                                       float(sums[k][2] / sums[k][3])};
        }
        bound(samples, paths, crossing, slopes, found);
        std::stable_sort(found.begin(), found.end(), [](const Layer& a, const Layer& b) {
            return a.inverse_depth > b.inverse_depth;
        });
        return found;
    }

    // What the layers' own samples bound.
    static void bound(const Samples& samples, const SamplePaths& paths,
                      const std::vector<std::uint32_t>& crossing, const std::vector<Slope>& slopes,
                      std::vector<Layer>& found) {
        for (Layer& layer : found) {
            PixelSlopes& s = layer.slopes;
            const double speed = std::hypot(double(layer.middle.vx), double(layer.middle.vy));
            if (speed > 0)
                s.nx = double(layer.middle.vx) / speed, s.ny = double(layer.middle.vy) / speed;
            s.motion = paths.moving(), s.lens = paths.has_lens();
            s.lo = s.across_lo = s.lens_lo = INFINITY;
            s.hi = s.across_hi = s.lens_hi = -INFINITY;
        }
        std::vector<size_t> count(found.size());
        for (size_t k = 0; k < slopes.size(); ++k) {
            const size_t of = nearest(found, slopes[k]);
            Layer& layer = found[of];
            PixelSlopes& s = layer.slopes;
            const double vx = double(slopes[k].vx), vy = double(slopes[k].vy),
                         coc = double(slopes[k].coc), z = double(samples.z()[crossing[k]]);
            const double along = -(s.nx * vx + s.ny * vy), aside = -(s.nx * vy - s.ny * vx);
            s.lo = std::min(s.lo, along), s.hi = std::max(s.hi, along);
            s.across_lo = std::min(s.across_lo, aside), s.across_hi = std::max(s.across_hi, aside);
            s.lens_lo = std::min(s.lens_lo, -coc), s.lens_hi = std::max(s.lens_hi, -coc);
            layer.inverse_depth += 1 / z, ++count[of];
        }
        for (size_t k = 0; k < found.size(); ++k) {
            found[k].slopes.known = count[k] > 0;
            if (count[k] > 0) found[k].inverse_depth /= double(count[k]);
        }
        size_t kept = 0;
        for (size_t k = 0; k < found.size(); ++k)
            if (count[k] > 0) std::swap(found[kept++], found[k]);
        found.resize(kept);
    }

    ShearedFilter::Pixel composed(const Samples& samples, const ShearedFilter& filter,
                                  const std::vector<Layer>& found, int x, int y) const {
        const ShearedFilter::Pixel own = filter.own_mean(x, y);
        ShearedFilter::Pixel out;
        double through = 1, noise = 0;
        for (size_t k = 0; k < found.size() && through > 1e-6; ++k) {
            ShearedFilter::Sums color, cover;
            const ShearedFilter::Filter way = filter.filter_of(found[k].slopes, x, y);
            filter.gather(way, [&](size_t i, double w) {
                const size_t of =
                    found.size() == 1 ? 0 : nearest(found, slope_of(filter.paths(), i));
                if (of < k) return;  // stands before this layer
                const auto from = filter.from_middle(way, i);
                const float is = of == k ? 1.0f : 0.0f, covers[3] = {is, is, is};
                cover.add(w, covers, from[0], from[1]);
                if (of == k) color.add(w, &samples.rgb()[3 * i], from[0], from[1]);
            });
            // A layer's samples lie to one side of where it is hidden: no slope is carried there.
            const ShearedFilter::Pixel seen = found.size() > 1 ? color.mean() : color.fitted();
            if (!(seen.effective > 0)) continue;
            const double share = through * cover.mean().rgb[0];
            for (size_t c = 0; c < 3; ++c) out.rgb[c] += share * seen.rgb[c];
            noise += share * share / double(seen.effective);
            through -= share;
        }
        // What no layer covers is as those that do.
        const double covered = 1 - through;
        if (!(covered > 0.5)) return own;
        for (double& c : out.rgb) c /= covered;
        out.effective = float(covered * covered / noise);
        return out.effective < gain * own.effective ? own : out;
    }
};

WEFT_NODE(SlopeLayers, "slope-layers", 3)

}  // namespace
}  // namespace weft
