// Distances along trajectories, recorded buffers as samplers, and pictures of where samples went.
#include <gtest/gtest.h>

#include <cmath>

#include "adaptive/leaf_tree.h"
#include "adaptive/metrics.h"
#include "adaptive/near_samples.h"
#include "adaptive/sampler_function.h"
#include "image/image.h"
#include "tests/run_node.h"

namespace weft {
namespace {
using namespace adaptive;

// Of one plane at depth 2 that moves 8 px to the right, seen through a lens.
Samples moving_plane() {
    Samples s;
    s.width = s.height = 16;
    s.spp = 4;
    s.set_size(4 * s.pixels());
    s.lens = Lens{.c0 = 4, .c1 = 1};
    std::vector<float> xy, uv, t, z, motion, rgb;
    for (size_t i = 0; i < s.size(); ++i) {
        const size_t p = i / 4;
        xy.push_back(float(p % 16) + 0.3f), xy.push_back(float(p / 16) + 0.6f);
        uv.push_back(float(i % 3) / 3 - 0.4f), uv.push_back(float(i % 5) / 5 - 0.4f);
        t.push_back(float(i % 7) / 7);
        z.push_back(2);
        motion.insert(motion.end(), {16, 0, 0});  // px z
        rgb.insert(rgb.end(), 3, float(i % 11));
    }
    s.add("xy", 2, xy), s.add("uv", 2, uv), s.add("t", 1, t), s.add("z", 1, z), s.add("motion", 3, motion), s.add("rgb", 3, rgb);
    s.meta = s.meta_object();
    return s;
}

TEST(SlopeTensors, AreShortAlongTheTrajectory) {
    const Samples samples = moving_plane();
    for (const float trust : {0.5f, 0.98f, 1.0f}) {
        const Metrics m = RunNode("slope-tensors").in("samples", samples).set("trust", Json(double(trust))).out<Metrics>("tensors");
        ASSERT_EQ(m.space.axes, (std::vector<std::string>{"x", "y", "u", "v", "t"}));
        EXPECT_EQ(m.space.extent[4], 8);   // its speed
        EXPECT_EQ(m.space.extent[2], 6);   // twice its circle of confusion, 4/2 + 1
        const auto distance = [&](std::array<float, 5> off, size_t i) {
            float sum = 0;
            for (size_t a = 0; a < 5; ++a)
                for (size_t b = 0; b < 5; ++b) sum += m.upper[15 * i + upper_index(std::min(a, b), std::max(a, b), 5)] * off[a] * off[b];
            return sum;
        };
        for (const size_t i : {0u, 100u, 1000u}) {
            // Half the shutter carries it 4 px; half the lens' diameter 3 px in x or in y.
            EXPECT_NEAR(distance({4, 0, 0, 0, 4}, i), (1 - trust) * 16, 1e-4f);
            EXPECT_NEAR(distance({3, 0, 3, 0, 0}, i), (1 - trust) * 9, 1e-4f);
            EXPECT_NEAR(distance({0, 3, 0, 3, 0}, i), (1 - trust) * 9, 1e-4f);
            EXPECT_NEAR(distance({1, 2, 0, 0, 0}, i), 5, 1e-4f);
        }
    }
}

TEST(SlopeTensors, SayWhatABufferLacks) {
    Samples samples = moving_plane();
    samples.lens.reset();
    EXPECT_NE(error_of([&] { RunNode("slope-tensors").in("samples", samples).out<Metrics>("tensors"); }).find("nothing of its lens"), std::string::npos);
    Samples still = moving_plane();
    std::erase_if(still.channels, [](const Channel& c) { return c.name == "motion"; });
    EXPECT_NE(error_of([&] { RunNode("slope-tensors").in("samples", still).out<Metrics>("tensors"); }).find("no motion"), std::string::npos);
}

// Asked where its samples lie, a buffer gives these back.
TEST(BufferSampler, IsWhatWasRecorded) {
    const SamplerFunction disc = RunNode("test-sampler").out<SamplerFunction>("sampler");
    const Samples recorded = RunNode("uniform-samples").in("sampler", disc).set("per-pixel", Json(4.0)).out<Samples>("samples");
    const SamplerFunction sampler = RunNode("buffer-sampler").in("samples", recorded).out<SamplerFunction>("sampler");
    ASSERT_EQ(sampler.dimensions(), 3u);
    std::vector<float> x, y, t;
    for (size_t i = 0; i < recorded.size(); ++i) x.push_back(recorded.xy()[2 * i] / 48), y.push_back(recorded.xy()[2 * i + 1] / 48), t.push_back(recorded.t()[i]);
    std::vector<float> rgb(3 * x.size());
    const std::vector<std::span<const float>> axes{x, y, t};
    sampler.evaluate({axes}, 0, rgb);
    for (size_t k = 0; k < rgb.size(); ++k) ASSERT_EQ(rgb[k], recorded.rgb()[k]);
    const Samples again = RunNode("uniform-samples").in("sampler", sampler).set("per-pixel", Json(2.0)).out<Samples>("samples");
    EXPECT_EQ(again.size(), 2u * 48 * 48);
}

TEST(ShowLeaves, DrawsEveryBoxThatTheSliceCuts) {
    const SamplerFunction disc = RunNode("test-sampler").out<SamplerFunction>("sampler");
    RunNode node("adaptive-samples");
    Samples samples;
    LeafTree leaves;
    node.in("sampler", disc).set("budget", Json(4.0));
    node.run({Slot{"samples", &type_info<Samples>(), &samples, {}}, Slot{"leaves", &type_info<LeafTree>(), &leaves, {}}});
    const Image slice = RunNode("show-leaves").in("leaves", leaves).set("down", Json("t")).set("zoom", Json(2.0)).out<Image>("image");
    EXPECT_EQ(slice.width(), 96);
    EXPECT_EQ(slice.height(), 56);
    for (const float x : slice.pixels()) EXPECT_GT(x, 0);
    EXPECT_NE(error_of([&] { RunNode("show-leaves").in("leaves", leaves).set("down", Json("u")).out<Image>("image"); }).find("no axis 'u'; there are x, y, t"), std::string::npos);
    const Image counts = RunNode("count-samples").in("samples", samples).out<Image>("image");
    double sum = 0, in_path = 0;
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 48; ++x) {
            sum += double(counts.at(x, y)[0]);
            if (std::abs(y - 23.5) < 10) in_path += double(counts.at(x, y)[0]);
        }
    EXPECT_NEAR(sum, 48 * 48, 0.1);
    EXPECT_GT(in_path, 1.05 * 20 * 48);
}

}  // namespace
}  // namespace weft
