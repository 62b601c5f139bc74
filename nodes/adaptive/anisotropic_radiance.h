// Radiance anywhere in scaled space, from the samples that are near by their own distances.
// Source: Hachisuka et al. 2008, Sec. 5 (the sample of least distance decides).  Departure: three
// samples share, and each goes on by its gradient.
#pragma once
#include "adaptive/near_samples.h"

namespace weft::adaptive {

// nearest: the sample of least distance alone.  tent: the three of least distance, by how much
// nearer they are than the next.  linear: the same, each going on by its gradient as far as its
// neighbours' radiance goes.
enum class Blend { nearest, tent, linear };

class AnisotropicRadiance {
  public:
    // `rgb`: of the samples, three numbers each, in the buffer's order. All are looked at for as
    // long as this is. `candidates` are those of nearest.
    AnisotropicRadiance(const Metrics& metrics, const float* rgb, int candidates, Blend blend)
        : metrics_(metrics),
          rgb_(rgb),
          wanted_(std::int32_t(std::min(size_t(candidates), metrics.size()))),
          blend_(blend) {}

    // Keeps its reach from call to call, which changes no bit.
    struct Scratch {
        NearSamples near;
        LeastDistance distances;
        std::vector<PointTree::Near> found;
        float reach = 1;
    };
    // to(i) takes three numbers for place i: (x[i], y[i]) px and `other` px from index 2 on. Places
    // of one call lie close together.
    template <class To>
    void at(std::span<const float> x, std::span<const float> y, const float* other,
            Scratch& scratch, To&& to) const {
        Block block{3e38f, 3e38f, -3e38f, -3e38f};
        for (size_t i = 0; i < x.size(); ++i)
            block = {std::min(block.x0, x[i]), std::min(block.y0, y[i]), std::max(block.x1, x[i]),
                     std::max(block.y1, y[i])};
        std::array<float, most_axes> place{};
        for (size_t d = 2; d < metrics_.dimensions(); ++d) place[d] = other[d];
        if (blend_ != Blend::nearest) {
            gather(metrics_, block, other, scratch.near);
            for (size_t i = 0; i < x.size(); ++i) {
                place[0] = x[i], place[1] = y[i];
                mix(place.data(), scratch, to(i));
            }
            return;
        }
        bool all = gather(metrics_, block, other, scratch.reach, scratch.near), grown = false;
        for (size_t i = 0; i < x.size(); ++i) {
            place[0] = x[i], place[1] = y[i];
            while (!nearest(place.data(), all ? 1e29f : scratch.reach * scratch.reach, scratch,
                            to(i))) {
                scratch.reach *= 1.25f;
                grown = true;
                all = gather(metrics_, block, other, scratch.reach, scratch.near);
            }
        }
        if (!grown) scratch.reach *= 0.95f;
    }

  private:
    bool nearest(const float* place, float within2, Scratch& scratch, float* to) const;
    void mix(const float* place, Scratch& scratch, float* to) const;
    void radiance(size_t in_tree, const float* place, float* to) const;

    const Metrics& metrics_;
    const float* rgb_;
    std::int32_t wanted_;
    Blend blend_;
};

}  // namespace weft::adaptive
