// sampling-density: how many samples a pixel needs, by the slopes of what it sees: as many as its
// filter's copies of the spectrum need to stay apart.
//   sheared       n = (2 W) (2 W_across) (2 max(B, 0.5 / T)) T, T = 1 the shutter's length; a lens,
//                 of width 2, has two such axes beside the film's two
//   axis-aligned  n = (W_p + W) (2 W_p) (1 + |s|_max W): the filter keeps to the axes, so it must
//                 hold the whole wedge
// Source: Egan et al. 2009, Sec. 4 (sheared); Mehta et al. 2012, Sec. 5 (axis-aligned).
#include <fmt/format.h>

#include "adaptive/slopes.h"
#include "image/image_cost.h"
#include "runtime/node.h"
#include "samples/random.h"

namespace weft {
namespace {
using namespace adaptive;

struct SamplingDensity {
    enum class Mode { sheared, axis_aligned };
    Mode mode = Mode::sheared;
    float oversample = 4, least = 0.25f, most = 64, have = 0;
    std::uint64_t seed = 1;

    static void declare(Ports<SamplingDensity>& node) {
        node.about("samples that each pixel needs, by the slopes of what it sees")
            .in<Image>("slopes", "of slope-bounds")
            .out<Image>("counts", "samples a pixel, whole numbers")
            .out<Image>("more",
                        "of these, how many are yet to be made; for 'counts' of "
                        "render-samples")
            .out<Image>("band",
                        "w: cycles a px; b, lens-b: cycles a shutter and a unit of lens that "
                        "shearing leaves; samples: before oversampling")
            .choice("mode", &SamplingDensity::mode, {"sheared", "axis-aligned"},
                    {.about = "the filter that the samples are for"})
            .param("oversample", &SamplingDensity::oversample,
                   {.min = 0.01, .max = 1e4, .about = "times what the spectra need"})
            .param("least", &SamplingDensity::least,
                   {.unit = "samples", .min = 0, .max = 1 << 20, .about = "in any pixel"})
            .param("most", &SamplingDensity::most,
                   {.unit = "samples", .min = 0.01, .max = 1 << 20, .about = "in any pixel"})
            .param("have", &SamplingDensity::have,
                   {.unit = "samples",
                    .min = 0,
                    .max = 1 << 20,
                    .about = "what a first pass has made in each pixel"})
            .param("seed", &SamplingDensity::seed,
                   {.about = "of the chance by which fractions become whole"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["slopes"];
        return {{{"counts", image_shape(s.width, s.height, 1)},
                 {"more", image_shape(s.width, s.height, 1)},
                 {"band", image_shape(s.width, s.height, 4)}},
                0,
                50.0 * double(s.width) * double(s.height)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Image& slopes = in.get<Image>("slopes");
        const SlopeReader read(slopes, "sampling-density");
        if (least > most)
            ctx.fail(
                fmt::format("least is {}, most is {}; expected least up to most", least, most));
        Image counts(slopes.width(), slopes.height(), 1);
        Image band(slopes.width(), slopes.height(), {"w", "b", "lens-b", "samples"});
        counts.color_space = band.color_space = "Raw";
        Image more = counts;
        ctx.parallel_rows(slopes.height(), [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < slopes.width(); ++x) {
                    const PixelSlopes s = read(x, y);
                    const double n = samples(s);
                    const double wanted =
                        std::clamp(n * double(oversample), double(least), double(most));
                    const float chance =
                        unit_float(mix(mix(seed ^ std::uint64_t(x)) ^ std::uint64_t(y)));
                    const double whole = std::floor(wanted + double(chance));
                    *counts.at(x, y) = float(whole);
                    *more.at(x, y) = float(std::max(whole - double(have), 0.0));
                    float* b = band.at(x, y);
                    b[0] = float(s.band()), b[1] = float(s.residual());
                    b[2] = float(s.lens_residual()), b[3] = float(n);
                }
        });
        const auto give = [&](const char* port, Image& image) {
            if (out.wanted(port)) out.set(port, std::move(image));
        };
        give("counts", counts);
        give("more", more);
        give("band", band);
    }

  private:
    double samples(const PixelSlopes& s) const {
        constexpr double lens_width = 2;
        if (!s.known) return 1;
        double n = 1;
        if (mode == Mode::sheared) {
            n = 2 * s.band() * 2 * s.band_across();
            if (s.motion) n *= 2 * std::max(s.residual(), 0.5);
            if (s.lens) {
                const double axis = 2 * std::max(s.lens_residual(), 0.5 / lens_width) * lens_width;
                n *= axis * axis;
            }
            return n;
        }
        n = (pixel_band + s.band()) * (pixel_band + s.band_across());
        if (s.motion) n *= 1 + std::max(std::abs(s.lo), std::abs(s.hi)) * s.band();
        if (s.lens) {
            const double widest = std::max(std::abs(s.lens_lo), std::abs(s.lens_hi));
            const double axis = (1 / lens_width + widest * s.band_across()) * lens_width;
            n *= axis * axis;
        }
        return n;
    }
};

WEFT_NODE(SamplingDensity, "sampling-density", 1)

}  // namespace
}  // namespace weft
