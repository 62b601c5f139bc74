// The lens that samples and locations are drawn over: its outline, and the shutter's curve.
#pragma once
#include <array>
#include <span>

#include "samples/samples.h"

namespace weft {

// (a, b) in the unit square to the lens, areas kept: the unit disk (Shirley and Chiu 1997), or the
// polygon inside it where the lens has three blades or more.
std::array<float, 2> on_lens(float a, float b, const Lens& lens);

// A number in [0, 1) to a time in [0, 1), more often where the shutter is wider open. `curve`: how
// far open at equal steps over [0, 1], linear between; empty, or nowhere above 0: open all the
// time.
class ShutterCurve {
  public:
    ShutterCurve() = default;
    explicit ShutterCurve(std::span<const float> curve);
    float time(float number) const;
    float openness(float time) const;  // mean 1
    bool constant() const { return open_.empty(); }

  private:
    std::vector<float> open_;  // mean 1
    std::vector<double> sum_;  // of all before each step
};

// `shutter_curve` of a buffer's meta; open all the time where there is none.
ShutterCurve shutter_of(const Json& meta);

}  // namespace weft
