// anisotropic-reconstruct: at each location the radiance of the sample that is nearest by its own
// metric. Source: Hachisuka et al. 2008, Sec. 5.  Departure: a stage of a stream of locations, so
// that any pixel filter follows; 2008 cut leaves into cells below a pixel's size instead.
//   A batch goes by blocks of 4 x 4 px at one (u, v, t): the samples around are brought there once
//   for all its locations. How far around is found out as it goes, and changes no bit.
// Cost: some 0.7 us a location in three dimensions.
#include <algorithm>
#include <numeric>

#include "adaptive/anisotropic_radiance.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace adaptive;

struct AnisotropicReconstruct {
    int candidates = 12;
    Blend blend = Blend::linear;

    static void declare(Ports<AnisotropicReconstruct>& node) {
        node.about(
                "radiance of each location: that of the sample which is nearest by its own "
                "distance, over film, lens, time and light")
            .in<Locations>("locations", "points to reconstruct")
            .in<Samples>("samples", "rgb, of the samples that the tensors are of")
            .in<Metrics>("tensors", "a distance around each")
            .out<Colors>("colors", "radiance of each location, alpha 1")
            .param("candidates", &AnisotropicReconstruct::candidates,
                   {.unit = "samples",
                    .min = 1,
                    .max = 256,
                    .about = "of blend nearest: the nearest ones, by plain distance, that are "
                             "looked at; the others look at those within whose 64 nearest "
                             "a location lies"})
            .choice("blend", &AnisotropicReconstruct::blend, {"nearest", "tent", "linear"},
                    {.about = "the nearest alone; the three nearest by how much nearer they are "
                              "than the next (tent); the same, each going on by its gradient as "
                              "far as its neighbours go (linear)"});
    }

    struct Scratch {
        AnisotropicRadiance::Scratch of;
        std::vector<std::uint32_t> order;
        std::vector<float> x, y;
    };

    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Metrics& metrics = in.get<Metrics>("tensors");
        const Samples& samples = in.get<Samples>("samples");
        const Locations& at = in.get<Locations>("locations");
        if (metrics.size() != samples.size())
            throw Error("'tensors' are of another buffer than 'samples'; link both to the same");
        Colors& colors = out.get<Colors>("colors");
        colors.color_space = &samples.color_space;
        colors.rgba.assign(4 * at.size(), 1);
        colors.valid.assign(at.size(), 1);
        const AnisotropicRadiance radiance(metrics, samples.rgb().data(), candidates, blend);
        std::array<float, most_axes> other{};
        const auto take_other = [&](size_t l) {
            for (size_t d = 2; d < metrics.dimensions(); ++d)
                other[d] = place_of(metrics.space, d, at, l);
        };
        if (!at.shared) {
            for (size_t l = 0; l < at.size(); ++l) {
                take_other(l);
                radiance.at(std::span(&at.x[l], 1), std::span(&at.y[l], 1), other.data(),
                            scratch.of, [&](size_t) { return &colors.rgba[4 * l]; });
            }
            return;
        }
        // Locations come row by row: those of one block, then of the next.
        constexpr int side = 4;
        const auto block_of = [&](size_t l) {
            const auto column = std::uint32_t((int(at.x[l]) - at.x0) / side),
                       row = std::uint32_t((int(at.y[l]) - at.y0) / side);
            return row << 16 | column;
        };
        std::vector<std::uint32_t>& order = scratch.order;
        order.resize(at.size());
        std::iota(order.begin(), order.end(), 0u);
        std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
            const std::uint32_t ba = block_of(a), bb = block_of(b);
            return ba != bb ? ba < bb : a < b;
        });
        scratch.x.clear(), scratch.y.clear();
        for (const std::uint32_t l : order)
            scratch.x.push_back(at.x[l]), scratch.y.push_back(at.y[l]);
        if (!order.empty()) take_other(0);
        for (size_t begin = 0, end; begin < order.size(); begin = end) {
            const std::uint32_t block = block_of(order[begin]);
            for (end = begin + 1; end < order.size() && block_of(order[end]) == block;) ++end;
            radiance.at(std::span(scratch.x).subspan(begin, end - begin),
                        std::span(scratch.y).subspan(begin, end - begin), other.data(), scratch.of,
                        [&](size_t i) { return &colors.rgba[4 * size_t(order[begin + i])]; });
        }
    }
};

WEFT_NODE(AnisotropicReconstruct, "anisotropic-reconstruct", 2)

}  // namespace
}  // namespace weft
