// Adaptive sampling and reconstruction of what was not made to suit them: a lamp that can be seen, beside what is black;
// fine things over many axes.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "adaptive/leaf_tree.h"
#include "adaptive/metrics.h"
#include "adaptive/sampler_function.h"
#include "adaptive/scaled_space.h"
#include "image/image.h"
#include "tests/run_node.h"

namespace weft {
namespace {

constexpr int width = 40, height = 32;

// Radiance on the film, in pixels, of the point (u, v) of the light.
using Radiance = std::function<float(float x, float y, float u, float v)>;
SamplerFunction sampler_of(const Radiance& radiance, bool light) {
    SamplerFunction made;
    made.width = width, made.height = height;
    made.axes = {{"x", float(width)}, {"y", float(height)}};
    if (light) made.axes.insert(made.axes.end(), {{"light-u", 0}, {"light-v", 0}});
    made.evaluate = [radiance, light](const SamplerPoints& points, std::uint64_t, std::span<float> rgb) {
        for (size_t i = 0; i < points.size(); ++i)
            for (size_t c = 0; c < 3; ++c)
                rgb[3 * i + c] = radiance(points.axes[0][i] * float(width), points.axes[1][i] * float(height), light ? points.axes[2][i] : 0.5f,
                                          light ? points.axes[3][i] : 0.5f);
    };
    return made;
}

// Every pixel's mean over 4 x 4 places and as many points of the light.
Image reference_of(const Radiance& radiance) {
    Image image(width, height, 3);
    const auto part = [](int i) { return (float(i) + 0.5f) / 4; };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            double sum = 0;
            for (int k = 0; k < 256; ++k) sum += double(radiance(float(x) + part(k & 3), float(y) + part(k >> 2 & 3), part(k >> 4 & 3), part(k >> 6 & 3))) / 256;
            for (int c = 0; c < 3; ++c) image.at(x, y)[c] = float(sum);
        }
    return image;
}

// By `anisotropic-reconstruct`, of adaptive samples or even ones.
Image picture_of(const SamplerFunction& sampler, bool adaptive) {
    Samples samples;
    Metrics tensors;
    if (adaptive) {
        LeafTree leaves;
        RunNode node("adaptive-samples");
        node.in("sampler", sampler).set("budget", Json(8.0));
        node.run({Slot{"samples", &type_info<Samples>(), &samples, {}}, Slot{"leaves", &type_info<LeafTree>(), &leaves, {}}});
        tensors = RunNode("structure-tensors").in("samples", samples).in("leaves", leaves).out<Metrics>("tensors");
    } else {
        samples = RunNode("uniform-samples").in("sampler", sampler).set("per-pixel", Json(8.0)).out<Samples>("samples");
        tensors = RunNode("structure-tensors").in("samples", samples).out<Metrics>("tensors");
    }
    LeafTree pixels;  // a box a pixel: means over it
    pixels.width = width, pixels.height = height;
    pixels.axes = tensors.space.axes, pixels.extent = tensors.space.extent;
    pixels.first.push_back(0);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int k = 0; k < 4; ++k) {
                for (size_t d = 0; d < pixels.axes.size(); ++d) {
                    const float lo = d == 0 ? float(x) : d == 1 ? float(y) : float(d == 2 ? k & 1 : k >> 1) * pixels.extent[d] / 2;
                    pixels.lo.push_back(lo);
                    pixels.hi.push_back(lo + (d < 2 ? 1 : pixels.extent[d] / 2));
                }
                pixels.mean.insert(pixels.mean.end(), 3, 0.0f);
                pixels.first.push_back(0);
                pixels.error.push_back(0);
                if (pixels.axes.size() == 2) break;
            }
    return RunNode("leaf-integrate").in("samples", samples).in("leaves", pixels).in("tensors", tensors).out<Image>("image");
}
double rel_mse(const Image& picture, const Image& reference) {
    double sum = 0;
    for (size_t i = 0; i < picture.pixels().size(); ++i) {
        const double exact = double(reference.pixels()[i]);
        sum += std::pow(double(picture.pixels()[i]) - exact, 2) / (exact * exact + 0.01) / double(picture.pixels().size());
    }
    return sum;
}

bool in_lamp(float x, float y, float by) { return x > 12.3f - by && x < 26.6f + by && y > 9.4f - by && y < 14.2f + by; }
float lamp(float x, float y, float u, float v) {
    if (in_lamp(x, y, 0)) return 20;
    return y > 24 ? 0.3f * float(u + 0.3f * v > x / 40) : 0.002f;  // a penumbra below
}

TEST(Outshone, BlackStaysBlackBesideALamp) {
    for (const bool light : {false, true}) {
        const SamplerFunction sampler = sampler_of(lamp, light);
        for (const bool adaptive : {false, true}) {
            const Image picture = picture_of(sampler, adaptive);
            for (int y = 0; y < 18; ++y)
                for (int x = 0; x < width; ++x) {
                    const float px = float(x) + 0.5f, py = float(y) + 0.5f;
                    if (!in_lamp(px, py, 2)) {
                        EXPECT_NEAR(picture.at(x, y)[0], 0.002f, 0.01f) << x << ' ' << y << ' ' << light << adaptive;
                    }
                    if (in_lamp(px, py, -2)) {
                        EXPECT_NEAR(picture.at(x, y)[0], 20, 0.2f) << x << ' ' << y << ' ' << light << adaptive;
                    }
                }
        }
    }
}

// Stripes of two pixels under a light whose shadow's edge crosses them.
float stripes(float x, float y, float u, float v) {
    const float shade = y + 4 * (u + v) > 16 ? 1.0f : 0.3f;
    return shade * (std::fmod(x + 0.2f * y, 4.0f) < 2 ? 0.8f : 0.2f);
}

TEST(Outshone, FineStripesKeepTheirContrastOverAxesOfNoUseToThem) {
    const Image reference = reference_of(stripes);
    const SamplerFunction sampler = sampler_of(stripes, true);
    const Samples even = RunNode("uniform-samples").in("sampler", sampler).set("per-pixel", Json(8.0)).out<Samples>("samples");
    const Image box = RunNode("pixel-filter").in("samples", even).out<Image>("image");
    for (const bool adaptive : {false, true})
        EXPECT_LT(rel_mse(picture_of(sampler, adaptive), reference), 0.7 * rel_mse(box, reference)) << adaptive;
}

TEST(ScaledSpace, AxesOfWhichNothingIsKnownAreAsShortAsSamplesAreFew) {
    std::vector<float> extent{160, 90, 0, 0};
    adaptive::shorten_axes(extent, 64);
    EXPECT_NEAR(extent[2], std::sqrt(64 * std::pow(1.2, 4)), 1e-3);
    EXPECT_EQ(extent[2], extent[3]);
    extent = {160, 90, 28, 0, 0};
    adaptive::shorten_axes(extent, 1);
    EXPECT_EQ(extent, (std::vector<float>{160, 90, 28, 4, 4}));
    extent = {160, 90, 0};
    adaptive::shorten_axes(extent, 64);
    EXPECT_EQ(extent[2], adaptive::usual_extent);
}

}  // namespace
}  // namespace weft
