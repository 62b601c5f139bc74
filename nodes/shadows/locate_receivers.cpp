// locate-receivers: where on a light's film the shadow of each location is to be looked up: the
// receiver's place at the location's time, seen from one point of the light (receivers.h).
#include "runtime/node.h"
#include "shadows/receivers.h"

namespace weft {
namespace {

struct LocateReceivers {
    std::uint64_t seed = 1;

    static void declare(Ports<LocateReceivers>& node) {
        node.about(
                "where on the light's film, from which of its points and at what time the light of "
                "each location is asked for")
            .in<Locations>("locations", "of the camera")
            .in<SeenSamples>("seen", "the sample that each sees")
            .in<Hierarchy>("hierarchy", "of the camera's samples")
            .in<Samples>("samples",
                         "the same; geometric_normal keeps curved surfaces from shadowing "
                         "themselves, light_density scales the search")
            .in<LightView>("light-view", "of the same samples")
            .out<Locations>("locations", "on the light's film, at a point (u, v) of the light")
            .out<ShadowQueries>("queries", "the receivers' depths there")
            .param("seed", &LocateReceivers::seed, {.about = "of the light's points"});
    }
    using Scratch = shadows::ReceiverBatch;
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const shadows::Receivers receivers(in.get<Hierarchy>("hierarchy"),
                                           in.get<Samples>("samples"),
                                           in.get<LightView>("light-view"));
        receivers.locate(
            seed, in.get<Locations>("locations"), in.get<SeenSamples>("seen").sample,
            [&](std::uint32_t s) { return receivers.of(s); }, scratch, out.get<Locations>("locations"),
            out.get<ShadowQueries>("queries"));
    }
};

WEFT_NODE(LocateReceivers, "locate-receivers", 3)

}  // namespace
}  // namespace weft
