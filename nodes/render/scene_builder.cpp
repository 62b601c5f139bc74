#include "render/scene_builder.h"

#include <algorithm>
#include <cmath>

#include "image/png_file.h"

namespace weft {
namespace {

float to_srgb(float linear) {
    linear = std::clamp(linear, 0.0f, 1.0f);
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

float lattice(int x, int y, std::uint64_t seed, int period) {
    if (period > 0) x = (x % period + period) % period, y = (y % period + period) % period;
    return unit_float(mix(seed + (std::uint64_t(std::uint32_t(x)) << 32 | std::uint32_t(y))));
}

}  // namespace

int SceneBuilder::texture(const std::string& name, int width, int height,
                          const std::function<Vec3(float u, float v)>& color) {
    Image image(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Vec3 c =
                color((float(x) + 0.5f) / float(width), (float(y) + 0.5f) / float(height));
            float* pixel = image.at(x, y);
            pixel[0] = to_srgb(c.x), pixel[1] = to_srgb(c.y), pixel[2] = to_srgb(c.z);
        }
    std::vector<std::string> warnings;
    TextureFile file;
    file.path = name + ".png";
    file.bytes = std::make_shared<const std::string>(encode_png(image, {}, warnings));
    scene.textures.push_back(std::move(file));
    return int(scene.textures.size()) - 1;
}

void SceneBuilder::sky(const std::function<Vec3(Vec3)>& radiance) {
    constexpr int width = 512, height = 256;
    auto map = std::make_shared<Image>(width, height, 3);
    map->color_space = scene.color_space;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            // The middle column is at -z, columns to the right of it turn towards +x.
            const float a = 2 * pi * ((float(x) + 0.5f) / width - 0.5f);
            const float b = pi * (float(y) + 0.5f) / height, r = std::sin(b);
            const Vec3 c = radiance({r * std::sin(a), std::cos(b), -r * std::cos(a)});
            float* pixel = map->at(x, y);
            pixel[0] = c.x, pixel[1] = c.y, pixel[2] = c.z;
        }
    scene.environment.map = std::move(map);
    scene.environment.radiance = {1, 1, 1};
}

Material diffuse(std::string name, Vec3 color) {
    Material m;
    m.name = std::move(name), m.kind = Material::Kind::diffuse, m.base_color = color;
    return m;
}

Material glossy(std::string name, Vec3 color, float roughness, float metallic) {
    Material m;
    m.name = std::move(name), m.base_color = color;
    m.roughness = roughness, m.metallic = metallic;
    return m;
}

Material conductor(std::string name, Vec3 color, float roughness) {
    Material m;
    m.name = std::move(name), m.kind = Material::Kind::conductor;
    m.base_color = color, m.roughness = roughness;
    return m;
}

Material glass(std::string name, float ior) {
    Material m;
    m.name = std::move(name), m.kind = Material::Kind::dielectric;
    m.base_color = {1, 1, 1}, m.roughness = 0, m.ior = ior;
    return m;
}

Vec3 Dice::direction(int place) const {
    const float z = (*this)(place, -1, 1), a = (*this)(place + 1, 0, 2 * pi);
    const float r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * std::cos(a), r * std::sin(a), z};
}

float noise(float x, float y, std::uint64_t seed, int octaves, int period) {
    float sum = 0, weight = 0.5f, total = 0;
    for (int i = 0; i < octaves; ++i) {
        const float fx = std::floor(x), fy = std::floor(y);
        const int ix = int(fx), iy = int(fy);
        float tx = x - fx, ty = y - fy;
        tx = tx * tx * (3 - 2 * tx), ty = ty * ty * (3 - 2 * ty);
        const float a = lattice(ix, iy, seed, period), b = lattice(ix + 1, iy, seed, period);
        const float c = lattice(ix, iy + 1, seed, period);
        const float d = lattice(ix + 1, iy + 1, seed, period);
        sum += weight * ((a + (b - a) * tx) * (1 - ty) + (c + (d - c) * tx) * ty);
        total += weight;
        weight *= 0.5f, x *= 2, y *= 2, period *= 2, seed = mix(seed);
    }
    return sum / total;
}

}  // namespace weft
