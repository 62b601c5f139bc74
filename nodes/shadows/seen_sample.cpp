// seen-sample: which sample each location sees: of the surface that it sees, the one that lands
// nearest. Source: Lehtinen et al. 2011, Sec. 4: a shadow is asked for at a sample's own place, as
// a mean of several depths could hang in mid-air.
#include <bit>

#include "light-field/streams.h"
#include "runtime/node.h"
#include "samples/random.h"
#include "shadows/streams.h"

namespace weft {
namespace {

struct SeenSample {
    static void declare(Ports<SeenSample>& node) {
        node.about("the sample that each location sees: the nearest one of its surface")
            .in<Candidates>("candidates", "the samples near each location")
            .in<Surfaces>("surfaces", "their surfaces")
            .in<Visibility>("visibility", "the surface seen")
            .out<SeenSamples>("seen", "none where it is not decided which surface is seen");
    }
    void batch(const Inputs& in, Outputs& out) const {
        const Candidates& c = in.get<Candidates>("candidates");
        const Surfaces& s = in.get<Surfaces>("surfaces");
        const Visibility& v = in.get<Visibility>("visibility");
        SeenSamples& seen = out.get<SeenSamples>("seen");
        seen.sample.assign(c.size(), SeenSamples::none);
        size_t part = 0;
        for (size_t l = 0; l < c.size(); ++l) {
            std::uint16_t first = 0, last = 0;
            // Of several surfaces one, as often as its share says.
            float left = v.decision[l] == Decision::partly ? number_of(c, l) : 0.0f;
            bool chosen = false;
            v.each_seen(l, part, [&](std::uint16_t from, std::uint16_t to, float share) {
                if (chosen) return;
                first = from, last = to;
                left -= share;
                chosen = left < 0;
            });
            if (v.decision[l] == Decision::undecided) continue;
            float least = 1e38f;
            for (std::uint32_t i = c.offset[l]; i < c.offset[l + 1]; ++i) {
                if (s.surface[i] < first || s.surface[i] > last) continue;
                const float d2 = c.dx[i] * c.dx[i] + c.dy[i] * c.dy[i];
                if (d2 < least) least = d2, seen.sample[l] = c.sample[i];
            }
        }
    }

  private:
    // In [0, 1), a function of where the location lies.
    static float number_of(const Candidates& c, size_t l) {
        const auto bits = [](float a, float b) {
            return std::uint64_t(std::bit_cast<std::uint32_t>(a)) << 32 |
                   std::bit_cast<std::uint32_t>(b);
        };
        return unit_float(mix(mix(bits(c.x[l], c.y[l])) ^ bits(c.u_of(l), c.t_of(l))));
    }
};

WEFT_NODE(SeenSample, "seen-sample", 1)

}  // namespace
}  // namespace weft
