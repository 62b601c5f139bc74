// Radiance anywhere in scaled space, from the samples that are near by their own distances.
// Source: Hachisuka et al. 2008, Sec. 5 (the sample of least distance decides).  Departure: three
// samples share, and each goes on by its gradient.
#pragma once
#include <algorithm>

#include "adaptive/near_samples.h"

namespace weft::adaptive {

// nearest: the sample of least distance alone.  tent: the three of least distance, by how much
// nearer they are than the next.  linear: the same, each going on by its gradient as far as its
// neighbours' radiance goes. Where one of the three outshines another, the nearest alone.
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
        NearbySamples nearby;
        CountingSamples counting;
        NearestSamples nearest;
        NearSamples near;
        LeastDistance distances;
        std::vector<PointTree::Near> found;
        float reach = 1;
    };
    // Looks for what may count between lo and hi, px on all axes; at() asks for places there.
    void prepare(const float* lo, const float* hi, Scratch& scratch) const {
        if (blend_ != Blend::nearest) gather(metrics_, lo, hi, scratch.nearby);
    }
    // to(i) takes three numbers for place i. The closer places lie together, the sooner it is done;
    // those of blend nearest differ in x and y alone.
    template <class To>
    void at(Places& places, Scratch& scratch, To&& to) const {
        if (places.size == 0) return;
        places.pad();
        std::array<float, most_axes> lo{}, hi{}, place{};
        places.bounds(lo.data(), hi.data());
        const auto take = [&](size_t i) {
            for (size_t d = 0; d < places.axes; ++d) place[d] = places.at[d][i];
        };
        if (blend_ != Blend::nearest) {
            WEFT_PICK(find_counting)
            (scratch.nearby, metrics_.upper.data(), lo.data(), hi.data(), scratch.counting);
            WEFT_PICK(nearest_by_metric)(scratch.counting, places, scratch.nearest);
            for (size_t i = 0; i < places.size; ++i) {
                take(i);
                mix(place.data(), i, scratch, to(i));
            }
            return;
        }
        const Block block{lo[0], lo[1], hi[0], hi[1]};
        bool all = gather(metrics_, block, lo.data(), scratch.reach, scratch.near), grown = false;
        for (size_t i = 0; i < places.size; ++i) {
            take(i);
            while (!nearest(place.data(), all ? 1e29f : scratch.reach * scratch.reach, scratch,
                            to(i))) {
                scratch.reach *= 1.25f;
                grown = true;
                all = gather(metrics_, block, lo.data(), scratch.reach, scratch.near);
            }
        }
        if (!grown) scratch.reach *= 0.95f;
    }

  private:
    bool nearest(const float* place, float within2, Scratch& scratch, float* to) const;
    void mix(const float* place, size_t i, Scratch& scratch, float* to) const;
    void radiance(size_t in_tree, const float* place, float* to) const;

    const Metrics& metrics_;
    const float* rgb_;
    std::int32_t wanted_;
    Blend blend_;
};

}  // namespace weft::adaptive
