// several-axis-aligned: motion blur and defocus by several axis-aligned filters, each for a part of
// the frequencies that the shutter, or the lens, leaves. What moves by v has, at frequency f over
// the film, frequency -v f over time; with that taken off, pixels' means say all of a narrow band
// of f, and may be averaged along the way of motion as far as the band allows. Defocus is the same
// over two axes (lens_bands.h).
//   bands   2 K + 1, their middles f_i = i W / K, W = 1 / |s|_min cycles a px, along the mean slope
//           s; Gaussians of deviation 0.6 W / K, which add up to 1 within 0.2 %
//   pixel   sum over pixels at distance d along the way, and over bands, of
//           w(s f_i) exp(-d^2 / (2 sigma^2)) mean(f exp(2 pi j f_i (d - s (t - T)))),
//           w the shutter's transform, T its mean time, sigma = 1 / (2 pi 0.6 W / K) px
// Source: after Wu et al. 2017; derived here.  Departures: each pixel has its own slope, width and
// way, and sums over its own line of pixels; bands so wide that there is no ripple. Pixels whose
// slopes differ by more than a band holds, and those that shutters blur by less than a pixel, keep
// their mean. What moves and is out of focus is filtered along that which blurs it more, and
// averaged over the other: either alone leaves the picture what it is.
// Cost: motion, the samples of 6 sigma pixels, a sine and a cosine each; defocus, those of a disc
// of radius 3 sigma = 1.3 K coc px, a look into a table each.
#include <numbers>
#include <optional>

#include "adaptive/lens_bands.h"
#include "adaptive/sheared_node.h"
#include "image/each_line.h"

namespace weft {
namespace {
using namespace adaptive;

constexpr double reach = 3;  // deviations
// Cycles that slopes may differ by, at the limit W: over a shutter; over half a lens, most of which
// is nearer its middle.
constexpr double most_apart = 0.25, most_apart_on_lens = 0.5;

struct SeveralAxisAligned {
    int bands = 3;
    float wide = ShearedSettings{}.wide;

    static void declare(Ports<SeveralAxisAligned>& node) {
        node.about(
                "motion blur and defocus by axis-aligned filters, one for each part of the "
                "frequencies that shutter or lens leave")
            .in<Samples>("samples", "xy, z, rgb, and t and motion, or uv and a lens (weight)")
            .in<Image>("slopes", "of slope-bounds, of motion, lens or both")
            .out<Image>("image", "R G B")
            .param("bands", &SeveralAxisAligned::bands,
                   {.min = 1,
                    .max = 16,
                    .about = "on either side of the middle one: more are narrower, and wider over "
                             "the film"})
            .param("wide", &SeveralAxisAligned::wide,
                   {.unit = "px",
                    .min = 0,
                    .max = 1e6,
                    .about = "slopes that differ by more, about 0, leave nothing to gain"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"image", image_shape(s.width, s.height, 3)}}, 0, 1500.0 * double(s.records)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const Image& slopes = in.get<Image>("slopes");
        ShearedNode::check(samples, slopes, "several-axis-aligned", ctx);
        const SlopeReader read(slopes, "several-axis-aligned");
        const bool moves = read.motion() && samples.has_motion(),
                   blurs = read.lens() && samples.has_lens();
        if (!moves && !blurs)
            ctx.warn(
                "the samples have neither motion nor a lens that the slopes tell of; the picture "
                "is the box filter's");
        ShearedSettings with;
        with.wide = wide;
        const ShearedFilter filter(samples, &slopes, with);
        const ShutterCurve shutter = shutter_of(samples.meta);
        std::optional<LensBands> lens_bands;
        if (blurs) lens_bands.emplace(bands, *samples.lens);
        Image image(samples.width, samples.height, 3);
        image.color_space = samples.color_space;
        each_line(ctx, samples.height, "rows", [&](int y) {
            for (int x = 0; x < samples.width; ++x) {
                const PixelSlopes s = read(x, y);
                const ShearedFilter::Pixel own = filter.own_mean(x, y);
                std::array<double, 3> found{own.rgb[0], own.rgb[1], own.rgb[2]};
                if (own.effective > 0) {
                    const double motion = moves && motion_fits(s, own, filter) ? s.least() : 0,
                                 lens = blurs && lens_fits(s, own, filter) ? s.lens_least() : 0;
                    if (lens / lens_band > motion / shutter_band)
                        found = defocused(samples, *lens_bands, s.coc(), own, x, y);
                    else if (motion > 0)
                        found = moved(samples, Bands(s, bands, shutter), s, own, x, y);
                }
                for (size_t c = 0; c < 3; ++c) image.at(x, y)[c] = float(found[c]);
            }
        });
        out.set("image", std::move(image));
    }

  private:
    // Whether what crosses a pixel moves so much, and so much alike, that others are worth asking.
    static bool motion_fits(const PixelSlopes& s, const ShearedFilter::Pixel& own,
                            const ShearedFilter& filter) {
        return !filter.keeps_own(s, own) && s.least() > shutter_band / pixel_band &&
               s.residual() <= most_apart;
    }
    // As much out of focus, however it moves.
    static bool lens_fits(PixelSlopes s, const ShearedFilter::Pixel& own,
                          const ShearedFilter& filter) {
        s.lo = s.hi = 0;
        return !filter.keeps_own(s, own) && s.lens_least() > lens_band / pixel_band &&
               s.lens_residual() <= most_apart_on_lens;
    }

    // How a sample counts, by phase: all bands together.
    struct Bands {
        Bands(const PixelSlopes& s, int count, const ShutterCurve& shutter)
            : slope((s.lo + s.hi) / 2), apart(s.band() / count), real(size_t(count)), imag(real) {
            constexpr int steps = 64;
            for (int k = 0; k < steps; ++k)
                mean_time +=
                    (k + 0.5) / steps * double(shutter.openness((k + 0.5f) / steps)) / steps;
            for (size_t i = 0; i < real.size(); ++i)
                for (int k = 0; k < steps; ++k) {
                    const double t = (k + 0.5) / steps, angle = turn(i) * slope * (t - mean_time),
                                 open = double(shutter.openness(float(t))) / steps;
                    real[i] += open * std::cos(angle), imag[i] += open * std::sin(angle);
                }
        }
        double turn(size_t i) const { return 2 * std::numbers::pi * double(i + 1) * apart; }
        double sigma() const { return 1 / (2 * std::numbers::pi * band_deviation * apart); }
        double operator()(double d, double t) const {
            const double angle = turn(0) * (d - slope * (t - mean_time));
            const double c1 = std::cos(angle), s1 = std::sin(angle);
            double c = 1, s = 0, sum = 1;
            for (size_t i = 0; i < real.size(); ++i) {
                const double next = c * c1 - s * s1;
                s = s * c1 + c * s1, c = next;
                sum += 2 * (real[i] * c - imag[i] * s);
            }
            return sum;
        }
        double slope, apart, mean_time = 0;
        std::vector<double> real, imag;  // of the shutter's transform
    };

    // Weighted samples around a pixel, as they differ from its own mean.
    struct Sums {
        const Samples& samples;
        const ShearedFilter::Pixel& own;
        std::span<const float> rgb = samples.rgb(), stands = samples.values("weight");
        double total = 0, gauss = 0;
        std::array<double, 3> change{};

        // Those of pixel (i, j), each by `share` and by what it counts in all bands.
        template <class Counts>
        void add(int i, int j, double share, const Counts& counts_of) {
            if (!(share > 0) || i < 0 || i >= samples.width || j < 0 || j >= samples.height) return;
            const auto range = samples.of_pixel(size_t(j) * size_t(samples.width) + size_t(i));
            for (size_t at = range.begin; at < range.end; ++at) {
                const float* color = &rgb[3 * at];
                if (!std::isfinite(color[0] + color[1] + color[2])) continue;
                const double w = share * (stands.empty() ? 1 / double(range.end - range.begin)
                                                         : double(stands[at]));
                const double counts = w * counts_of(at);
                total += counts, gauss += w;
                for (size_t c = 0; c < 3; ++c)
                    change[c] += counts * (double(color[c]) - own.rgb[c]);
            }
        }
        // On average as much as the middle band alone; samples that lie too ill say nothing.
        std::array<double, 3> mean() const {
            const bool sound = total > 0.5 * gauss;
            std::array<double, 3> out{};
            for (size_t c = 0; c < 3; ++c) out[c] = own.rgb[c] + (sound ? change[c] / total : 0.0);
            return out;
        }
    };

    static std::array<double, 3> moved(const Samples& samples, const Bands& bands,
                                       const PixelSlopes& s, const ShearedFilter::Pixel& own, int x,
                                       int y) {
        const auto t = samples.t();
        const bool steep = std::abs(s.ny) > std::abs(s.nx);
        const double longer = steep ? s.ny : s.nx, aside = (steep ? s.nx : s.ny) / longer;
        const int far = int(std::ceil(reach * bands.sigma() * std::abs(longer)));
        Sums sums{samples, own};
        for (int k = -far; k <= far; ++k) {
            // A step along the longer part of the way is 1 / longer px, between two pixels across.
            const double d = -double(k) / longer, across = k * aside, below = std::floor(across);
            const double along = std::exp(-d * d / (2 * bands.sigma() * bands.sigma()));
            for (const int next : {0, 1}) {
                const double share = along * (next ? across - below : 1 - (across - below));
                const int off = int(below) + next;
                sums.add(x + (steep ? off : k), y + (steep ? k : off), share,
                         [&](size_t i) { return bands(d, double(t[i])); });
            }
        }
        return sums.mean();
    }

    static std::array<double, 3> defocused(const Samples& samples, const LensBands& bands,
                                           double coc, const ShearedFilter::Pixel& own, int x,
                                           int y) {
        const auto uv = samples.uv();
        const double width = coc * double(samples.lens->aspect), sigma = double(bands.sigma()),
                     far = reach * sigma;
        const int far_x = int(std::min(std::ceil(far * std::abs(width)), double(samples.width))),
                  far_y = int(std::min(std::ceil(far * std::abs(coc)), double(samples.height)));
        Sums sums{samples, own};
        for (int dy = -far_y; dy <= far_y; ++dy)
            for (int dx = -far_x; dx <= far_x; ++dx) {
                // The way from there to the pixel, in parts of the circle of confusion.
                const double a = -dx / width, b = -dy / coc, square = a * a + b * b;
                if (square > far * far) continue;
                sums.add(x + dx, y + dy, std::exp(-square / (2 * sigma * sigma)), [&](size_t i) {
                    return double(bands(float(a) + uv[2 * i], float(b) + uv[2 * i + 1]));
                });
            }
        return sums.mean();
    }
};

WEFT_NODE(SeveralAxisAligned, "several-axis-aligned", 2)

}  // namespace
}  // namespace weft
