// What grows, flies and lies in the garden: each call adds primitives to a scene.
//   open   how much of the evening's light reaches a thing, about 1
//   returns the primitive, good until the next is added
//   roll   the thing's own random numbers; turn, vein phase and the like are taken from it
#pragma once
#include <initializer_list>

#include "samples/analytic_geometry.h"

namespace weft::analytic {

// Random numbers of the i-th thing of a kind, by place: the order they are asked for does not
// matter.
class Dice {
  public:
    Dice(int kind, int i) : key_(std::uint64_t(kind) << 32 | std::uint32_t(i)) {}
    float operator()(int place, float low, float high) const;
    // Three numbers, from three places.
    Vec3 operator()(int place, Vec3 low, Vec3 high) const {
        return {(*this)(place, low.x, high.x), (*this)(place + 1, low.y, high.y),
                (*this)(place + 2, low.z, high.z)};
    }
    // One of the colours, a little lighter or darker.
    Vec3 color(int place, std::initializer_list<Vec3> colors) const;
    static constexpr int inner = 32;  // places from here on are the things' own

  private:
    std::uint64_t key_;
};

struct Wings {
    Vec3 inner, outer, margin, spots;
};

class Planter {
  public:
    explicit Planter(Scene& scene) : scene_(scene) {}

    Primitive& patch(Vec3 origin, Vec3 side_a, Vec3 side_b, Outline outline, Texture texture,
                     float open = 1);
    // Something long from `root` along `direction`; `twist` turns it about its length, 0: facing
    // us.
    Primitive& shoot(Vec3 root, Vec3 direction, float length, float width, float twist,
                     Outline outline, Texture texture, float open = 1);
    Primitive& leaf(const Dice& roll, Vec3 root, Vec3 direction, float length, float width,
                    Vec3 color, float open);
    Primitive& blade(const Dice& roll, Vec3 root, float lean, float length, float width, Vec3 color,
                     float open);
    void stem(Vec3 from, Vec3 to, float width, Vec3 color, float open);
    // A whole blossom in one patch, of 5 or 8 petals; `face` is where it looks.
    void blossom(const Dice& roll, Vec3 at, Vec3 face, float radius, int petals, Vec3 rim,
                 Vec3 throat, float open);
    // One of single petals in two whorls, with a cushion of stamens in the middle.
    void large_blossom(const Dice& roll, Vec3 at, Vec3 face, float radius, int petals, Vec3 tip,
                       Vec3 root, float open);
    // `ahead` is where it flies, `up` its back; `lift` the angle of the wings at mid-shutter,
    // `beat` how far they turn over the shutter.
    void butterfly(Vec3 at, Vec3 ahead, Vec3 up, float size, float lift, float beat, Vec3 motion,
                   const Wings& wings, float open);
    Primitive& light(Vec3 at, float radius, Vec3 radiance);  // a small disk that glows
    Primitive& sphere(Vec3 at, float radius, Texture texture, Vec3 color, Vec3 second = {});

    // Bends by `tip` over the shutter; the root stays.
    static void sway(Primitive& p, Vec3 tip) { p.origin_motion = p.side_b_motion = 0.5f * tip; }

  private:
    Scene& scene_;
};

}  // namespace weft::analytic
