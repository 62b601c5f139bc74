#include "samples/analytic_paint.h"

namespace weft::analytic {
namespace {

float lattice(int x, int y) {
    std::uint32_t h = std::uint32_t(x) * 0x85ebca6bu ^ std::uint32_t(y) * 0xc2b2ae35u;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return float((h ^ h >> 15) >> 8) * 0x1p-24f;
}

// cos(n theta) of the direction (a, b), by powers of a + ib.
float cos_of_multiple(float a, float b, int n) {
    const float length2 = a * a + b * b;
    if (length2 == 0) return 1;
    const float inverse = 1 / std::sqrt(length2), x = a * inverse, y = b * inverse;
    float re = 1, im = 0;
    for (int i = 0; i < n; ++i) {
        const float next = re * x - im * y;
        im = re * y + im * x;
        re = next;
    }
    return re;
}

float fraction(float x) {
    return x - std::floor(x);
}
// Distance to the nearest whole number.
float to_line(float x) {
    return std::fabs(x - std::round(x));
}

Surface lit(const Paint& paint, Vec3 albedo) {
    return {albedo, albedo * paint.light};
}

// Light of a clear dusk on something round: a warm low sun behind on the left, cool sky above, the
// ground's green from below.
Vec3 dusk_light(Vec3 n) {
    const float up = 0.5f - 0.5f * n.y;
    const float sun = std::max(0.0f, dot(n, Vec3{-0.62f, -0.42f, 0.35f}) + 0.12f);
    const float front = std::max(0.0f, -n.z);
    return Vec3{0.30f, 0.36f, 0.48f} * (up * up) + Vec3{2.3f, 1.45f, 0.75f} * sun +
           Vec3{0.10f, 0.12f, 0.06f} * (1 - up) + Vec3{0.32f, 0.28f, 0.27f} * front;
}

// How far inside the wing a point lies (below 0: outside). x runs outward from the body, y ahead.
float forewing_depth(float x, float y) {
    const float ahead = 0.24f + 0.76f * std::sqrt(std::max(x, 0.0f)) * (0.55f + 0.45f * x) - y;
    const float behind = y - (0.02f + 0.16f * x * x);
    const float s = (y - 0.55f) / 0.55f;
    const float out = 0.90f + 0.08f * std::max(s, 0.0f) - 0.12f * (1 - std::min(s * s, 1.0f)) - x;
    return std::min(std::min(ahead, behind), out);
}
float hindwing_depth(float x, float y) {
    const float dx = (x - 0.40f) / 0.56f, dy = (y - 0.50f) / 0.50f,
                wave = 0.035f * std::cos(14 * y + 3 * x);
    const float round = 1 + wave - std::sqrt(dx * dx + dy * dy);
    return std::min(round * 0.5f, x + 0.05f);
}

// Scales of a butterfly: warm field, dark veins from the root, a dark margin with two rows of
// spots.
Surface wing(const Paint& paint, float x, float y, float depth, float root_y, float veins) {
    const float distance = std::sqrt(x * x + (y - root_y) * (y - root_y));
    const float angle = (y - root_y) / (x + 0.18f) * veins + 0.35f * x;
    Vec3 c = lerp(paint.color[0], paint.color[1], smooth(0.25f, 0.95f, distance));
    c = c * (0.86f + 0.28f * noise(x * 42, y * 42));
    const float vein = to_line(angle) * (distance + 0.1f) / veins;
    c = lerp(paint.color[2], c, smooth(0.006f, 0.017f, vein));
    const float edge = smooth(0.135f, 0.105f, depth);
    c = lerp(c, paint.color[2], edge);
    const float along = fraction(angle * 1.0f + 0.5f) - 0.5f;
    const float unit_along = (distance + 0.1f) / veins;
    const float row = std::min(std::fabs(depth - 0.040f), std::fabs(depth - 0.083f));
    const float spot = along * unit_along * along * unit_along + row * row;
    c = lerp(c, paint.color[3], edge * smooth(0.00038f, 0.00022f, spot));
    return lit(paint, c);
}

}  // namespace

float noise(float x, float y) {
    const int ix = floor_of(x), iy = floor_of(y);
    float u = x - float(ix), v = y - float(iy);
    u = u * u * (3 - 2 * u), v = v * v * (3 - 2 * v);
    const float a = lattice(ix, iy), b = lattice(ix + 1, iy), c = lattice(ix, iy + 1);
    const float top = a + (b - a) * u, bottom = c + (lattice(ix + 1, iy + 1) - c) * u;
    return top + (bottom - top) * v;
}

bool leaf_outline(const Paint&, float a, float b) {
    return std::fabs(a) <= (1 - b * b) * (0.95f - 0.28f * b);
}

bool blade_outline(const Paint& paint, float a, float b) {
    const float s = 0.5f * (b + 1), middle = paint.number[0] * (s * s - 0.5f);
    return std::fabs(a - middle) <= paint.number[1] * (1 - s * std::sqrt(s));
}

bool blossom_outline(const Paint& paint, float a, float b) {
    const float c = cos_of_multiple(a, b, int(paint.number[0]));
    float notch = 0.5f - 0.5f * c;
    notch *= notch;
    const float edge =
        1 - paint.number[1] * notch * notch - 0.05f * (c > 0.9f ? (c - 0.9f) * 10 : 0);
    return a * a + b * b <= edge * edge;
}

bool petal_outline(const Paint& paint, float a, float b) {
    const float s = 0.5f * (b + 1);  // widest at the upper third, a small cleft at the tip
    const float width = std::sqrt(s) * (1 - s * s * s * paint.number[0]) * (1.04f - 0.30f * s);
    return std::fabs(a) <= width && s < 0.985f - 0.06f * std::max(0.0f, 1 - 5 * std::fabs(a));
}

bool forewing_outline(const Paint&, float a, float b) {
    return forewing_depth(0.5f * (a + 1), 0.5f * (b + 1)) > 0;
}
bool hindwing_outline(const Paint&, float a, float b) {
    return hindwing_depth(0.5f * (a + 1), 0.5f * (b + 1)) > 0;
}

bool hills_outline(const Paint& paint, float a, float b) {
    const float x = (a + 1) * paint.number[0] + paint.number[2];
    float crest = noise(x, 0.5f) + 0.5f * noise(2.1f * x, 7.5f);
    if (paint.number[1] > 0)
        crest += paint.number[1] *
                 (noise(9 * x, 3.5f) + 0.6f * noise(23 * x, 9.5f) + 0.4f * noise(57 * x, 1.5f));
    return b <= crest - 0.6f - paint.number[1];
}

bool ring_outline(const Paint& paint, float a, float b) {
    return a * a + b * b >= paint.number[0] * paint.number[0];
}

Surface plain(const Paint& paint, float, float, Vec3) {
    return lit(paint, paint.color[0]);
}

Surface leaf_texture(const Paint& paint, float a, float b, Vec3) {
    const float rib = std::fabs(a);
    const float side = to_line((b - 0.55f * rib) * 5.0f + paint.number[0]) * 0.2f;
    const float vein = std::max(smooth(0.055f, 0.02f, rib), 0.7f * smooth(0.024f, 0.006f, side));
    Vec3 c = lerp(paint.color[0], paint.color[1], vein);
    c = c * (0.72f + 0.36f * noise(a * 9 + paint.number[0] * 17, b * 13) + 0.18f * b);
    return lit(paint, c);
}

Surface blade_texture(const Paint& paint, float a, float b, Vec3) {
    const float s = 0.5f * (b + 1);
    Vec3 c = lerp(paint.color[0], paint.color[1], s);
    c = c * (0.85f + 0.3f * noise(a * 14, b * 3 + paint.number[0] * 31));
    return lit(paint, c);
}

Surface blossom_texture(const Paint& paint, float a, float b, Vec3) {
    const float r = std::sqrt(a * a + b * b);
    const int petals = int(paint.number[0]);
    const float c1 = cos_of_multiple(a, b, petals);
    if (r < 0.21f + 0.015f * c1) {
        const float grain = noise(a * 46, b * 46);
        return lit(paint, paint.color[2] * (0.55f + 0.9f * grain) * (1.15f - 1.6f * r));
    }
    const float lines = cos_of_multiple(a, b, petals * 4);
    Vec3 c = lerp(paint.color[1], paint.color[0], smooth(0.2f, 0.62f, r));
    c = c * (0.93f + 0.07f * lines * smooth(0.95f, 0.3f, r));
    c = c * (1 - 0.30f * smooth(-0.35f, -1.0f, c1)) * (0.88f + 0.12f * smooth(0.3f, 1.0f, r));
    return lit(paint, c);
}

Surface petal_texture(const Paint& paint, float a, float b, Vec3) {
    const float s = 0.5f * (b + 1);
    Vec3 c = lerp(paint.color[1], paint.color[0], smooth(0.05f, 0.7f, s));
    const float fan = a / (0.25f + 0.75f * s);
    const float line = to_line(fan * 4.5f);
    c = c * (0.90f + 0.10f * smooth(0.02f, 0.22f, line)) * (0.92f + 0.16f * noise(fan * 11, s * 5));
    c = c * (1 - 0.22f * smooth(0.45f, 1.0f, std::fabs(fan)));
    return lit(paint, c);
}

Surface stamens_texture(const Paint& paint, float a, float b, Vec3) {
    // Florets on a golden spiral look like a fine, even grain.
    const float r = std::sqrt(a * a + b * b);
    const float grain = noise(a * 17, b * 17), fine = noise(a * 37 + 5, b * 37);
    const Vec3 c =
        lerp(paint.color[1], paint.color[0], smooth(0.25f, 0.85f, r + 0.35f * (grain - 0.5f)));
    return lit(paint, c * (0.5f + 0.9f * fine));
}

Surface forewing_texture(const Paint& paint, float a, float b, Vec3) {
    const float x = 0.5f * (a + 1), y = 0.5f * (b + 1);
    return wing(paint, x, y, forewing_depth(x, y), 0.12f, 5.5f);
}
Surface hindwing_texture(const Paint& paint, float a, float b, Vec3) {
    const float x = 0.5f * (a + 1), y = 0.5f * (b + 1);
    return wing(paint, x, y, hindwing_depth(x, y), 0.80f, 4.5f);
}

Surface glow_texture(const Paint& paint, float, float, Vec3) {
    return {{}, paint.color[0]};
}

Surface lantern_texture(const Paint& paint, float, float, Vec3 n) {
    const float rib = to_line(n.y * paint.number[0]);
    const float paper = 0.72f + 0.28f * smooth(0.04f, 0.2f, rib);
    const float heart = 0.55f + 0.45f * (1 - n.y * n.y) + 0.18f * n.y;
    const Vec3 radiance = paint.color[0] * (paper * heart);
    return {{0.8f, 0.7f, 0.6f}, radiance};
}

Surface ball_texture(const Paint& paint, float, float, Vec3 n) {
    const float turn = paint.number[1], c = std::cos(turn), s = std::sin(turn);
    const Vec3 m{c * n.x - s * n.y, s * n.x + c * n.y, n.z};
    const float around = std::atan2(m.z, m.x) * 0.15915494f,
                up = std::asin(std::clamp(m.y, -1.0f, 1.0f)) * 0.63661977f;
    float mark;
    if (paint.number[0] < 0.5f) {  // zigzag bands
        const float zigzag = to_line(around * 14) * 0.28f;
        mark = smooth(0.20f, 0.30f, to_line(up * 2.5f + zigzag));
        mark =
            std::max(mark, smooth(0.035f, 0.02f, std::fabs(to_line(up * 2.5f + zigzag) - 0.12f)));
    } else {  // rosettes in rows
        const float row = up * 4,
                    x = (fraction(around * 16 + 0.5f * float(floor_of(row))) - 0.5f) *
                        (1 - 0.6f * up * up),
                    y = fraction(row) - 0.5f, r = std::sqrt(x * x + y * y);
        mark = smooth(0.36f, 0.32f, r) * smooth(0.14f, 0.18f, r) + smooth(0.09f, 0.06f, r);
    }
    const Vec3 albedo =
        lerp(paint.color[0], paint.color[1], mark) * (0.94f + 0.12f * noise(around * 90, up * 45));
    Vec3 radiance = albedo * dusk_light(n) * paint.light;
    // The sky's bright strip in the glaze, painted on.
    const float gleam = dot(n, unit(Vec3{-0.50f, -0.62f, -0.60f}));
    radiance = radiance + Vec3{1.5f, 1.25f, 1.0f} * smooth(0.965f, 0.99f, gleam) +
               Vec3{0.16f, 0.14f, 0.14f} * smooth(0.80f, 0.97f, gleam);
    return {albedo, radiance};
}

Surface hills_texture(const Paint& paint, float a, float b, Vec3) {
    const float grain = noise(a * 160, b * 60) * 0.6f + noise(a * 47, b * 23) * 0.4f;
    const Vec3 c =
        lerp(paint.color[1], paint.color[0], smooth(-1.0f, 0.6f, b + 0.15f * (grain - 0.5f)));
    return lit(paint, c * (0.85f + 0.3f * grain));
}

}  // namespace weft::analytic
