// A garden at dusk, from near to far: blossoms and a branch close to the lens, grass along a tiled
// path, cosmos in focus with butterflies about them, glazed balls on the path (one rolling), hedges
// full of small lights, a string of lanterns, hills, and the sky at infinity.
#include "samples/analytic_garden.h"

#include <algorithm>

#include "samples/analytic_paint.h"
#include "samples/random.h"

namespace weft::analytic {
namespace {

constexpr float ground = 1.1f;  // y of the ground: the camera's height
constexpr float in_focus = 6.0f;

// Where things stand on the ground that darken it: x, z, radius.
struct Footprint {
    float x, z, radius, strength;
};
constexpr Footprint footprints[] = {{-1.42f, 6.15f, 0.52f, 0.75f},
                                    {-0.72f, 5.45f, 0.30f, 0.7f},
                                    {1.55f, 6.3f, 1.25f, 0.6f},
                                    {-3.4f, 8.0f, 1.6f, 0.6f},
                                    {3.6f, 8.4f, 1.8f, 0.6f}};

constexpr float field_extent = 40, field_z = 41;

float path_middle(float z) {
    return -0.75f + 0.035f * (z - 6) - 0.012f * (z - 6) * (z - 6) * smooth(0, 8, z - 6);
}
constexpr float path_half = 1.15f;

Vec3 tile_color(float x, float z, Vec3 grass) {
    constexpr float size = 0.42f;
    const float s = x / size, t = z / size, cell_x = std::floor(s), cell_z = std::floor(t);
    const float u = s - cell_x - 0.5f, v = t - cell_z - 0.5f;
    const Vec3 cream{0.62f, 0.55f, 0.45f}, teal{0.08f, 0.24f, 0.27f}, clay{0.50f, 0.19f, 0.11f};
    const float au = std::fabs(u), av = std::fabs(v), corner = std::hypot(0.5f - au, 0.5f - av),
                middle = std::hypot(u, v);
    // Eight-pointed star in the middle, quarter rings at the corners.
    const float star = std::min(std::max(au, av), (au + av) * 0.7071f);
    Vec3 c = lerp(teal, cream, smooth(0.235f, 0.245f, star));
    c = lerp(clay, c, smooth(0.125f, 0.135f, middle));
    c = lerp(cream, c, smooth(0.045f, 0.055f, middle));
    c = lerp(teal, c, smooth(0.03f, 0.04f, std::fabs(corner - 0.25f)));
    c = lerp(clay, c, smooth(0.12f, 0.13f, corner));
    const float wear = noise(x * 5, z * 5) * 0.5f + noise(x * 19, z * 19) * 0.5f;
    c = c * (0.62f + 0.55f * wear) * (0.9f + 0.2f * noise(cell_x * 3.7f, cell_z * 5.3f));
    const float joint = std::min(0.5f - au, 0.5f - av);
    return lerp(grass * 0.5f, c, smooth(0.012f, 0.03f, joint + 0.012f * (wear - 0.5f)));
}

// Lawn with a tiled path, both lit by the evening; x and z from the patch's own coordinates.
Surface ground_texture(const Paint& paint, float a, float b, Vec3) {
    const float x = a * field_extent, z = field_z + b * field_extent;
    const float tuft = noise(x * 3.1f, z * 2.3f), fine = noise(x * 21, z * 13),
                broad = noise(x * 0.6f, z * 0.35f);
    Vec3 grass = lerp(Vec3{0.035f, 0.075f, 0.022f}, Vec3{0.16f, 0.20f, 0.05f},
                      0.45f * tuft + 0.3f * fine + 0.25f * broad);
    // Daisies.
    const float dx = x * 2.3f, dz = z * 1.5f, cx = std::floor(dx), cz = std::floor(dz);
    const float px = 0.2f + 0.6f * noise(cx * 7.3f + 0.5f, cz * 3.1f),
                pz = 0.2f + 0.6f * noise(cx * 2.9f, cz * 8.7f + 0.5f);
    const float daisy = std::hypot(dx - cx - px, (dz - cz - pz) * 1.5f);
    if (noise(cx * 5.1f + 9, cz * 4.3f) > 0.55f)
        grass = lerp(grass, Vec3{0.8f, 0.72f, 0.66f}, smooth(0.075f, 0.05f, daisy));
    const float edge = std::fabs(x - path_middle(z)) + 0.10f * (noise(x * 4, z * 4) - 0.5f);
    Vec3 c = edge < path_half ? tile_color(x - path_middle(6), z, grass) : grass;
    float shade = 1 - 0.35f * smooth(0.12f, 0.0f, std::fabs(edge - path_half));
    for (const Footprint& f : footprints) {
        const float d =
            ((x - f.x) * (x - f.x) + (z - f.z) * (z - f.z) * 0.8f) / (f.radius * f.radius);
        shade *= 1 - f.strength * smooth(1.0f, 0.0f, d);
    }
    // The low sun reaches the far lawn; haze takes over towards the hills.
    const Vec3 light = lerp(Vec3{0.78f, 0.74f, 0.76f}, Vec3{1.9f, 1.35f, 0.75f}, smooth(8, 26, z));
    Vec3 radiance = c * light * paint.light * shade;
    radiance = lerp(radiance, Vec3{0.62f, 0.40f, 0.30f}, 0.75f * smooth(14, 70, z));
    return {c, radiance};
}

Vec3 dusk_sky(float x, float y) {
    const float up = std::max(0.0f, -y);
    Vec3 c = lerp(Vec3{1.75f, 0.92f, 0.42f}, Vec3{1.15f, 0.62f, 0.50f}, smooth(0.0f, 0.07f, up));
    c = lerp(c, Vec3{0.58f, 0.42f, 0.52f}, smooth(0.04f, 0.15f, up));
    c = lerp(c, Vec3{0.20f, 0.27f, 0.44f}, smooth(0.10f, 0.27f, up));
    // Veils of cloud, and the sun just above the hills.
    const float veil = noise(x * 5 + 3, y * 34) * 0.6f + noise(x * 13, y * 80) * 0.4f;
    c = lerp(c, Vec3{1.5f, 0.78f, 0.52f},
             0.55f * smooth(0.52f, 0.85f, veil) * smooth(0.27f, 0.05f, up));
    const float dx = x + 0.16f, dy = y + 0.035f, d2 = dx * dx + dy * dy;
    c = c + Vec3{2.2f, 1.25f, 0.5f} * std::exp(-d2 * 130) +
        Vec3{0.5f, 0.25f, 0.08f} * std::exp(-d2 * 14);
    return lerp(c, Vec3{9.0f, 6.2f, 3.4f}, smooth(0.00052f, 0.00040f, d2));
}

class Garden {
  public:
    explicit Garden(Scene& scene) : scene_(scene) {}

    void plant();

  private:
    float random(float low, float high) {
        return low + (high - low) * unit_float(mix(++drawn_ * 0x632be59bd9b4e019ull));
    }
    bool chance(float p) { return random(0, 1) < p; }
    Vec3 random_color(std::initializer_list<Vec3> colors) {
        const auto i = size_t(random(0, float(colors.size()) - 0.001f));
        return colors.begin()[i] * random(0.85f, 1.12f);
    }

    // Light on a thin thing: sky from above, and the sun behind on the left, which shines through.
    static Vec3 thin_light(Vec3 n, float open) {
        const float sun = std::fabs(dot(n, unit(Vec3{-0.62f, -0.30f, 0.72f})));
        const float up = std::fabs(n.y);
        return (Vec3{0.36f, 0.40f, 0.50f} * (0.75f + 0.5f * up) +
                Vec3{1.9f, 1.15f, 0.55f} * (sun * sun)) *
               open;
    }

    Primitive& patch(Vec3 origin, Vec3 side_a, Vec3 side_b, Outline outline, Texture texture,
                     float open = 1) {
        Primitive p;
        p.origin = origin, p.side_a = side_a, p.side_b = side_b;
        p.outline = outline, p.texture = texture;
        p.paint.light = thin_light(unit(cross(side_a, side_b)), open);
        scene_.primitives.push_back(p);
        return scene_.primitives.back();
    }
    // Something long that grows from `root` along `direction`; `roll` turns it about its length, 0:
    // facing us.
    Primitive& shoot(Vec3 root, Vec3 direction, float length, float width, float roll,
                     Outline outline, Texture texture, float open = 1) {
        const Vec3 along = unit(direction);
        const Vec3 across = unit(cross(along, Vec3{0, 0, 1}));
        const Vec3 a = std::cos(roll) * across + std::sin(roll) * cross(along, across);
        return patch(root + along * (0.5f * length), a * (0.5f * width), along * (0.5f * length),
                     outline, texture, open);
    }
    // Bends by `tip` over the shutter, the root stays.
    static void sway(Primitive& p, Vec3 tip) { p.origin_motion = p.side_b_motion = 0.5f * tip; }

    Primitive& leaf(Vec3 root, Vec3 direction, float length, float width, float roll, Vec3 color,
                    float open) {
        Primitive& p =
            shoot(root, direction, length, width, roll, leaf_outline, leaf_texture, open);
        p.paint.color = {color, lerp(color, Vec3{0.45f, 0.5f, 0.2f}, 0.45f)};
        p.paint.number[0] = random(0, 1);
        return p;
    }
    Primitive& blade(Vec3 root, float lean, float length, float width, Vec3 color, float open) {
        Primitive& p = shoot(root, {lean, -1, random(-0.2f, 0.2f)}, length, 2.2f * width,
                             random(-0.7f, 0.7f), blade_outline, blade_texture, open);
        p.paint.color = {color * 0.45f, color};
        p.paint.number = {random(-1.2f, 1.2f), 0.45f};
        return p;
    }
    Primitive& light(Vec3 at, float radius, Vec3 radiance) {
        Primitive& p = patch(at, {radius, 0, 0}, {0, radius, 0}, nullptr, glow_texture);
        p.paint.color[0] = radiance;
        return p;
    }
    // A whole blossom in one patch; `face` is where it looks.
    Primitive& blossom(Vec3 at, Vec3 face, float radius, int petals, Vec3 rim, Vec3 throat,
                       float open) {
        const Vec3 n = unit(face);
        const Vec3 a = unit(cross(n, Vec3{0.2f, 1, 0.1f})), b = cross(n, a);
        const float turn = random(0, 6.28f);
        Primitive& p = patch(at, radius * (std::cos(turn) * a + std::sin(turn) * b),
                             radius * (std::cos(turn) * b - std::sin(turn) * a), blossom_outline,
                             blossom_texture, open);
        p.paint.color = {rim, throat, Vec3{0.75f, 0.45f, 0.06f}};
        p.paint.number = {float(petals), 0.34f};
        return p;
    }
    void stem(Vec3 from, Vec3 to, float width, Vec3 color, float open) {
        const Vec3 d = to - from;
        Primitive& p =
            shoot(from, d, std::sqrt(dot(d, d)), 2 * width, 0, blade_outline, blade_texture, open);
        p.square = true;
        p.paint.color = {color * 0.6f, color};
        p.paint.number = {0.0f, 0.55f};
    }
    // A blossom of single petals in two whorls, a cushion of stamens in the middle.
    void hero_blossom(Vec3 at, Vec3 face, float radius, int petals, Vec3 tip, Vec3 root,
                      float open);
    struct Wings {
        Vec3 inner, outer, margin, spots;
    };
    // `ahead` where it flies, `up` its back; `lift` the angle of the wings at mid-shutter, `beat`
    // its change.
    void butterfly(Vec3 at, Vec3 ahead, Vec3 up, float size, float lift, float beat, Vec3 motion,
                   const Wings& wings, float open);
    void ball(Vec3 at, float radius, int pattern, Vec3 glaze, Vec3 mark, float turn, Vec3 motion);

    void far();
    void hedge(Vec3 middle, Vec3 extent, int leaves, int lights);
    void lanterns();
    void meadow();
    void flowers();
    void fliers();
    void close();

    Scene& scene_;
    std::uint64_t drawn_ = 0;
};

const Vec3 pink{0.80f, 0.22f, 0.36f}, coral{0.88f, 0.26f, 0.15f}, white{0.85f, 0.78f, 0.76f},
    plum{0.38f, 0.07f, 0.26f}, cornflower{0.16f, 0.20f, 0.66f}, lilac{0.48f, 0.34f, 0.66f},
    butter{0.86f, 0.62f, 0.20f};
const Vec3 green{0.10f, 0.17f, 0.045f}, fresh{0.22f, 0.30f, 0.07f}, deep{0.035f, 0.085f, 0.05f};

void Garden::hero_blossom(Vec3 at, Vec3 face, float radius, int petals, Vec3 tip, Vec3 root,
                          float open) {
    const Vec3 n = unit(face), a = unit(cross(n, Vec3{0, 1, 0.15f})), b = cross(n, a);
    for (int whorl = 0; whorl < 2; ++whorl)
        for (int i = 0; i < petals; ++i) {
            const float angle = 6.2831853f * (float(i) + 0.5f * float(whorl)) / float(petals) +
                                random(-0.06f, 0.06f);
            const float length = radius * (whorl ? 0.82f : 1.0f) * random(0.95f, 1.05f);
            const Vec3 out = std::cos(angle) * a + std::sin(angle) * b;
            const Vec3 along = unit(out + n * (whorl ? 0.34f : 0.10f) + n * random(-0.06f, 0.06f));
            const Vec3 across = unit(cross(n, out) + n * random(-0.22f, 0.22f));
            Primitive& p = patch(at + along * (0.52f * length) + n * (0.015f * float(whorl)),
                                 across * (length * 0.36f), along * (0.5f * length), petal_outline,
                                 petal_texture, open);
            p.paint.color = {tip * random(0.92f, 1.06f), root};
            p.paint.number[0] = 0.62f;
        }
    Primitive& middle = patch(at + n * (0.11f * radius), a * (0.23f * radius), b * (0.23f * radius),
                              nullptr, stamens_texture, open);
    middle.paint.color = {Vec3{0.92f, 0.55f, 0.06f}, Vec3{0.30f, 0.10f, 0.02f}};
}

void Garden::butterfly(Vec3 at, Vec3 ahead, Vec3 up, float size, float lift, float beat,
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

void Garden::ball(Vec3 at, float radius, int pattern, Vec3 glaze, Vec3 mark, float turn,
                  Vec3 motion) {
    Primitive p;
    p.origin = at, p.radius = radius, p.texture = ball_texture;
    p.origin_motion = motion;
    p.paint.color = {glaze, mark};
    p.paint.number = {float(pattern), turn};
    p.paint.light = {0.9f, 0.9f, 0.9f};
    scene_.primitives.push_back(p);
}

void Garden::far() {
    Primitive& field = patch({0, ground, field_z}, {field_extent, 0, 0}, {0, 0, field_extent},
                             nullptr, ground_texture);
    field.square = true;
    field.paint.light = {1, 1, 1};
    // Two ranges of hills and a line of trees.
    const struct {
        float z, height, base;
        Vec3 crest, foot;
        float hills, rough, phase;
    } ranges[] = {
        {900, 50, -6, {0.52f, 0.36f, 0.38f}, {0.95f, 0.58f, 0.40f}, 3, 0, 3.3f},
        {420, 22, -1, {0.22f, 0.20f, 0.23f}, {0.62f, 0.40f, 0.30f}, 4, 0, 8.1f},
        {80, 5.2f, 0.3f, {0.055f, 0.085f, 0.075f}, {0.26f, 0.20f, 0.14f}, 6, 0.35f, 1.7f}};
    for (const auto& r : ranges) {
        Primitive& p = patch({0, r.base - 0.2f * r.height, r.z}, {r.z * 1.2f, 0, 0},
                             {0, -r.height, 0}, hills_outline, hills_texture);
        p.square = true;
        p.paint.color = {r.crest, r.foot};
        p.paint.number = {r.hills, r.rough, r.phase};
        p.paint.light = {1, 1, 1};
    }
}

// Leaves in a rounded heap, dark within and below, sunlit above; lights hang among them.
void Garden::hedge(Vec3 middle, Vec3 extent, int leaves, int lights) {
    for (int i = 0; i < leaves; ++i) {
        Vec3 d;
        do d = {random(-1, 1), random(-1, 1), random(-1, 1)};
        while (dot(d, d) > 1);
        const float shell = std::sqrt(dot(d, d)),
                    open =
                        0.18f + 0.85f * shell * shell * (0.55f - 0.45f * d.y) * (1 - 0.25f * d.x);
        const float length = random(0.32f, 0.62f);
        Primitive& p =
            leaf(middle + d * extent, {random(-1, 1), random(-1.1f, 0.5f), random(-0.6f, 0.6f)},
                 length, length * random(0.4f, 0.6f), random(-1, 1),
                 lerp(deep, random_color({green, fresh, green}), 0.3f + 0.7f * shell), open);
        sway(p, {random(-0.03f, 0.05f), random(-0.02f, 0.02f), 0});
    }
    // What is behind the leaves stays dark.
    Primitive& core = patch(middle + Vec3{0, 0.1f, extent.z * 0.2f}, {extent.x * 0.8f, 0, 0},
                            {0, extent.y * 0.82f, 0}, nullptr, plain);
    core.paint.color[0] = {0.018f, 0.03f, 0.022f};
    core.paint.light = {0.6f, 0.6f, 0.6f};
    for (int i = 0; i < lights; ++i) {
        const Vec3 d{random(-0.95f, 0.95f), random(-0.95f, 0.7f), -1};
        const float k = std::sqrt(std::max(0.0f, 1 - 0.8f * (d.x * d.x + d.y * d.y)));
        light(middle + Vec3{d.x * extent.x, d.y * extent.y, -k * extent.z - 0.1f},
              random(0.024f, 0.042f),
              random_color({{30, 17, 6}, {34, 21, 9}, {28, 12, 5}, {14, 17, 24}}));
    }
}

void Garden::lanterns() {
    const Vec3 warm[] = {{2.6f, 1.25f, 0.42f}, {2.3f, 0.75f, 0.40f}, {2.5f, 1.55f, 0.75f}};
    for (int i = 0; i < 8; ++i) {  // from the left, near, into the distance
        const float s = float(i) / 7, sag = 4 * s * (1 - s);
        const Vec3 at{-4.6f + 5.6f * s + 0.9f * s * s, -2.0f + 0.15f * s + 0.42f * sag,
                      10.5f + 15 * s};
        Primitive p;
        p.origin = at, p.radius = 0.27f, p.texture = lantern_texture;
        p.paint.color[0] = warm[i % 3];
        p.paint.number[0] = 4;
        p.origin_motion = {random(-0.05f, 0.09f), 0, 0};
        scene_.primitives.push_back(p);
    }
    for (int i = 0; i < 46; ++i) {  // small bulbs on strings from hedge to hedge
        const int string = i / 23;
        const float s = (float(i % 23) + random(0.2f, 0.8f)) / 23, sag = 4 * s * (1 - s);
        const Vec3 at = string ? Vec3{5.2f - 9.5f * s, -2.35f + 1.15f * sag, 13 + 9 * s}
                               : Vec3{-6.5f + 13 * s, -2.1f + 0.85f * sag, 17 + 3 * s};
        light(at, random(0.03f, 0.045f), random_color({{30, 18, 7}, {36, 24, 11}}));
    }
}

void Garden::meadow() {
    for (int i = 0; i < 420; ++i) {
        const float z = 3.4f + 9 * std::pow(random(0, 1), 1.3f), side = chance(0.5f) ? -1.0f : 1.0f;
        const float x =
            path_middle(z) + side * (path_half + 0.05f + 3.2f * random(0, 1) * random(0.15f, 1));
        const float length = random(0.18f, 0.55f) * (z < 4.3f ? 0.7f : 1.0f);
        Primitive& p =
            blade({x, ground + 0.02f, z}, random(-0.5f, 0.5f), length, 0.05f,
                  random_color({green, fresh, {0.26f, 0.28f, 0.08f}, {0.12f, 0.20f, 0.09f}}),
                  random(0.6f, 1.1f));
        sway(p, {random(0.0f, 0.10f), 0, 0});
    }
    // Small flowers in the grass.
    for (int i = 0; i < 110; ++i) {
        const float z = random(4.6f, 13), side = chance(0.45f) ? -1.0f : 1.0f;
        const float x = path_middle(z) +
                        side * (path_half + 0.15f + random(0, 1) * random(0, 1) * 4.5f),
                    height = random(0.2f, 0.5f);
        const Vec3 top{x + random(-0.05f, 0.05f), ground - height, z};
        stem({x, ground, z}, top, 0.014f, green, 0.8f);
        blossom(top, {random(-0.5f, 0.3f), random(-1.2f, -0.3f), -1}, random(0.055f, 0.10f),
                chance(0.5f) ? 5 : 8, random_color({lilac, white, butter, cornflower, pink}), lilac,
                random(0.8f, 1.15f));
    }
}

void Garden::flowers() {
    const struct {
        float x, y, z, radius;
        Vec3 rim, throat;
        int petals;
    } cosmos[] = {{0.62f, 0.22f, 6.25f, 0.25f, white, {0.75f, 0.45f, 0.5f}, 8},
                  {2.55f, -0.12f, 6.5f, 0.27f, pink, plum, 8},
                  {1.02f, 0.62f, 5.75f, 0.20f, coral, {0.7f, 0.35f, 0.1f}, 8},
                  {2.18f, 0.52f, 5.9f, 0.24f, white, {0.8f, 0.5f, 0.55f}, 8},
                  {1.98f, -0.62f, 7.4f, 0.26f, lilac, plum, 8},
                  {0.98f, -0.42f, 7.2f, 0.24f, coral, plum, 8},
                  {2.95f, 0.40f, 6.9f, 0.26f, coral, plum, 8},
                  {1.32f, 0.02f, 6.9f, 0.23f, pink, plum, 8},
                  {2.62f, -0.95f, 8.6f, 0.27f, white, pink, 8},
                  {3.35f, -0.45f, 7.9f, 0.27f, pink, plum, 8},
                  {0.35f, 0.58f, 6.6f, 0.19f, lilac, plum, 8},
                  {1.72f, 0.72f, 5.5f, 0.18f, pink, plum, 8}};
    for (const auto& c : cosmos) {
        const Vec3 at{c.x, c.y, c.z};
        stem({c.x + random(-0.15f, 0.25f), ground, c.z + 0.1f}, at + Vec3{0, 0, 0.02f}, 0.022f,
             green, 0.9f);
        blossom(at, {random(-0.7f, 0.1f), random(-0.75f, 0.05f), -1}, c.radius, c.petals, c.rim,
                c.throat, 1.15f);
    }
    // The one the butterfly sits on.
    const Vec3 hero{1.62f, 0.10f, in_focus};
    stem({1.72f, ground, in_focus + 0.1f}, hero + Vec3{0.01f, 0.02f, 0.03f}, 0.03f, fresh, 0.9f);
    hero_blossom(hero, {-0.28f, -0.62f, -1}, 0.46f, 8, {0.86f, 0.30f, 0.42f}, {0.62f, 0.08f, 0.22f},
                 1.2f);
    // Feathery leaves between the stems.
    for (int i = 0; i < 120; ++i) {
        const float z = random(5.5f, 7.6f), x = random(0.3f, 3.4f);
        leaf({x, random(0.25f, 1.05f), z},
             {random(-1, 1), random(-1.2f, -0.1f), random(-0.5f, 0.3f)}, random(0.2f, 0.46f),
             random(0.03f, 0.09f), random(-0.8f, 0.8f), random_color({green, fresh, deep}),
             random(0.45f, 1.0f));
    }
}

void Garden::fliers() {
    const Wings monarch{{0.95f, 0.40f, 0.06f},
                        {0.88f, 0.24f, 0.03f},
                        {0.022f, 0.014f, 0.012f},
                        {0.92f, 0.86f, 0.78f}};
    const Wings blue{{0.10f, 0.42f, 0.86f},
                     {0.06f, 0.20f, 0.66f},
                     {0.012f, 0.014f, 0.03f},
                     {0.70f, 0.84f, 0.95f}};
    const Wings pale{
        {0.92f, 0.86f, 0.62f}, {0.90f, 0.78f, 0.42f}, {0.20f, 0.13f, 0.07f}, {0.95f, 0.9f, 0.8f}};
    butterfly({1.50f, -0.20f, 5.93f}, {-0.45f, -0.72f, -0.35f}, {-0.25f, -0.45f, -0.9f}, 0.66f,
              0.30f, 0.05f, {}, monarch, 1.0f);
    butterfly({-0.62f, -0.52f, 6.1f}, {0.55f, -0.55f, -0.1f}, {-0.2f, -0.5f, -0.85f}, 0.46f, 0.45f,
              0.9f, {0.11f, -0.06f, 0}, blue, 1.1f);
    butterfly({-2.15f, 0.05f, 7.3f}, {0.9f, -0.25f, 0.1f}, {0, -0.6f, -0.8f}, 0.42f, 0.5f, 1.3f,
              {0.52f, -0.14f, -0.1f}, pale, 1.1f);
    // Petals on the wind, some fast and some slow, turning.
    for (int i = 0; i < 44; ++i) {
        const float z = random(3.2f, 9.5f),
                    speed = (i % 3 == 0) ? random(0.35f, 0.7f) : random(0.03f, 0.16f);
        const Vec3 at{random(-0.52f, 0.5f) * z, random(-0.24f, 0.12f) * z, z};
        const Vec3 d{random(-1, 1), random(-1, 1), random(-0.6f, 0.6f)};
        Primitive& p = shoot(at, d, random(0.09f, 0.15f), random(0.07f, 0.10f), random(-1.2f, 1.2f),
                             petal_outline, petal_texture, 1.25f);
        p.paint.color = {random_color({pink, coral, white, pink}), pink};
        p.paint.number[0] = 0.6f;
        p.origin_motion =
            Vec3{random(0.7f, 1.1f), random(0.12f, 0.55f), random(-0.3f, 0.2f)} * speed;
        p.side_a_motion = Vec3{0, random(-0.03f, 0.03f), random(-0.04f, 0.04f)};
    }
    // Seeds afloat in the light.
    for (int i = 0; i < 60; ++i) {
        const float z = random(2.6f, 11);
        Primitive& p =
            light({random(-0.5f, 0.5f) * z, random(-0.22f, 0.2f) * z, z}, random(0.006f, 0.013f),
                  random_color({{7, 4.6f, 2.4f}, {5, 3.6f, 2.2f}}));
        p.origin_motion = {random(-0.02f, 0.09f), random(-0.05f, 0.03f), 0};
    }
    ball({-1.42f, ground - 0.37f, 6.15f}, 0.37f, 0, {0.62f, 0.52f, 0.40f}, {0.05f, 0.19f, 0.24f},
         0.5f, {});
    ball({-0.72f, ground - 0.21f, 5.45f}, 0.21f, 1, {0.05f, 0.16f, 0.33f}, {0.80f, 0.68f, 0.50f},
         -0.4f, {0.30f, 0, -0.10f});
}

void Garden::close() {
    // A branch from the upper right.
    for (int i = 0; i < 26; ++i) {
        const float s = float(i) / 26;
        const Vec3 at{1.20f - 0.62f * s + random(-0.05f, 0.05f),
                      -0.62f + 0.20f * s * s + random(-0.06f, 0.06f),
                      2.25f + random(-0.25f, 0.35f)};
        Primitive& p = leaf(at, {random(-0.9f, 0.2f), random(-0.1f, 1.0f), random(-0.4f, 0.4f)},
                            random(0.16f, 0.26f), random(0.07f, 0.11f), random(-0.7f, 0.7f),
                            random_color({deep, green, fresh}), random(0.4f, 1.0f));
        sway(p, {random(-0.004f, 0.014f), random(0, 0.008f), 0});
    }
    // Blossoms and blades at the lower left.
    const struct {
        float x, y, z, radius;
        Vec3 rim, throat;
    } near_ones[] = {{-0.98f, 0.46f, 2.30f, 0.155f, coral, butter},
                     {-1.22f, 0.16f, 2.75f, 0.15f, pink, plum},
                     {-0.66f, 0.72f, 2.15f, 0.12f, butter, coral}};
    for (const auto& f : near_ones) {
        stem({f.x - 0.04f, 1.0f, f.z + 0.02f}, {f.x, f.y, f.z + 0.01f}, 0.012f, green, 0.7f);
        blossom({f.x, f.y, f.z}, {0.3f, -0.45f, -1}, f.radius, 8, f.rim, f.throat, 1.0f);
    }
    for (int i = 0; i < 46; ++i) {
        const float z = random(1.9f, 3.0f), side = chance(0.7f) ? -1.0f : 1.0f;
        Primitive& p = blade(
            {side * random(0.42f, 0.54f) * z + (side < 0 ? random(0, 0.35f) : random(-0.1f, 0.1f)),
             0.40f * z, z},
            random(-0.35f, 0.35f), random(0.18f, 0.5f), 0.028f, random_color({green, fresh, deep}),
            random(0.5f, 0.95f));
        sway(p, {random(0.0f, 0.03f), 0, 0});
    }
}

void Garden::plant() {
    far();
    hedge({-5.6f, -0.15f, 11.5f}, {2.9f, 1.6f, 1.3f}, 340, 26);
    hedge({5.9f, -0.45f, 11.0f}, {2.9f, 1.9f, 1.3f}, 340, 26);
    hedge({-3.3f, 0.55f, 8.2f}, {0.9f, 0.65f, 0.6f}, 110, 8);
    lanterns();
    meadow();
    flowers();
    fliers();
    close();
}

}  // namespace

Scene garden_scene(const AnalyticOptions& o) {
    Scene scene;
    scene.camera = {.scale = 1.744f * float(o.height),
                    .center_x = 0.5f * float(o.width),
                    .center_y = 0.4f * float(o.height),
                    .lens_radius = 0.13f * o.aperture,
                    .focus = in_focus};
    scene.sky = dusk_sky;
    Garden(scene).plant();
    for (Primitive& p : scene.primitives) {
        p.origin_motion = p.origin_motion * o.shutter;
        p.side_a_motion = p.side_a_motion * o.shutter;
        p.side_b_motion = p.side_b_motion * o.shutter;
    }
    return scene;
}

}  // namespace weft::analytic
