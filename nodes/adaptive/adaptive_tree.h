// Adaptive sampling in many dimensions: a box of the domain where samples differ gets more of them,
// and is cut in two when it has enough. Source: Hachisuka et al. 2008; whole rounds of leaves at
// once after Meister and Hachisuka 2022. Departure: a round takes the leaves of largest error, not
// each by chance; random numbers are a function of a leaf's place in the tree, so that no thread or
// batch changes a bit.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "adaptive/leaf_neighbours.h"

namespace weft::adaptive {

enum class Contrast { relative, absolute, sqrt };
enum class Reach { leaf, neighbours };

struct TreeSettings {
    std::vector<float> extent;  // px of each axis; x and y first
    size_t capacity = 4;        // samples in a leaf; one more and it is cut
    int candidates = 4;         // places tried for a new sample
    Reach reach = Reach::leaf;  // whose samples it is to be far from: with face neighbours or not
    double round = 1.0 / 16;    // of the leaves get a sample in a round
    Contrast contrast = Contrast::relative;
    std::uint64_t seed = 1;
    double alpha = 0;     // not 0: each leaf by chance, with probability (error / largest)^alpha
    int bits = -1;        // first cells: 2^bits along an axis, 2^extra_bits as many along x and y
    int extra_bits = -1;  // -1: as many as the first samples allow
};

// V (sum over channels of mean |f - m| / (m + 0.001), + 1e-5) of n samples of three channels, by
// contrast.
double leaf_error(std::span<const float> rgb, double volume, Contrast contrast);

// Where a box is cut, by its samples' numbers along an axis, ascending: between the last of the
// first half and the next. Not above the former where both are equal.
float plane_between(std::span<const float> along);

class Tree {
  public:
    // Initial cells for about `initial_samples`; for no more than half the budget, if it can be.
    Tree(const TreeSettings& settings, size_t initial_samples, size_t budget);

    size_t leaves() const { return leaves_.size(); }
    size_t samples() const { return rgb_.size() / 3; }
    size_t dimensions() const { return settings_.extent.size(); }
    // Of leaves: volume times contrast.
    std::span<const double> errors() const { return errors_; }
    double largest_error() const;
    double total_error() const;

    // Places of the next round's samples, at most `most`: places(axis) in [0, 1]. The first round
    // is `capacity` places in each initial cell, whatever `most` is.
    size_t request(size_t most);
    std::span<const float> places(size_t axis) const { return requested_[axis]; }
    // Radiance at these, three numbers each.
    void insert(std::span<const float> rgb);

    // What was sampled so far, in the order of requests.
    float at(size_t axis, size_t sample) const { return at_[sample * dimensions() + axis]; }  // px
    std::span<const float> rgb() const { return rgb_; }

    struct Leaf : LeafBox {
        std::uint64_t key = 0;  // of its path from its initial cell
        std::vector<std::uint32_t> samples;
    };
    const Leaf& leaf(size_t i) const { return leaves_[i]; }
    double volume(const Leaf& leaf) const;
    // That share a face with it; of Reach::neighbours alone.
    std::span<const std::uint32_t> neighbours(size_t leaf) const { return neighbours_.of(leaf); }

  private:
    std::vector<std::uint32_t> chosen_leaves(size_t most) const;
    float nearest_sample(size_t leaf, const float* place, float enough) const;
    void add_to(size_t leaf, std::uint32_t sample);
    bool cut(size_t leaf);
    void measure(size_t leaf);

    TreeSettings settings_;
    std::vector<Leaf> leaves_;
    std::vector<double> errors_;                 // of leaves: read together, round by round
    std::vector<char> rests_;                    // leaves too small to be cut, and full
    LeafNeighbours neighbours_;                  // none where no sample is looked for there
    std::vector<std::uint32_t> chosen_;          // leaves of the requested places
    std::vector<std::vector<float>> requested_;  // [0, 1]
    std::vector<float> at_;                      // px, all axes of a sample together
    std::vector<float> rgb_;
    std::uint64_t round_ = 0;
};

}  // namespace weft::adaptive
