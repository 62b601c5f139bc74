#include "render/foliage.h"

#include <algorithm>
#include <cmath>

#include "render/shapes.h"

namespace weft {
namespace {

constexpr int across = 4, along = 10;

template <class Point>
Mesh strip(Point&& point) {
    Mesh mesh;
    for (int j = 0; j <= along; ++j)
        for (int i = 0; i <= across; ++i) {
            const float t = float(j) / along, s = 2 * float(i) / across - 1;
            mesh.positions.push_back(point(t, s));
            mesh.uv.push_back({t, 0.5f + 0.5f * s});
        }
    for (int j = 0; j < along; ++j)
        for (int i = 0; i < across; ++i) {
            const auto a = std::uint32_t(j * (across + 1) + i), b = a + across + 1;
            mesh.triangles.push_back({a, a + 1, b + 1});
            mesh.triangles.push_back({a, b + 1, b});
        }
    make_normals(mesh);
    return mesh;
}

float smooth(float low, float high, float x) {
    const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

}  // namespace

Mesh leaf_mesh(float width, float fold, float bend) {
    return strip([&](float t, float s) {
        // A stalk for the first sixth, then a blade that is widest before its middle.
        const float b = std::max(0.0f, (t - 0.16f) / 0.84f);
        const float half = std::max(
            0.008f * (1 - t), 0.5f * width * std::pow(std::sin(pi * std::pow(b, 0.75f)), 0.8f));
        return Vec3{t, std::fabs(s) * half * fold + bend * t * t, s * half};
    });
}

Mesh wing_mesh() {
    // Two lobes in one outline: the fore wing reaches ahead and out, the hind wing back.
    return strip([](float t, float s) {
        const float front = -0.30f - 0.42f * t + 0.55f * t * t * t * t;
        const float back = 0.25f + 0.65f * t - 1.0f * t * t * t * t;
        const float notch = 0.22f * smooth(0.55f, 1, t) * std::exp(-12 * (s - 0.1f) * (s - 0.1f));
        return Vec3{t * (1 - notch), 0.05f * std::sin(pi * t),
                    0.5f * (front + back) + 0.5f * s * (back - front)};
    });
}

int leaf_texture(SceneBuilder& build) {
    return build.texture("leaf", 256, 128, [](float u, float v) {
        const float s = std::fabs(2 * v - 1);
        const float ribs = std::fabs(std::remainder((u - 0.5f * s) * 9, 1.0f));
        const float vein = std::max(smooth(0.05f, 0.0f, s), 0.7f * smooth(0.10f, 0.0f, ribs));
        const float spots = noise(u * 12, v * 6, 7, 4);
        const float value = 0.62f + 0.25f * spots + 0.28f * vein - 0.18f * smooth(0.5f, 1, s);
        return Vec3{value, value, value * (0.9f + 0.1f * vein)};
    });
}

int wing_texture(SceneBuilder& build, const std::string& name, Vec3 color, Vec3 spots) {
    return build.texture(name, 256, 256, [=](float u, float v) {
        // Veins fan out from the root; the margin is dark with a row of light spots.
        const float angle = std::atan2(v - 0.5f, u + 0.05f);
        const float veins = std::fabs(std::remainder(angle * 5, 1.0f));
        const float edge = std::max({u, std::fabs(2 * v - 1) * 0.97f});
        float dark = std::max(smooth(0.80f, 0.86f, edge), 0.85f * smooth(0.09f, 0.04f, veins));
        dark = std::max(dark, smooth(0.12f, 0.04f, u));
        const float along_edge = u > std::fabs(2 * v - 1) ? v : u;
        const float row = std::remainder(along_edge * 11, 1.0f) / 11;
        const float dot = smooth(0.030f, 0.018f, std::hypot(row, edge - 0.92f));
        const Vec3 base = lerp(color * (1.1f - 0.5f * u), Vec3{0.02f, 0.015f, 0.012f}, dark);
        return lerp(base, spots, dot);
    });
}

int bark_texture(SceneBuilder& build, std::uint64_t seed) {
    return build.texture("bark", 256, 512, [=](float u, float v) {
        const float ridge = noise(u * 16, v * 8, seed, 5, 8);
        const float deep = std::fabs(2 * ridge - 1);
        return lerp(Vec3{0.035f, 0.025f, 0.02f}, Vec3{0.30f, 0.23f, 0.17f},
                    smooth(0.02f, 0.5f, deep));
    });
}

}  // namespace weft
