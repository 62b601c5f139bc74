// PixelRays: the shadow rays of a camera's samples, pixel by pixel, as filters of visibility read
// them: where on the light each began, where its receiver lies, and whether it got there.
#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "samples/samples.h"
#include "shadows/camera_samples.h"
#include "shadows/light_view.h"

namespace weft::shadows {

struct ShadowRay {
    Point3 light, receiver;  // in light space
    std::uint32_t sample = 0, id = 0;
    bool lit = false;
    double slope = 0;  // d1 / d2 - 1 of what stops it; 0: nothing does
};

// What most of a pixel's samples show.
struct PixelReceiver {
    Point3 at, normal;  // in light space, means; normal 0: not known, at.z 0: nothing is shown
    std::uint32_t id = 0;
    double pixel = 0;  // how wide the pixel is there, world units
};

class PixelRays {
  public:
    // Keeps references. Throws Error, as `who`, where the buffers do not belong together.
    PixelRays(const Samples& samples, const LightView& view, const Samples& light_samples,
              std::string_view who);

    // Where a pixel's samples lie, in light space; and what is known of it given that.
    void find_places(int x, int y, std::vector<Point3>& places) const;
    void of_pixel(int x, int y, std::span<const Point3> places, std::vector<ShadowRay>& rays) const;
    PixelReceiver receiver(int x, int y, std::span<const Point3> places) const;

  private:
    std::uint32_t id(size_t i) const { return ids_.empty() ? 0 : ids_[i]; }

    const Samples& samples_;
    const LightView& view_;
    CameraSamples camera_;
    std::span<const float> q_, l_, w_, normal_;
    std::span<const std::uint32_t> source_, ids_;
};

}  // namespace weft::shadows
