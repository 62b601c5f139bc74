// show-footprints: which samples sheared-filter takes, for pixels on a grid: what each pixel
// around gives, over a dimmed picture. Pixels that keep their own mean are red.
#include <algorithm>

#include "adaptive/sheared_node.h"

namespace weft {
namespace {
using namespace adaptive;

struct ShowFootprints {
    int step = 24;

    static void declare(Ports<ShowFootprints>& node) {
        node.about("from where sheared-filter takes samples, for pixels on a grid")
            .in<Samples>("samples", "as sheared-filter has them")
            .in<Image>("slopes", "of slope-bounds")
            .in<Image>("image", "what is shown behind", Need::optional)
            .out<Image>("image",
                        "R G B: green by the weight that samples have in the filter of the grid's "
                        "pixel; red: it keeps its own mean")
            .param("step", &ShowFootprints::step,
                   {.unit = "px", .min = 1, .max = 4096, .about = "from one to the next"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        return {{{"image", image_shape(s.width, s.height, 3)}}, 0, 100.0 * double(s.records)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        const Image &slopes = in.get<Image>("slopes"), *behind = in.find<Image>("image");
        ShearedNode::check(samples, slopes, "show-footprints", ctx);
        if (behind && (behind->width() != samples.width || behind->height() != samples.height ||
                       behind->channels() < 3))
            ctx.fail(
                fmt::format("'image' is {} x {} of {} channels, the samples {} x {}; expected "
                            "one size, and R G B",
                            behind->width(), behind->height(), behind->channels(), samples.width,
                            samples.height));
        const ShearedFilter filter(samples, &slopes, {});
        const SlopeReader read(slopes, "show-footprints");
        Image image(samples.width, samples.height, 3);
        image.color_space = "lin_rec709";
        if (behind)
            for (int y = 0; y < samples.height; ++y)
                for (int x = 0; x < samples.width; ++x)
                    for (int c = 0; c < 3; ++c) image.at(x, y)[c] = 0.2f * behind->at(x, y)[c];

        std::vector<double> weights(samples.pixels());
        const auto of_pixel = pixel_of_samples(samples);
        for (int y = step / 2; y < samples.height; y += step)
            for (int x = step / 2; x < samples.width; x += step) {
                ctx.check_cancelled();
                if (filter.filtered(x, y).own_mean) {
                    mark(image, x, y, {1, 0, 0});
                    continue;
                }
                std::fill(weights.begin(), weights.end(), 0.0);
                filter.gather(filter.filter_of(read(x, y), x, y),
                              [&](size_t i, double w) { weights[of_pixel[i]] += w; });
                const double most = *std::max_element(weights.begin(), weights.end());
                for (size_t p = 0; most > 0 && p < weights.size(); ++p)
                    image.pixels()[3 * p + 1] += float(0.8 * weights[p] / most);
                mark(image, x, y, {1, 1, 1});
            }
        out.set("image", std::move(image));
    }

  private:
    // The pixel and its four neighbours.
    static void mark(Image& image, int x, int y, const std::array<float, 3>& color) {
        for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}})
            if (x + dx >= 0 && x + dx < image.width() && y + dy >= 0 && y + dy < image.height())
                std::copy(color.begin(), color.end(), image.at(x + dx, y + dy));
    }
    static std::vector<std::uint32_t> pixel_of_samples(const Samples& samples) {
        std::vector<std::uint32_t> of(samples.size());
        for (size_t p = 0; p < samples.pixels(); ++p) {
            const auto range = samples.of_pixel(p);
            std::fill(of.begin() + long(range.begin), of.begin() + long(range.end),
                      std::uint32_t(p));
        }
        return of;
    }
};

WEFT_NODE(ShowFootprints, "show-footprints", 2)

}  // namespace
}  // namespace weft
