// EnvironmentLight: light from everywhere, by a map or the same from all sides, with directions
// drawn in proportion to what comes from them.
// Source: Pharr, Jakob and Humphreys, "Physically Based Rendering" (4th ed.), Sec. 12.5: a marginal
// and a conditional distribution over the map's texels. Departure: their weights are means of 3 x 3
// texels, so that every direction whose (bilinear) radiance is above 0 can be drawn.
#pragma once
#include <vector>

#include "render/scene.h"

namespace weft::render {

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
    Vec3 texel(int x, int y) const;
    Vec3 from_map(float u, float v) const;

    bool present_ = false, visible_ = true;
    Vec3 radiance_, mean_;
    std::shared_ptr<const Image> map_;
    float sine_ = 0, cosine_ = 1;
    int width_ = 0, height_ = 0;
    std::vector<float> rows_, columns_;  // sums: height + 1; height x (width + 1), each ends at 1
};

}  // namespace weft::render
