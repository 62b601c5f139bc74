// test-sampler: functions with known pictures, for tests of what samples adaptively and
// reconstructs.
//   constant   0.5
//   linear     x / width
//   time       t
//   texture    0.5 + 0.5 sin(2 pi (x - speed t) / wavelength)
//   edge       1 left of width / 4 + speed t, 0 right of it
//   disc       a textured disc of radius 9 px that moves 28 px over a smooth background; for 48 x
//   48 px noise      0.5 and noise that no axis explains
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "adaptive/sampler_function.h"
#include "runtime/node.h"
#include "samples/random.h"

namespace weft {
namespace {

enum class Function { constant, linear, time, texture, edge, disc, noise };

struct TestSampler {
    Function function = Function::disc;
    int width = 48, height = 48;
    float speed = 6, wavelength = 8;

    static void declare(Ports<TestSampler>& node) {
        node.about("functions of x, y and t with known pictures, as a renderer to sample")
            .out<SamplerFunction>("sampler", "axes x, y, t")
            .choice("function", &TestSampler::function,
                    {"constant", "linear", "time", "texture", "edge", "disc", "noise"},
                    {.about = "disc: a textured disc moves over a smooth background; noise: what "
                              "no axis explains"})
            .param("width", &TestSampler::width,
                   {.unit = "px", .min = 1, .max = 32768, .about = "of the picture"})
            .param("height", &TestSampler::height,
                   {.unit = "px", .min = 1, .max = 32768, .about = "of the picture"})
            .param("speed", &TestSampler::speed,
                   {.unit = "px per shutter",
                    .min = -4096,
                    .max = 4096,
                    .about = "of texture and edge, along x"})
            .param("wavelength", &TestSampler::wavelength,
                   {.unit = "px", .min = 0.1, .max = 32768, .about = "of the texture"});
    }

    float at(float x, float y, float t, std::uint64_t hash) const {
        constexpr float tau = 2 * std::numbers::pi_v<float>;
        switch (function) {
            case Function::constant:
                return 0.5f;
            case Function::linear:
                return x / float(width);
            case Function::time:
                return t;
            case Function::texture:
                return 0.5f + 0.5f * std::sin(tau * (x - speed * t) / wavelength);
            case Function::edge:
                return x < float(width) / 4 + speed * t ? 1.0f : 0.0f;
            case Function::noise:
                return unit_float(hash);
            case Function::disc:
                break;
        }
        const float dx = x - (10 + 28 * t), dy = y - 24;
        if (dx * dx + dy * dy < 81)
            return 0.7f + 0.25f * std::sin(tau * dx / 6) * std::cos(tau * dy / 5);
        return 0.3f + 0.2f * std::sin(tau * x / 24) * std::sin(tau * y / 20);
    }

    void run(const Inputs&, Outputs& out, Context&) const {
        SamplerFunction sampler;
        sampler.width = width;
        sampler.height = height;
        const bool moves = function == Function::texture || function == Function::edge;
        sampler.axes = {{"x", float(width)},
                        {"y", float(height)},
                        {"t", function == Function::disc ? 28
                              : moves                    ? std::abs(speed)
                                                         : 0}};
        sampler.meta.set("source", "test-sampler");
        sampler.evaluate = [self = *this](const SamplerPoints& points, std::uint64_t hidden_seed,
                                          std::span<float> rgb) {
            for (size_t i = 0; i < points.size(); ++i) {
                const float x = points.axes[0][i], y = points.axes[1][i], t = points.axes[2][i];
                std::uint64_t hash = mix(hidden_seed);
                for (const float number : {x, y, t})
                    hash = mix(hash ^ std::bit_cast<std::uint32_t>(number));
                const float value = self.at(x * float(self.width), y * float(self.height), t, hash);
                for (size_t c = 0; c < 3; ++c) rgb[3 * i + c] = value;
            }
        };
        out.set("sampler", std::move(sampler));
    }
};

WEFT_NODE(TestSampler, "test-sampler", 1)

}  // namespace
}  // namespace weft
