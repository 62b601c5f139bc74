// anisotropic-reconstruct: at each location the radiance of the sample that is nearest by its own
// metric. Source: Hachisuka et al. 2008, Sec. 5.  Departure: a stage of a stream of locations, so
// that any pixel filter follows; 2008 cut leaves into cells below a pixel's size instead.
//   A batch goes by blocks of 8 x 8 px at one (u, v, t), whose locations look at the same samples:
//   sixteen of them, the lanes of vectors, at a time.
// Cost: bench/adaptive.cpp.
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
        Places places;
        std::vector<std::uint32_t> begin, order;  // of blocks; locations, block by block
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
        std::array<float, most_axes> other{}, lo{}, hi{};
        const auto take_other = [&](size_t l) {
            for (size_t d = 2; d < metrics.dimensions(); ++d)
                other[d] = place_of(metrics.space, d, at, l);
        };
        Places& places = scratch.places;
        const auto put = [&](size_t i, size_t l) {
            places.at[0][i] = at.x[l], places.at[1][i] = at.y[l];
            for (size_t d = 2; d < metrics.dimensions(); ++d) places.at[d][i] = other[d];
        };
        if (!at.shared) {
            for (size_t l = 0; l < at.size(); ++l) {
                take_other(l);
                places.start(metrics.dimensions(), 1);
                put(0, l);
                places.bounds(lo.data(), hi.data());
                radiance.prepare(lo.data(), hi.data(), scratch.of);
                radiance.at(places, scratch.of, [&](size_t) { return &colors.rgba[4 * l]; });
            }
            return;
        }
        if (at.size() == 0) return;
        take_other(0);
        lo = hi = other;
        lo[0] = float(at.x0), lo[1] = float(at.y0), hi[0] = float(at.x1), hi[1] = float(at.y1);
        radiance.prepare(lo.data(), hi.data(), scratch.of);
        sort_by_blocks(at, scratch);
        for (size_t b = 0; b + 1 < scratch.begin.size(); ++b) {
            const size_t begin = scratch.begin[b], n = scratch.begin[b + 1] - begin;
            places.start(metrics.dimensions(), n);
            for (size_t i = 0; i < n; ++i) put(i, scratch.order[begin + i]);
            radiance.at(places, scratch.of, [&](size_t i) {
                return &colors.rgba[4 * size_t(scratch.order[begin + i])];
            });
        }
    }

  private:
    // Blocks of 8 x 8 px, and in each four of 4 x 4: so many locations share what is looked at, and
    // so many are a vector.
    static void sort_by_blocks(const Locations& at, Scratch& scratch) {
        constexpr int part = 4;
        const auto blocks = [](int from, int to) { return size_t(to - from + 7) / 8; };
        const size_t across = blocks(at.x0, at.x1), n = across * blocks(at.y0, at.y1);
        const auto part_of = [&](size_t l) {
            const auto column = size_t(std::min(int(at.x[l]), at.x1 - 1) - at.x0) / part,
                       row = size_t(std::min(int(at.y[l]), at.y1 - 1) - at.y0) / part;
            return ((row / 2) * across + column / 2) * 4 + (row & 1) * 2 + (column & 1);
        };
        std::vector<std::uint32_t>& next = scratch.begin;
        next.assign(4 * n + 1, 0);
        for (size_t l = 0; l < at.size(); ++l) ++next[part_of(l) + 1];
        for (size_t p = 0; p < 4 * n; ++p) next[p + 1] += next[p];
        scratch.order.resize(at.size());
        for (size_t l = 0; l < at.size(); ++l) scratch.order[next[part_of(l)]++] = std::uint32_t(l);
        // Now where parts end: those of whole blocks are kept.
        next[0] = 0;
        for (size_t b = 1; b <= n; ++b) next[b] = next[4 * b - 1];
        next.resize(n + 1);
    }
};

WEFT_NODE(AnisotropicReconstruct, "anisotropic-reconstruct", 5)

}  // namespace
}  // namespace weft
