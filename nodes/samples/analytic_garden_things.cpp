#include "samples/analytic_garden_things.h"

#include "samples/analytic_paint.h"
#include "samples/random.h"

namespace weft::analytic {
namespace {

// Light on a thin thing: the sky's from above, and the sun's from behind on the left, which shines
// through.
Vec3 thin_light(Vec3 n, float open) {
    const float sun = dot(n, unit(Vec3{-0.62f, -0.30f, 0.72f})), up = std::fabs(n.y);
    const Vec3 sky = Vec3{0.36f, 0.40f, 0.50f} * (0.75f + 0.5f * up);
    return (sky + Vec3{1.9f, 1.15f, 0.55f} * (sun * sun)) * open;
}

}  // namespace

float Dice::operator()(int place, float low, float high) const {
    return low + (high - low) * unit_float(mix(mix(key_) + std::uint64_t(place)));
}

Vec3 Dice::color(int place, std::initializer_list<Vec3> colors) const {
    const auto i = size_t((*this)(place, 0, float(colors.size()) - 0.001f));
    return colors.begin()[i] * (*this)(place + 1000, 0.85f, 1.12f);
}

Primitive& Planter::patch(Vec3 origin, Vec3 side_a, Vec3 side_b, Outline outline, Texture texture,
                          float open) {
    Primitive p;
    p.origin = origin, p.side_a = side_a, p.side_b = side_b;
    p.outline = outline, p.texture = texture;
    p.paint.light = thin_light(unit(cross(side_a, side_b)), open);
    scene_.primitives.push_back(p);
    return scene_.primitives.back();
}

Primitive& Planter::shoot(Vec3 root, Vec3 direction, float length, float width, float twist,
                          Outline outline, Texture texture, float open) {
    const Vec3 along = unit(direction), across = unit(cross(along, Vec3{0, 0, 1}));
    const Vec3 a = std::cos(twist) * across + std::sin(twist) * cross(along, across);
    return patch(root + along * (0.5f * length), a * (0.5f * width), along * (0.5f * length),
                 outline, texture, open);
}

Primitive& Planter::leaf(const Dice& roll, Vec3 root, Vec3 direction, float length, float width,
                         Vec3 color, float open) {
    const float twist = roll(Dice::inner, -0.9f, 0.9f);
    Primitive& p = shoot(root, direction, length, width, twist, leaf_outline, leaf_texture, open);
    p.paint.color = {color, lerp(color, Vec3{0.45f, 0.5f, 0.2f}, 0.45f)};
    p.paint.number[0] = roll(Dice::inner + 1, 0, 1);
    return p;
}

Primitive& Planter::blade(const Dice& roll, Vec3 root, float lean, float length, float width,
                          Vec3 color, float open) {
    const Vec3 direction{lean, -1, roll(Dice::inner, -0.2f, 0.2f)};
    const float twist = roll(Dice::inner + 1, -0.7f, 0.7f);
    Primitive& p =
        shoot(root, direction, length, 2.2f * width, twist, blade_outline, blade_texture, open);
    p.paint.color = {color * 0.45f, color};
    p.paint.number = {roll(Dice::inner + 2, -1.2f, 1.2f), 0.45f};
    return p;
}

void Planter::stem(Vec3 from, Vec3 to, float width, Vec3 color, float open) {
    const Vec3 d = to - from;
    Primitive& p =
        shoot(from, d, std::sqrt(dot(d, d)), 2 * width, 0, blade_outline, blade_texture, open);
    p.square = true;
    p.paint.color = {color * 0.6f, color};
    p.paint.number = {0.0f, 0.55f};
}

void Planter::blossom(const Dice& roll, Vec3 at, Vec3 face, float radius, int petals, Vec3 rim,
                      Vec3 throat, float open) {
    const Vec3 n = unit(face), a = unit(cross(n, Vec3{0.2f, 1, 0.1f})), b = cross(n, a);
    const float turn = roll(Dice::inner, 0, 6.28f), c = std::cos(turn), s = std::sin(turn);
    Primitive& p = patch(at, radius * (c * a + s * b), radius * (c * b - s * a), blossom_outline,
                         blossom_texture, open);
    p.paint.color = {rim, throat, Vec3{0.75f, 0.45f, 0.06f}};
    p.paint.number = {float(petals), 0.34f};
}

void Planter::large_blossom(const Dice& roll, Vec3 at, Vec3 face, float radius, int petals,
                            Vec3 tip, Vec3 root, float open) {
    const Vec3 n = unit(face), a = unit(cross(n, Vec3{0, 1, 0.15f})), b = cross(n, a);
    for (int i = 0; i < 2 * petals; ++i) {
        const bool upper = i >= petals;
        const int place = Dice::inner + 5 * i;
        const float angle = 6.2831853f * (float(i) + (upper ? 0.5f : 0.0f)) / float(petals) +
                            roll(place, -0.06f, 0.06f);
        const float length = radius * (upper ? 0.82f : 1.0f) * roll(place + 1, 0.95f, 1.05f);
        const Vec3 out = std::cos(angle) * a + std::sin(angle) * b;
        const Vec3 along =
            unit(out + n * ((upper ? 0.34f : 0.10f) + roll(place + 2, -0.06f, 0.06f)));
        const Vec3 across = unit(cross(n, out) + n * roll(place + 3, -0.22f, 0.22f));
        Primitive& p = patch(at + along * (0.52f * length) + n * (upper ? 0.015f : 0.0f),
                             across * (length * 0.36f), along * (0.5f * length), petal_outline,
                             petal_texture, open);
        p.paint.color = {tip * roll(place + 4, 0.92f, 1.06f), root};
        p.paint.number[0] = 0.62f;
    }
    Primitive& middle = patch(at + n * (0.11f * radius), a * (0.23f * radius), b * (0.23f * radius),
                              nullptr, stamens_texture, open);
    middle.paint.color = {Vec3{0.92f, 0.55f, 0.06f}, Vec3{0.30f, 0.10f, 0.02f}};
}

void Planter::butterfly(Vec3 at, Vec3 ahead, Vec3 up, float size, float lift, float beat,
                        Vec3 motion, const Wings& wings, float open) {
    const Vec3 f = unit(ahead), right = unit(cross(up, f)) * -1.0f, back = cross(f, right) * -1.0f;
    const auto add_wing = [&](float side, float angle_lift, float turn, float length, float chord,
                              Vec3 root, Outline outline, Texture texture) {
        // Outward and ahead at one end of the beat and the other; the corners go straight between.
        const auto sides = [&](float angle) {
            const Vec3 out = std::cos(angle) * (side * right) + std::sin(angle) * back;
            return std::array{std::cos(turn) * out - std::sin(turn) * f,
                              std::cos(turn) * f + std::sin(turn) * out};
        };
        const auto first = sides(angle_lift - beat / 2), last = sides(angle_lift + beat / 2);
        const auto corner = [&](const auto& s) {
            return root + s[0] * (0.5f * length) + s[1] * (0.5f * chord);
        };
        Primitive& p =
            patch(0.5f * (corner(first) + corner(last)), (first[0] + last[0]) * (0.25f * length),
                  (first[1] + last[1]) * (0.25f * chord), outline, texture, open);
        p.square = true;
        p.origin_motion = corner(last) - corner(first) + motion;
        p.side_a_motion = (last[0] - first[0]) * (0.5f * length);
        p.side_b_motion = (last[1] - first[1]) * (0.5f * chord);
        p.paint.color = {wings.inner, wings.outer, wings.margin, wings.spots};
    };
    for (float side : {-1.0f, 1.0f}) {
        add_wing(side, lift - 0.05f, 0.25f, 0.62f * size, 0.62f * size, at - f * (0.50f * size),
                 hindwing_outline, hindwing_texture);
        add_wing(side, lift, -0.10f, 0.88f * size, 0.74f * size, at - f * (0.06f * size),
                 forewing_outline, forewing_texture);
    }
    Primitive& body = patch(at + back * (0.02f * size), right * (0.065f * size), f * (0.42f * size),
                            leaf_outline, plain, open);
    body.paint.color[0] = wings.margin * 1.3f;
    body.origin_motion = motion;
    for (float side : {-1.0f, 1.0f}) {
        const Vec3 d = unit(f + right * (0.45f * side) + back * 0.35f);
        Primitive& feeler = patch(at + f * (0.36f * size) + d * (0.2f * size),
                                  right * (0.012f * size), d * (0.2f * size), nullptr, plain, open);
        feeler.paint.color[0] = wings.margin * 1.3f;
        feeler.origin_motion = motion;
    }
}

Primitive& Planter::light(Vec3 at, float radius, Vec3 radiance) {
    Primitive& p = patch(at, {radius, 0, 0}, {0, radius, 0}, nullptr, glow_texture);
    p.paint.color[0] = radiance;
    return p;
}

Primitive& Planter::sphere(Vec3 at, float radius, Texture texture, Vec3 color, Vec3 second) {
    Primitive p;
    p.origin = at, p.radius = radius, p.texture = texture;
    p.paint.color = {color, second};
    scene_.primitives.push_back(p);
    return scene_.primitives.back();
}

}  // namespace weft::analytic
