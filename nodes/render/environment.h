// EnvironmentLight: light from everywhere, by a map or the same from all sides, with directions
// drawn in proportion to what comes from them.
// Source: Pharr, Jakob and Humphreys, "Physically Based Rendering" (4th ed.), Sec. 12.5: a marginal
// and a conditional distribution over the map's texels. Departure: their weights are means of 3 x 3
// texels, so that every direction whose (bilinear) radiance is above 0 can be drawn.
#pragma once
#include <span>
#include <vector>

#include "render/scene.h"

namespace weft::render {

// Steps chosen in proportion to their weights.
class SampledSteps {
  public:
    SampledSteps() = default;
    // All weights 0: all alike.
    explicit SampledSteps(std::span<const double> weights);
    size_t size() const { return sums_.size() - 1; }
    float probability(size_t i) const { return sums_[i + 1] - sums_[i]; }
    struct Place {
        size_t index;
        float part;  // of the step, in [0, 1)
    };
    Place at(float number) const;

  private:
    std::vector<float> sums_;           // from 0 to 1
    std::vector<std::uint32_t> guide_;  // where to start looking: by a number's leading part
};

class EnvironmentLight {
  public:
    EnvironmentLight() = default;
    explicit EnvironmentLight(const Environment& environment);

    bool present() const { return present_; }
    bool visible() const { return visible_; }
    Vec3 radiance(Vec3 direction) const;
    // Mean over all directions.
    Vec3 mean() const { return mean_; }

    struct Direction {
        Vec3 direction;
        float density = 0;  // a solid angle
    };
    Direction sample(float a, float b) const;
    float density(Vec3 direction) const;

  private:
    Vec3 texel(int x, int y) const { return texels_[size_t(y) * size_t(width_ + 1) + size_t(x)]; }
    Vec3 from_map(float u, float v) const;

    bool present_ = false, visible_ = true;
    Vec3 radiance_, mean_;
    std::vector<Vec3>
        texels_;  // rows of width + 1, the first texel again at the end; empty: no map
    float sine_ = 0, cosine_ = 1;
    int width_ = 0, height_ = 0;
    SampledSteps rows_;
    std::vector<SampledSteps> columns_;  // of each row
};

}  // namespace weft::render
