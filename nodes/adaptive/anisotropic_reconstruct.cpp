// anisotropic-reconstruct: at each location the radiance of the sample that is nearest by its own
// metric. Source: Hachisuka et al. 2008, Sec. 5.  Departure: a stage of a stream of locations, so
// that any pixel filter follows; 2008 cut leaves into cells below a pixel's size instead.
//   A batch goes by blocks of 4 x 4 px at one (u, v, t): the samples around are brought there once
//   for all its locations. How far around is found out as it goes, and changes no bit.
// Cost: some 0.7 us a location in three dimensions.
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "adaptive/near_samples.h"
#include "runtime/node.h"

namespace weft {
namespace {
using namespace adaptive;

enum class Blend { nearest, tent };

struct AnisotropicReconstruct {
    int candidates = 12;
    Blend blend = Blend::nearest;

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
                    .about = "nearest ones, by plain distance, that are looked at"})
            .choice("blend", &AnisotropicReconstruct::blend, {"nearest", "tent"},
                    {.about = "the nearest alone, or the three nearest by how much nearer they are "
                              "than the next"});
    }

    struct Candidate {
        float distance2;
        std::int32_t by_metric, near;
    };
    struct Scratch {
        NearSamples near;
        LeastDistance distances;
        std::vector<Candidate> mixed;
        std::vector<std::uint32_t> order;
        float reach = 1;
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
        const float* rgb = samples.rgb().data();
        if (!at.shared) {
            for (size_t l = 0; l < at.size(); ++l)
                reconstruct(metrics, at, rgb, l, l + 1, colors, scratch);
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
        for (size_t begin = 0, end; begin < order.size(); begin = end) {
            const std::uint32_t block = block_of(order[begin]);
            for (end = begin + 1; end < order.size() && block_of(order[end]) == block;) ++end;
            reconstruct(metrics, at, rgb, begin, end, colors, scratch);
        }
    }

  private:
    // Locations order[begin] ... order[end - 1], which share (u, v, t) and lie close together.
    void reconstruct(const Metrics& metrics, const Locations& at, const float* rgb, size_t begin,
                     size_t end, Colors& colors, Scratch& scratch) const {
        const auto location = [&](size_t k) { return at.shared ? size_t(scratch.order[k]) : k; };
        Block block{3e38f, 3e38f, -3e38f, -3e38f};
        for (size_t k = begin; k < end; ++k) {
            const float x = at.x[location(k)], y = at.y[location(k)];
            block = {std::min(block.x0, x), std::min(block.y0, y), std::max(block.x1, x),
                     std::max(block.y1, y)};
        }
        std::array<float, most_axes> other{};
        for (size_t d = 2; d < metrics.dimensions(); ++d)
            other[d] = place_of(metrics.space, d, at, location(begin));
        const auto wanted = std::int32_t(std::min(size_t(candidates), metrics.size()));
        float& reach = scratch.reach;
        bool all = gather(metrics, block, other.data(), reach, scratch.near), grown = false;
        for (size_t k = begin; k < end; ++k) {
            const size_t l = location(k);
            while (true) {
                const float within = all ? 1e29f : reach * reach;
                const std::int32_t winner = WEFT_PICK(least_distance)(
                    scratch.near, at.x[l], at.y[l], wanted, within, scratch.distances);
                if (winner != not_known) {
                    if (blend == Blend::nearest)
                        std::copy_n(&rgb[3 * sample(metrics, scratch, winner)], 3,
                                    &colors.rgba[4 * l]);
                    else
                        mix_three(metrics, rgb, wanted, scratch, &colors.rgba[4 * l]);
                    break;
                }
                reach *= 1.25f;
                grown = true;
                all = gather(metrics, block, other.data(), reach, scratch.near);
            }
        }
        if (!grown) reach *= 0.95f;
    }
    static size_t sample(const Metrics& metrics, const Scratch& scratch, std::int32_t near) {
        return metrics.tree->order()[scratch.near.place[size_t(near)]];
    }
    // Of the candidates the three nearest by metric; a weight is 0 where the fourth is as near, so
    // that a sample comes in without a step.
    static void mix_three(const Metrics& metrics, const float* rgb, std::int32_t wanted,
                          Scratch& scratch, float* to) {
        std::vector<Candidate>& all = scratch.mixed;
        all.clear();
        for (size_t i = 0; i < scratch.near.size; ++i)
            all.push_back(
                {scratch.distances.distance2[i], scratch.distances.by_metric[i], std::int32_t(i)});
        const auto by_distance = [](const Candidate& a, const Candidate& b) {
            return a.distance2 != b.distance2 ? a.distance2 < b.distance2 : a.near < b.near;
        };
        std::nth_element(all.begin(), all.begin() + (wanted - 1), all.end(), by_distance);
        all.resize(size_t(wanted));
        std::sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) {
            return a.by_metric != b.by_metric ? a.by_metric < b.by_metric : a.near < b.near;
        });
        const auto distance = [&](size_t k) {
            return std::sqrt(std::bit_cast<float>(all[k].by_metric));
        };
        const size_t three = std::min<size_t>(3, all.size());
        const float far = all.size() > 3 ? distance(3) : 2 * distance(all.size() - 1);
        float sum[3] = {}, weights = 0;
        for (size_t k = 0; k < three; ++k) {
            const float weight = far > 0 ? 1 - distance(k) / far : 1;
            for (size_t c = 0; c < 3; ++c)
                sum[c] += weight * rgb[3 * sample(metrics, scratch, all[k].near) + c];
            weights += weight;
        }
        for (size_t c = 0; c < 3; ++c)
            to[c] =
                weights > 0 ? sum[c] / weights : rgb[3 * sample(metrics, scratch, all[0].near) + c];
    }
};

WEFT_NODE(AnisotropicReconstruct, "anisotropic-reconstruct", 1)

}  // namespace
}  // namespace weft
