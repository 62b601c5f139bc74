// split-samples: a sample buffer as two, each pixel's samples by turns. What is made of the one
// knows nothing of the other, so the other tells how good it is (cross-validate); and how much the
// two differ tells how noisy.
#include <fmt/format.h>

#include "runtime/node.h"
#include "samples/take_samples.h"

namespace weft {
namespace {

struct SplitSamples {
    static void declare(Ports<SplitSamples>& node) {
        node.about("a sample buffer as two, each pixel's samples by turns")
            .in<Samples>("samples",
                         "any samples a pixel; of an odd number one more goes to the first half in "
                         "every other pixel, as on a chessboard, to the second in the rest")
            .out<Samples>("first", "all channels")
            .out<Samples>("second", "the samples that are not in the first");
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        const Shape half{s.width, s.height, 0, s.records / 2, s.bytes / 2};
        return {{{"first", half}, {"second", half}}, 8 * double(s.records), double(s.records)};
    }

    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        if (samples.domain != "camera")
            ctx.fail(fmt::format("samples of domain '{}' have no pixels; expected domain 'camera'",
                                 samples.domain));
        size_t single = 0;
        for (size_t pixel = 0; pixel < samples.pixels(); ++pixel) {
            const auto [begin, end] = samples.of_pixel(pixel);
            single += end - begin == 1;
        }
        if (single > 0)
            ctx.warn(fmt::format(
                "{} of {} pixels have one sample, which one half has and the other lacks: by these "
                "pixels the halves cannot be compared",
                single, samples.pixels()));
        out.set("first", half(samples, 0, ctx));
        out.set("second", half(samples, 1, ctx));
    }

  private:
    static Samples half(const Samples& from, size_t which, Context& ctx) {
        std::vector<std::uint32_t> taken;
        taken.reserve(from.size() / 2 + from.pixels() / 2 + 1);
        std::vector<std::uint64_t> first{0};
        first.reserve(from.pixels() + 1);
        for (size_t pixel = 0; pixel < from.pixels(); ++pixel) {
            const auto [begin, end] = from.of_pixel(pixel);
            const size_t x = pixel % size_t(from.width), y = pixel / size_t(from.width);
            for (size_t i = begin + (x + y + which) % 2; i < end; i += 2)
                taken.push_back(std::uint32_t(i));
            first.push_back(taken.size());
        }
        Samples to = from;
        to.set_size(taken.size());
        to.spp = from.spp % 2 == 0 ? from.spp / 2 : 0;
        to.first = to.spp > 0 ? Array<std::uint64_t>() : std::move(first);
        to.channels.clear();
        for (const Channel& channel : from.channels) to.add(take_samples(channel, taken, ctx));
        to.meta = to.meta_object();
        return to;
    }
};

WEFT_NODE(SplitSamples, "split-samples", 1)

}  // namespace
}  // namespace weft
