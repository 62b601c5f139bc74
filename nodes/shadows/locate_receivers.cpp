// locate-receivers: where on a light's film the shadow of each location is to be looked up: the
// receiver's place at the location's time, seen from one point of the light (receivers.h).
#include "runtime/node.h"
#include "shadows/receivers.h"

namespace weft {
namespace {

struct LocateReceivers {
    std::uint64_t seed = 1;
    shadows::Nearness metric = shadows::Nearness::round;
    float max_anisotropy = 4;

    static void declare(Ports<LocateReceivers>& node) {
        node.about(
                "where on the light's film, from which of its points and at what time the light of "
                "each location is asked for")
            .in<Locations>("locations", "of the camera")
            .in<SeenSamples>("seen", "the sample that each sees")
            .in<Hierarchy>("hierarchy", "of the camera's samples")
            .in<Samples>("samples",
                         "the same; geometric_normal keeps curved surfaces from shadowing "
                         "themselves, light_density scales the search, light_metric shapes it; what "
                         "sees all of the light (all_lit) is not asked")
            .in<LightView>("light-view", "of the same samples")
            .out<Locations>("locations", "on the light's film, at a point (u, v) of the light")
            .out<ShadowQueries>("queries", "the receivers' depths there")
            .param("seed", &LocateReceivers::seed, {.about = "of the light's points"})
            .choice("metric", &LocateReceivers::metric, {"round", "ellipse"},
                    {.about = "by what light samples are near: px of film, or px of the camera's "
                              "picture as light_metric lays them on it"})
            .param("max-anisotropy", &LocateReceivers::max_anisotropy,
                   {.min = 1,
                    .max = 256,
                    .about = "of an ellipse: how much longer than wide it may be. Nodes that look "
                             "for light samples should look the root of that times as far"});
    }
    using Scratch = shadows::ReceiverBatch;
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const shadows::Receivers receivers(in.get<Hierarchy>("hierarchy"),
                                           in.get<Samples>("samples"),
                                           in.get<LightView>("light-view"),
                                           metric == shadows::Nearness::round ? 1 : max_anisotropy);
        const SeenSamples& seen = in.get<SeenSamples>("seen");
        ShadowQueries& queries = out.get<ShadowQueries>("queries");
        queries.chance = seen.chance;
        receivers.locate(
            seed, in.get<Locations>("locations"), seen.sample,
            [&](std::uint32_t s) { return receivers.of(s); }, scratch, out.get<Locations>("locations"),
            queries);
    }
};

WEFT_NODE(LocateReceivers, "locate-receivers", 4)

}  // namespace
}  // namespace weft
