#include "samples/analytic_garden_backdrop.h"

#include "samples/analytic_paint.h"

namespace weft::analytic {
namespace {

float length(float x, float y) {
    return std::sqrt(x * x + y * y);
}

// Where things stand on the ground that darken it: x, z, radius.
struct Footprint {
    float x, z, radius, strength;
};
constexpr Footprint footprints[] = {{-1.42f, 6.15f, 0.52f, 0.75f},
                                    {-0.72f, 5.45f, 0.30f, 0.7f},
                                    {1.55f, 6.3f, 1.25f, 0.6f},
                                    {-3.4f, 8.0f, 1.6f, 0.6f},
                                    {3.6f, 8.4f, 1.8f, 0.6f}};

Vec3 tile_color(float x, float z, Vec3 grass) {
    constexpr float size = 0.42f;
    const float s = x / size, t = z / size, cell_x = float(floor_of(s)),
                cell_z = float(floor_of(t));
    const float u = s - cell_x - 0.5f, v = t - cell_z - 0.5f;
    const Vec3 cream{0.62f, 0.55f, 0.45f}, teal{0.08f, 0.24f, 0.27f}, clay{0.50f, 0.19f, 0.11f};
    const float au = std::fabs(u), av = std::fabs(v), corner = length(0.5f - au, 0.5f - av),
                middle = length(u, v);
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

}  // namespace

float path_middle(float z) {
    return -0.75f + 0.035f * (z - 6) - 0.012f * (z - 6) * (z - 6) * smooth(0, 8, z - 6);
}

// Lawn with a tiled path, both lit by the evening; x and z from the patch's own coordinates.
Surface ground_texture(const Paint& paint, float a, float b, Vec3) {
    const float x = a * field_extent, z = field_z + b * field_extent;
    const float tuft = noise(x * 3.1f, z * 2.3f), fine = noise(x * 21, z * 13),
                broad = noise(x * 0.6f, z * 0.35f);
    Vec3 grass = lerp(Vec3{0.05f, 0.10f, 0.028f}, Vec3{0.22f, 0.27f, 0.065f},
                      0.45f * tuft + 0.3f * fine + 0.25f * broad);
    // Daisies.
    const float dx = x * 2.3f, dz = z * 1.5f, cx = float(floor_of(dx)), cz = float(floor_of(dz));
    const float px = 0.2f + 0.6f * noise(cx * 7.3f + 0.5f, cz * 3.1f),
                pz = 0.2f + 0.6f * noise(cx * 2.9f, cz * 8.7f + 0.5f);
    const float daisy = length(dx - cx - px, (dz - cz - pz) * 1.5f);
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

}  // namespace weft::analytic
