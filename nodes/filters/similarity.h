// Means of like pixels: what bilateral, cross-bilateral, non-local means and a-trous filters share.
// Pixel p becomes the mean of pixels q = p + tap, each weighted by
//     tap.weight exp(-max(0, colour distance) - sum over features max(0, feature distance))
// A distance is a squared difference less what noise alone makes of it, over what is let pass:
//     ((a - b)^2 - s (va + min(va, vb))) / (e + k^2 (va + vb))
//   a, b    values at p and q; va, vb variances of their noise (0 where there are none)
//   s       1 takes the noise off, 0 does not
//   e, k^2  what is let pass: as a value, and in variances
// Colour: that of each component over (2 patch + 1)^2 pixels around p and q, averaged. A feature
// is a vector: squared differences are summed over its components, and so are its variances.
//   holes   pixels that nothing is known of, as those past the edges: they lend nothing and count
//           in no patch, but get what likeness of what is known gives them
// Source: Rousselle, Knaus and Zwicker 2012 (the distance), Tomasi and Manduchi 1998 (bilateral),
// Buades, Coll and Morel 2005 (patches). Departures: e may grow with the feature's own slope; the
// patch is cut at the picture's edges.
#pragma once
#include <vector>

#include "filters/planes.h"

namespace weft::kernel {

struct Tap {
    int dx = 0, dy = 0;
    float weight = 1;
};

// One distance: planes of a picture and what they are measured by.
struct Term {
    int first = 0, components = 0;
    int variances = -1;       // first plane; -1: no noise
    int variance_planes = 0;  // as many as components; of a vector also one, their sum
    int slope = -1;           // plane of squared changes to the next pixel; -1: none
    float slope_gain = 0;     // e is the larger of `e` and slope_gain times the slope
    float e = 1;
    float k2 = 0;
    float subtract = 1;
};

struct Similarity {
    Planes planes;
    int channels = 0;    // planes 0 ... are what is averaged
    int variances = -1;  // first plane of the variances of the first `color.components` of these;
                         // -1: variances of the means are not asked for
    int known = 0;       // plane of 1, and 0 in holes
    bool holes = false;  // whether there are any in the picture
    bool apart = true;   // colour: each component has a denominator of its own, and their mean
                         // counts; else the colour is a vector, as features are
    Term color;          // no components: colour does not count
    int patch = 0;       // px; of colour alone
    std::vector<Term> features;
    std::vector<Tap> taps;  // of a row together
};

// Exponents end here: e^-80 is nothing beside a pixel's own weight of 1, and a hole still takes
// what is least unlike it.
inline constexpr float last_exponent = 80;

// Output planes: `channels` means, then (with variances) as many variances of the means as colour
// has components, then the total weight. Where that is 0 the means are 0.
int output_planes(const Similarity& by);

// Pixels [x0, x1) x [y0, y1) of all output planes. What a pixel gets does not depend on the block.
struct Block {
    int x0, y0, x1, y1;
};
struct SimilarityScratch {
    std::vector<float> distances, known, box, known_box, weights, sums;
    std::vector<Tap> taps;
};
// Cost: about taps x (10 components of colour + 4 patch + 8 features + 20) operations a pixel.
namespace v2 {
void similar_means(const Similarity& by, Block block, SimilarityScratch& scratch, Planes& out);
}
namespace v3 {
void similar_means(const Similarity& by, Block block, SimilarityScratch& scratch, Planes& out);
}
namespace v4 {
void similar_means(const Similarity& by, Block block, SimilarityScratch& scratch, Planes& out);
}

// The same of one pixel, written down as defined, in double: what similar_means() is held to.
void similar_mean(const Similarity& by, int x, int y, double* out);

}  // namespace weft::kernel
