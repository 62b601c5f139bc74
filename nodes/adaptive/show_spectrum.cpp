// show-spectrum: a window of the light field over one axis of the film and time, or the lens, and
// its spectrum beside the wedge that sheared filters assume of it. Energy outside the wedge is what
// the bounds do not know of: curved paths, shading that moves otherwise.
//   orange  Omega_y = s Omega_x for the least slope and the greatest of the window's pixels
//   blue    what the middle pixel's sheared filter passes: up to W over the film, and within
//           0.5 / T or B of the mean slope, whichever is more
#include <algorithm>

#include "adaptive/light_field_spectrum.h"
#include "adaptive/sheared_node.h"

namespace weft {
namespace {
using namespace adaptive;

struct ShowSpectrum {
    enum class Axis { x, y };
    enum class Over { time, lens };
    Axis axis = Axis::x;
    Over over = Over::time;
    float at_x = 0.5f, at_y = 0.5f;
    int width = 64, rows = 4, size = 192;

    static void declare(Ports<ShowSpectrum>& node) {
        node.about(
                "a window of the light field over film and time, or film and lens, and its "
                "spectrum beside the wedge that sheared filters assume")
            .in<Samples>("samples", "xy, z, rgb; t, or uv: many a pixel, 64 or more")
            .in<Image>("slopes", "of slope-bounds")
            .out<Image>("window", "R G B: film to the right, time or lens downwards")
            .out<Image>("spectrum",
                        "R G B: amplitudes, 40 decibels from black to white; film's frequencies to "
                        "the right up "
                        "to 0.5 cycles a px, the other's upwards")
            .choice("axis", &ShowSpectrum::axis, {"x", "y"}, {.about = "of the film"})
            .choice("over", &ShowSpectrum::over, {"time", "lens"},
                    {.about = "the other axis; of the lens, the one along the film's"})
            .param("at-x", &ShowSpectrum::at_x,
                   {.min = 0, .max = 1, .about = "middle of the window, in parts of the picture"})
            .param("at-y", &ShowSpectrum::at_y,
                   {.min = 0, .max = 1, .about = "likewise, downwards"})
            .param("width", &ShowSpectrum::width,
                   {.unit = "px", .min = 4, .max = 512, .about = "of the window"})
            .param("rows", &ShowSpectrum::rows,
                   {.unit = "px", .min = 1, .max = 64, .about = "that are taken as one"})
            .param("size", &ShowSpectrum::size,
                   {.unit = "px", .min = 16, .max = 1024, .about = "of both pictures"});
    }
    Cost cost(const Shapes&) const {
        return {{{"window", image_shape(size, size, 3)}, {"spectrum", image_shape(size, size, 3)}},
                16.0 * size * size,
                100.0 * size * size};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const Image& slopes = in.get<Image>("slopes");
        ShearedNode::check(samples, slopes, "show-spectrum", ctx);
        const bool time = over == Over::time;
        samples.require("show-spectrum", {time ? "t" : "uv"});
        const SlopeReader read(slopes, "show-spectrum");
        if (time ? !read.motion() : !read.lens())
            ctx.fail(time ? "the slopes hold no motion; set effect of slope-bounds to both"
                          : "the slopes hold no lens; set effect of slope-bounds to both");

        const Place place = place_of(samples);
        const std::vector<WindowPoint> points = points_of(samples, place);
        if (points.empty()) ctx.fail("no sample lies in the window; move it, or widen 'rows'");
        constexpr int cells_a_px = 2, cells_y = 48;
        const double extent = time ? 1 : 2;
        const LightFieldWindow window =
            light_field_window(points, cells_a_px * place.length, place.length, cells_y, extent);
        if (out.wanted("window")) out.set("window", picture_of(window));
        if (out.wanted("spectrum")) out.set("spectrum", spectrum_of(window, read, place, time));
    }

  private:
    // The window's first pixel along the film's axis and across it.
    struct Place {
        int first, length, across, rows;
        bool down;
        std::array<int, 2> pixel(int along, int aside) const {
            return down ? std::array{across + aside, first + along}
                        : std::array{first + along, across + aside};
        }
    };
    Place place_of(const Samples& samples) const {
        const bool down = axis == Axis::y;
        const int along = down ? samples.height : samples.width,
                  aside = down ? samples.width : samples.height;
        const auto start = [](float at, int length, int of) {
            return std::clamp(int(at * float(of)) - length / 2, 0, of - length);
        };
        const int length = std::min(width, along), deep = std::min(rows, aside);
        return {start(down ? at_y : at_x, length, along), length,
                start(down ? at_x : at_y, deep, aside), deep, down};
    }

    std::vector<WindowPoint> points_of(const Samples& samples, const Place& place) const {
        const auto xy = samples.xy(), rgb = samples.rgb(), t = samples.t(), uv = samples.uv();
        const size_t axis_of = place.down ? 1 : 0;
        constexpr float near_middle = 0.25f;  // of the lens's other axis
        std::vector<WindowPoint> points;
        for (int b = 0; b < place.rows; ++b)
            for (int a = 0; a < place.length; ++a) {
                const auto [x, y] = place.pixel(a, b);
                const auto range = samples.of_pixel(size_t(y) * size_t(samples.width) + size_t(x));
                for (size_t i = range.begin; i < range.end; ++i) {
                    const float sum = rgb[3 * i] + rgb[3 * i + 1] + rgb[3 * i + 2];
                    if (!std::isfinite(sum)) continue;
                    const bool time = over == Over::time;
                    if (!uv.empty() && std::abs(uv[2 * i + 1 - axis_of]) > near_middle) continue;
                    // A window over time looks through the lens's middle alone.
                    if (time && !uv.empty() && std::abs(uv[2 * i + axis_of]) > near_middle)
                        continue;
                    const float on = time ? t[i] : (uv[2 * i + axis_of] + 1) / 2;
                    points.push_back(
                        {double(xy[2 * i + axis_of]) - place.first, double(on), double(sum) / 3});
                }
            }
        return points;
    }

    Image picture_of(const LightFieldWindow& window) const {
        Image image(size, size, 3);
        image.color_space = "lin_rec709";
        const auto [least, most] = std::minmax_element(window.value.begin(), window.value.end());
        const double range = *most > *least ? *most - *least : 1;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x)
                for (int c = 0; c < 3; ++c)
                    image.at(x, y)[c] = float(
                        (window.at(x * window.width / size, y * window.height / size) - *least) /
                        range);
        return image;
    }

    struct Slopes {
        double lo = INFINITY, hi = -INFINITY, band = 0, residual = 0;
    };
    // Along the window's axis of the film; the band and what shearing leaves are the middle
    // pixel's.
    static Slopes slopes_of(const SlopeReader& read, const Place& place, bool time) {
        Slopes out;
        for (int a = 0; a < place.length; ++a) {
            const auto [x, y] = place.pixel(a, place.rows / 2);
            const PixelSlopes s = read(x, y);
            if (!s.known) continue;
            if (time) {
                const double n = place.down ? s.ny : s.nx, m = place.down ? s.nx : -s.ny;
                for (const double along : {s.lo, s.hi})
                    for (const double aside : {s.across_lo, s.across_hi})
                        out.lo = std::min(out.lo, n * along + m * aside),
                        out.hi = std::max(out.hi, n * along + m * aside);
            } else {
                out.lo = std::min(out.lo, s.lens_lo), out.hi = std::max(out.hi, s.lens_hi);
            }
            if (a == place.length / 2) {
                out.band = time ? s.band() : s.band_across();
                out.residual = time ? s.residual() : s.lens_residual();
            }
        }
        if (!(out.lo <= out.hi)) out.lo = out.hi = 0;
        return out;
    }

    Image spectrum_of(const LightFieldWindow& window, const SlopeReader& read, const Place& place,
                      bool time) const {
        const Slopes s = slopes_of(read, place, time);
        // As high as the wedge goes, or some cycles.
        const double limit_x = pixel_band,
                     limit_y = std::clamp(1.25 * limit_x * std::max(std::abs(s.lo), std::abs(s.hi)),
                                          4.0, 0.5 / window.cell_y);
        const std::vector<double> found = amplitudes(window, size, limit_x, limit_y);
        constexpr double floor = 40;  // decibels: below is the samples' noise
        const double most = *std::max_element(found.begin(), found.end());
        Image image(size, size, 3);
        image.color_space = "lin_rec709";
        for (size_t i = 0; i < found.size(); ++i) {
            const double decibels =
                most > 0 && found[i] > 0 ? 20 * std::log10(found[i] / most) : -floor;
            const auto grey = float(std::max(decibels / floor + 1, 0.0));
            for (size_t c = 0; c < 3; ++c) image.pixels()[3 * i + c] = grey * grey;
        }
        const auto line = [&](double slope, double offset, double reach,
                              const std::array<float, 3>& color) {
            // A dot in each column, or in each row where it is steep.
            for (int k = 0; k < 4 * size; ++k) {
                const double x = limit_x * reach * (2 * (k + 0.5) / (4 * size) - 1),
                             y = slope * x + offset;
                const int i = int(std::lround((x / limit_x + 1) / 2 * (size - 1))),
                          j = int(std::lround((1 - y / limit_y) / 2 * (size - 1)));
                if (i >= 0 && i < size && j >= 0 && j < size)
                    std::copy(color.begin(), color.end(), image.at(i, j));
            }
        };
        const double mean = (s.lo + s.hi) / 2, apart = std::max(s.residual, time ? 0.5 : 0.25);
        for (const double side : {-apart, apart})
            line(mean, side, s.band / limit_x, {0.05f, 0.3f, 1});
        for (const double slope : {s.lo, s.hi}) line(slope, 0, 1, {1, 0.35f, 0.02f});
        return image;
    }
};

WEFT_NODE(ShowSpectrum, "show-spectrum", 1)

}  // namespace
}  // namespace weft
