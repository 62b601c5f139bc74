// Guides: what a filter of pictures goes by, as its node is given it, and as kernels want it.
#pragma once
#include <string>
#include <vector>

#include "filters/similarity.h"
#include "image/image.h"
#include "runtime/node.h"

namespace weft {

// Pictures of one size. Those that are null are not there.
struct Guides {
    const Image* image = nullptr;              // to be filtered, all its channels
    const Image* variance = nullptr;           // of its values; channels of the same names
    const Image* features = nullptr;           // any channels; normal.x normal.y ... are a layer
    const Image* features_variance = nullptr;  // channels alike
    const Image* mask = nullptr;               // its channel A, or its first: 0 or NaN is a hole
};
Guides guides_of(const Inputs& in);
inline constexpr const char* mask_about =
    "pixels where its A, or its first channel, is 0 or NaN lend nothing and are filled";
inline constexpr const char* filtered_about =
    "same size, channels and colour space; pixels that are masked or not finite are filled";

// Which layers count, and up to what change: the parameters of nodes that go by features.
struct LayerChoice {
    std::vector<std::string> layers;  // empty: all
    std::vector<float> sigmas{4};     // in the order of `layers`; one: of all
    float least = 0.02f;
    float k_features = 2;

    template <class Node>
    static void declare_layers(Ports<Node>& node) {
        node.template in<Image>("features",
                                "layers: normal.x normal.y normal.z albedo.x ..., any units",
                                Need::optional)
            .template in<Image>("features-variance",
                                "of their noise, channels alike; without it they have none",
                                Need::optional)
            .param("layers", static_cast<std::vector<std::string> Node::*>(&LayerChoice::layers),
                   {.about = "features that count, as normal, albedo; empty: all"})
            .param("sigmas", static_cast<std::vector<float> Node::*>(&LayerChoice::sigmas),
                   {.unit = "px",
                    .about = "one a layer, or one for all: how many pixels' worth of its own slope "
                             "a layer may change by (a-trous: taps' worth)"})
            .param("least", static_cast<float Node::*>(&LayerChoice::least),
                   {.min = 0,
                    .max = 100,
                    .about = "what a layer may change by where it has no slope, as part of its "
                             "deviation over the picture"})
            .param("k-features", static_cast<float Node::*>(&LayerChoice::k_features),
                   {.min = 0,
                    .max = 100,
                    .about = "what passes as alike, in deviations of the features' noise"});
    }
};

// Planes for filters with taps up to `reach` pixels away. Colour is R G B where the picture has
// them, else all its channels; its term has neither e nor k2 yet. Values that are not finite, or
// past 1e18, and variances likewise, make holes; negative variances are 0. A feature that is not
// finite is a value of its own: far from all others, like its kind. Throws Error where sizes,
// channels or layers do not fit.
kernel::Similarity similarity_of(const Guides& guides, int reach, int patch, Context& ctx);
// Adds the layers' terms. To be called once.
void add_features(const Guides& guides, const LayerChoice& choice, kernel::Similarity& by,
                  Context& ctx);

// Window of (2 radius + 1)^2 taps; Gaussian weights of this deviation, or all 1 (0).
std::vector<kernel::Tap> window(int radius, float sigma = 0);

// Runs the kernel over the picture: its output planes, in the memory of `room` where that fits.
kernel::Planes means(const kernel::Similarity& by, Context& ctx, double done = 0, double of = 1,
                     kernel::Planes room = {});
// The filtered picture; tells of holes that nothing was near enough to fill.
Image picture_of(const kernel::Planes& means, const Guides& guides, const kernel::Similarity& by,
                 Context& ctx);

// What such a node costs: floats of planes a pixel, taps, patch.
Cost similarity_cost(const Shapes& in, double taps, int patch);

}  // namespace weft
