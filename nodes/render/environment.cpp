#include "render/environment.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/error.h"
#include "render/bsdf_sample.h"

namespace weft::render {
SampledSteps::SampledSteps(std::span<const double> weights) {
    const size_t n = weights.size();
    double all = 0, before = 0;
    for (const double w : weights) all += w;
    sums_.assign(n + 1, 0);
    for (size_t i = 0; i < n; ++i) {
        before += all > 0 ? weights[i] / all : 1 / double(n);
        sums_[i + 1] = float(std::min(before, 1.0));
    }
    sums_[n] = 1;
    // A start for each of n equal parts of [0, 1): the last step that begins before it.
    guide_.resize(n);
    size_t i = 0;
    for (size_t g = 0; g < n; ++g) {
        while (i + 1 < n && sums_[i + 1] <= float(g) / float(n)) ++i;
        guide_[g] = std::uint32_t(i);
    }
}

SampledSteps::Place SampledSteps::at(float number) const {
    const size_t n = size();
    size_t i = guide_[std::min(size_t(std::max(number, 0.0f) * float(n)), n - 1)];
    while (i > 0 && sums_[i] > number) --i;
    while (i + 1 < n && sums_[i + 1] <= number) ++i;
    const float step = sums_[i + 1] - sums_[i];
    return {i, step > 0 ? std::clamp((number - sums_[i]) / step, 0.0f, 0x1.fffffep-1f) : 0.5f};
}

EnvironmentLight::EnvironmentLight(const Environment& e)
    : present_(e.present()), visible_(e.visible), radiance_(e.radiance), mean_(e.radiance) {
    if (!present_ || !e.map) return;
    const Image& map = *e.map;
    width_ = map.width(), height_ = map.height();
    sine_ = std::sin(e.rotation), cosine_ = std::cos(e.rotation);
    if (width_ < 1 || height_ < 1 || (map.channels() != 1 && map.channels() < 3))
        throw Error(
            fmt::format("the environment map is {} x {} pixels with {} channels; expected R G B",
                        width_, height_, map.channels()));
    const size_t w = size_t(width_), h = size_t(height_);
    texels_.resize((w + 1) * h);
    std::vector<float> light(w * h);
    for (size_t y = 0; y < h; ++y)
        for (size_t x = 0; x <= w; ++x) {
            const float* p = map.at(int(x % w), int(y));
            const Vec3 c = map.channels() < 3 ? Vec3{p[0], p[0], p[0]} : Vec3{p[0], p[1], p[2]};
            texels_[y * (w + 1) + x] = c;
            const float l = largest(c * e.radiance);
            if (!std::isfinite(l))
                throw Error(
                    fmt::format("the environment map is not finite at pixel ({}, {})", x % w, y));
            if (x < w) light[y * w + x] = std::max(l, 0.0f);
        }
    double area = 0;
    Vec3 mean;
    std::vector<double> row_sums(h), weights(w);
    double all = 0;
    for (size_t y = 0; y < h; ++y) {
        const float sine = std::sin(pi * (float(y) + 0.5f) / float(h));
        double sum = 0;
        for (size_t x = 0; x < w; ++x) {
            weights[x] = 0;
            for (size_t j = y > 0 ? y - 1 : 0; j <= std::min(y + 1, h - 1); ++j)
                for (size_t i = 0; i < 3; ++i)
                    weights[x] += double(sine) * double(light[j * w + (x + w + i - 1) % w]);
            sum += weights[x];
            mean += texel(int(x), int(y)) * (sine / float(w));
        }
        area += double(sine);
        columns_.emplace_back(weights);
        row_sums[y] = sum;
        all += sum;
    }
    mean_ = mean * float(1 / area) * e.radiance;
    present_ = all > 0;
    rows_ = SampledSteps(row_sums);
}

Vec3 EnvironmentLight::from_map(float u, float v) const {
    const float x = u * float(width_) - 0.5f, y = v * float(height_) - 0.5f;
    const float fx = std::floor(x), fy = std::floor(y), sx = x - fx, sy = y - fy;
    const int ix = int(fx) < 0 ? width_ - 1 : std::min(int(fx), width_ - 1);
    const int iy = std::clamp(int(fy), 0, height_ - 1),
              next = std::clamp(int(fy) + 1, 0, height_ - 1);
    return lerp(lerp(texel(ix, iy), texel(ix + 1, iy), sx),
                lerp(texel(ix, next), texel(ix + 1, next), sx), sy);
}

Vec3 EnvironmentLight::radiance(Vec3 d) const {
    if (texels_.empty()) return radiance_;
    const float x = cosine_ * d.x - sine_ * d.z, z = sine_ * d.x + cosine_ * d.z;
    const float u = 0.5f + std::atan2(x, -z) / (2 * pi);
    const float v = std::acos(std::clamp(d.y, -1.0f, 1.0f)) / pi;
    return from_map(u, v) * radiance_;
}

EnvironmentLight::Direction EnvironmentLight::sample(float a, float b) const {
    if (texels_.empty()) {
        const float y = 1 - 2 * a, r = std::sqrt(std::max(0.0f, 1 - y * y));
        return {{r * std::cos(2 * pi * b), y, r * std::sin(2 * pi * b)}, 1 / (4 * pi)};
    }
    const SampledSteps::Place row = rows_.at(b), column = columns_[row.index].at(a);
    const float u = (float(column.index) + column.part) / float(width_);
    const float v = (float(row.index) + row.part) / float(height_);
    const float phi = 2 * pi * (u - 0.5f), theta = pi * v, sine = std::sin(theta);
    const float x = sine * std::sin(phi), z = -sine * std::cos(phi);
    Direction out;
    out.direction = {cosine_ * x + sine_ * z, std::cos(theta), cosine_ * z - sine_ * x};
    const float density = rows_.probability(row.index) * float(height_) *
                          columns_[row.index].probability(column.index) * float(width_);
    out.density = sine > 1e-6f ? density / (2 * pi * pi * sine) : 0;
    return out;
}

float EnvironmentLight::density(Vec3 d) const {
    if (texels_.empty()) return 1 / (4 * pi);
    const float x = cosine_ * d.x - sine_ * d.z, z = sine_ * d.x + cosine_ * d.z;
    const float u = 0.5f + std::atan2(x, -z) / (2 * pi);
    const float theta = std::acos(std::clamp(d.y, -1.0f, 1.0f)), sine = std::sin(theta);
    if (!(sine > 1e-6f)) return 0;
    const size_t column = std::min(size_t(std::max(u, 0.0f) * float(width_)), size_t(width_) - 1);
    const size_t row = std::min(size_t(theta / pi * float(height_)), size_t(height_) - 1);
    return rows_.probability(row) * float(height_) * columns_[row].probability(column) *
           float(width_) / (2 * pi * pi * sine);
}

}  // namespace weft::render
