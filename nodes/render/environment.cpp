#include "render/environment.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/error.h"
#include "render/bsdf_sample.h"

namespace weft::render {
namespace {

// Where in sums (n + 1, from 0 to 1) a number falls, and how far into that step.
struct Place {
    size_t index;
    float part;
};
Place place_of(const float* sums, size_t n, float number) {
    size_t i = size_t(std::upper_bound(sums, sums + n + 1, number) - sums);
    i = std::clamp<size_t>(i, 1, n) - 1;
    const float step = sums[i + 1] - sums[i];
    return {i, step > 0 ? std::clamp((number - sums[i]) / step, 0.0f, 0x1.fffffep-1f) : 0.5f};
}

}  // namespace

EnvironmentLight::EnvironmentLight(const Environment& e)
    : present_(e.present()), visible_(e.visible), radiance_(e.radiance), mean_(e.radiance) {
    if (!present_ || !e.map) return;
    map_ = e.map;
    width_ = map_->width(), height_ = map_->height();
    sine_ = std::sin(e.rotation), cosine_ = std::cos(e.rotation);
    if (width_ < 1 || height_ < 1 || (map_->channels() != 1 && map_->channels() < 3))
        throw Error(
            fmt::format("the environment map is {} x {} pixels with {} channels; expected R G B",
                        width_, height_, map_->channels()));
    const size_t w = size_t(width_), h = size_t(height_);
    std::vector<float> light(w * h);
    for (size_t y = 0; y < h; ++y)
        for (size_t x = 0; x < w; ++x) {
            const Vec3 c = texel(int(x), int(y));
            const float l = largest(c * e.radiance);
            if (!std::isfinite(l))
                throw Error(
                    fmt::format("the environment map is not finite at pixel ({}, {})", x, y));
            light[y * w + x] = std::max(l, 0.0f);
        }
    rows_.assign(h + 1, 0);
    columns_.assign(h * (w + 1), 0);
    double all = 0, area = 0;
    Vec3 mean;
    std::vector<double> row_sums(h);
    for (size_t y = 0; y < h; ++y) {
        const float sine = std::sin(pi * (float(y) + 0.5f) / float(h));
        double sum = 0;
        float* to = &columns_[y * (w + 1)];
        std::vector<double> sums(w + 1, 0);
        for (size_t x = 0; x < w; ++x) {
            double weight = 0;
            for (size_t j = y > 0 ? y - 1 : 0; j <= std::min(y + 1, h - 1); ++j)
                for (size_t i = 0; i < 3; ++i) weight += double(light[j * w + (x + w + i - 1) % w]);
            sum += weight * double(sine);
            sums[x + 1] = sum;
            mean += texel(int(x), int(y)) * (sine / float(w));
        }
        area += double(sine);
        for (size_t x = 0; x <= w; ++x)
            to[x] = sum > 0 ? float(sums[x] / sum) : float(x) / float(w);
        to[w] = 1;
        row_sums[y] = sum;
        all += sum;
    }
    mean_ = mean * float(1 / area) * e.radiance;
    present_ = all > 0;
    if (!present_) return;
    double before = 0;
    for (size_t y = 0; y < h; ++y) {
        before += row_sums[y];
        rows_[y + 1] = float(before / all);
    }
    rows_[h] = 1;
}

Vec3 EnvironmentLight::texel(int x, int y) const {
    const float* p = map_->at((x % width_ + width_) % width_, std::clamp(y, 0, height_ - 1));
    return map_->channels() < 3 ? Vec3{p[0], p[0], p[0]} : Vec3{p[0], p[1], p[2]};
}

Vec3 EnvironmentLight::from_map(float u, float v) const {
    const float x = u * float(width_) - 0.5f, y = v * float(height_) - 0.5f;
    const float fx = std::floor(x), fy = std::floor(y), sx = x - fx, sy = y - fy;
    const int ix = int(fx), iy = int(fy);
    return lerp(lerp(texel(ix, iy), texel(ix + 1, iy), sx),
                lerp(texel(ix, iy + 1), texel(ix + 1, iy + 1), sx), sy);
}

Vec3 EnvironmentLight::radiance(Vec3 d) const {
    if (!map_) return radiance_;
    const float x = cosine_ * d.x - sine_ * d.z, z = sine_ * d.x + cosine_ * d.z;
    const float u = 0.5f + std::atan2(x, -z) / (2 * pi);
    const float v = std::acos(std::clamp(d.y, -1.0f, 1.0f)) / pi;
    return from_map(u, v) * radiance_;
}

EnvironmentLight::Direction EnvironmentLight::sample(float a, float b) const {
    if (!map_) {
        const float y = 1 - 2 * a, r = std::sqrt(std::max(0.0f, 1 - y * y));
        return {{r * std::cos(2 * pi * b), y, r * std::sin(2 * pi * b)}, 1 / (4 * pi)};
    }
    const Place row = place_of(rows_.data(), size_t(height_), b);
    const float* sums = &columns_[row.index * size_t(width_ + 1)];
    const Place column = place_of(sums, size_t(width_), a);
    const float u = (float(column.index) + column.part) / float(width_);
    const float v = (float(row.index) + row.part) / float(height_);
    const float phi = 2 * pi * (u - 0.5f), theta = pi * v, sine = std::sin(theta);
    const float x = sine * std::sin(phi), z = -sine * std::cos(phi);
    Direction out;
    out.direction = {cosine_ * x + sine_ * z, std::cos(theta), cosine_ * z - sine_ * x};
    const float density = (rows_[row.index + 1] - rows_[row.index]) * float(height_) *
                          (sums[column.index + 1] - sums[column.index]) * float(width_);
    out.density = sine > 1e-6f ? density / (2 * pi * pi * sine) : 0;
    return out;
}

float EnvironmentLight::density(Vec3 d) const {
    if (!map_) return 1 / (4 * pi);
    const float x = cosine_ * d.x - sine_ * d.z, z = sine_ * d.x + cosine_ * d.z;
    const float u = 0.5f + std::atan2(x, -z) / (2 * pi);
    const float theta = std::acos(std::clamp(d.y, -1.0f, 1.0f)), sine = std::sin(theta);
    if (!(sine > 1e-6f)) return 0;
    const size_t column = std::min(size_t(std::max(u, 0.0f) * float(width_)), size_t(width_) - 1);
    const size_t row = std::min(size_t(theta / pi * float(height_)), size_t(height_) - 1);
    const float* sums = &columns_[row * size_t(width_ + 1)];
    return (rows_[row + 1] - rows_[row]) * float(height_) * (sums[column + 1] - sums[column]) *
           float(width_) / (2 * pi * pi * sine);
}

}  // namespace weft::render
