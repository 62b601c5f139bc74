// Textures: exact texels, the mean of a filter, colours, wraps, purity, bounded memory, errors.
#include "render/textures.h"

#include <atomic>
#include <barrier>
#include <cmath>
#include <fstream>
#include <thread>

#include "image/exr_file.h"
#include "image/png_file.h"
#include "run_node.h"
#include "samples/random.h"

namespace weft {
namespace {

using Wrap = TextureMap::Wrap;

std::shared_ptr<const std::string> png(const Image& image, Depth depth = Depth::u16) {
    std::vector<std::string> warnings;
    PictureOptions options;
    options.depth = depth;
    return std::make_shared<const std::string>(encode_png(image, options, warnings));
}

Scene scene_with(std::vector<TextureFile> files) {
    Scene scene;
    scene.textures = std::move(files);
    for (size_t i = 0; i < scene.textures.size(); ++i) {
        Material m;
        m.base_color_map.file = int(i);
        scene.materials.push_back(m);
    }
    return scene;
}

// A picture whose texel (x, y) is (x, y, 0.25) in steps of 1/64; not a colour.
Image ramp(int width, int height) {
    Image image(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            image.at(x, y)[0] = float(x) / 64, image.at(x, y)[1] = float(y) / 64;
            image.at(x, y)[2] = 0.25f;
        }
    return image;
}

std::array<float, 4> one(const Textures& textures, int file, Vec2 uv, float width = 0,
                         float random = 0.5f, Wrap wrap = Wrap::repeat) {
    std::array<float, 4> rgba{};
    textures.lookup(file, wrap, wrap, {&uv, 1}, {&width, 1}, {&random, 1}, rgba);
    return rgba;
}

std::array<double, 4> mean(const Textures& textures, int file, Vec2 uv, float width) {
    constexpr int count = 40000;
    std::vector<Vec2> at(count, uv);
    std::vector<float> widths(count, width), random(count), rgba(4 * count);
    for (int i = 0; i < count; ++i) random[size_t(i)] = (float(i) + 0.5f) / count;
    textures.lookup(file, Wrap::clamp, Wrap::clamp, at, widths, random, rgba);
    std::array<double, 4> sum{};
    for (size_t i = 0; i < rgba.size(); ++i) sum[i % 4] += rgba[i] / count;
    return sum;
}

TEST(Textures, TexelsAreExactAtTheirCentres) {
    const auto textures = open_textures(scene_with({{"ramp.png", png(ramp(64, 32)), false}}));
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x) {
            const auto c = one(*textures, 0, {(float(x) + 0.5f) / 64, (float(y) + 0.5f) / 32});
            EXPECT_NEAR(c[0], x / 64.0, 1e-3);
            EXPECT_NEAR(c[1], y / 64.0, 1e-3);
            EXPECT_EQ(c[3], 1);
        }
}

TEST(Textures, TheMeanOfLookupsIsTheTrilinearFilter) {
    const auto textures = open_textures(scene_with({{"ramp.png", png(ramp(64, 64)), false}}));
    // A ramp stays a ramp at every level: bilinear between texels gives uv back.
    for (const float width : {0.0f, 1.0f / 64, 1.5f / 64, 3.0f / 64, 9.0f / 64}) {
        const auto c = mean(*textures, 0, {0.4321f, 0.6f}, width);
        EXPECT_NEAR(c[0], 0.4321 - 0.5 / 64, 2e-3) << width;
        EXPECT_NEAR(c[1], 0.6 - 0.5 / 64, 2e-3) << width;
        EXPECT_NEAR(c[2], 0.25, 1e-3);
    }
    // The whole picture: the last level alone.
    EXPECT_NEAR(one(*textures, 0, {0.1f, 0.9f}, 1)[0], 31.5 / 64, 1e-3);
    EXPECT_NEAR(one(*textures, 0, {0.1f, 0.9f}, 1e30f)[0], 31.5 / 64, 1e-3);
}

TEST(Textures, NoLevelIsFinerThanTheFootprint) {
    // A checkerboard of single texels is grey at every level but the first.
    Image checker(256, 256, 1);
    for (int y = 0; y < 256; ++y)
        for (int x = 0; x < 256; ++x) checker.at(x, y)[0] = float((x + y) % 2);
    const auto textures = open_textures(scene_with({{"checker.png", png(checker), false}}));
    for (int i = 0; i < 100; ++i) {
        const float r = unit_float(mix(std::uint64_t(i)));
        EXPECT_NEAR(one(*textures, 0, {r, 1 - r}, 2.0f / 256, r)[0], 0.5, 1e-3);
    }
}

TEST(Textures, AveragesAreOfLightNotOfCodes) {
    Image checker(64, 64, 1);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) checker.at(x, y)[0] = float((x + y) % 2);
    const auto textures = open_textures(scene_with({{"checker.png", png(checker)}}));
    EXPECT_NEAR(one(*textures, 0, {0.5f, 0.5f}, 0.25f)[0], 0.5, 1e-3);
}

TEST(Textures, OddSizesKeepTheirMean) {
    Image image(101, 37, 1);
    double sum = 0;
    for (size_t i = 0; i < image.pixels().size(); ++i)
        sum += image.pixels()[i] = unit_float(mix(i));
    const auto textures = open_textures(scene_with({{"odd.png", png(image), false}}));
    EXPECT_NEAR(one(*textures, 0, {0.3f, 0.3f}, 1)[0], sum / (101 * 37), 2e-3);
}

TEST(Textures, ColoursComeInTheScenesSpace) {
    Image grey(4, 4, 3);
    for (float& v : grey.pixels()) v = 0.5f;
    Scene scene = scene_with({{"grey.png", png(grey)}, {"data.png", png(grey), false}});
    EXPECT_NEAR(one(*open_textures(scene), 0, {0.5f, 0.5f})[0], 0.214041, 2e-4);
    EXPECT_NEAR(one(*open_textures(scene), 1, {0.5f, 0.5f})[0], 0.5, 2e-4);
    Image red(4, 4, 3);
    for (size_t i = 0; i < red.pixels().size(); i += 3) red.pixels()[i] = 1;
    scene = scene_with({{"red.png", png(red)}});
    scene.color_space = "ACEScg";
    const auto c = one(*open_textures(scene), 0, {0.5f, 0.5f});
    EXPECT_NEAR(c[0], 0.613097, 5e-4);
    EXPECT_NEAR(c[1], 0.070194, 5e-4);
    EXPECT_NEAR(c[2], 0.020616, 5e-4);
}

TEST(Textures, AlphaIsNotPremultiplied) {
    Image image(2, 1, 4);
    // In memory premultiplied, in the file straight: (0.5, 0.25, 0, 0.5) is written as (1, 0.5, 0).
    const float values[] = {0.5f, 0.25f, 0, 0.5f, 0.3f, 0.3f, 0.3f, 1};
    std::copy(values, values + 8, image.pixels().begin());
    const auto textures = open_textures(scene_with({{"alpha.png", png(image), false}}));
    EXPECT_TRUE(textures->has_alpha(0));
    EXPECT_FALSE(open_textures(scene_with({{"ramp.png", png(ramp(2, 2))}}))->has_alpha(0));
    const auto c = one(*textures, 0, {0.25f, 0.5f});
    EXPECT_NEAR(c[0], 1, 1e-3);
    EXPECT_NEAR(c[1], 0.5, 1e-3);
    EXPECT_NEAR(c[3], 0.5, 1e-3);
    // At the coarser level colour counts by alpha: (0.5 * 1 + 1 * 0.3) / 1.5.
    EXPECT_NEAR(one(*textures, 0, {0.5f, 0.5f}, 1)[0], 0.8 / 1.5, 2e-3);
    EXPECT_NEAR(one(*textures, 0, {0.5f, 0.5f}, 1)[3], 0.75, 1e-3);
}

TEST(Textures, Wrap) {
    const auto textures = open_textures(scene_with({{"ramp.png", png(ramp(8, 8)), false}}));
    const auto x = [&](float u, Wrap wrap) {
        return one(*textures, 0, {u, 0.0625f}, 0, 0.999f, wrap)[0] * 64;
    };
    const float c = 0.0625f;  // of the first texel
    EXPECT_NEAR(x(2 + c, Wrap::repeat), 0, 1e-3);
    EXPECT_NEAR(x(-c, Wrap::repeat), 7, 1e-3);
    EXPECT_NEAR(x(-c, Wrap::mirror), 0, 1e-3);
    EXPECT_NEAR(x(1 + c, Wrap::mirror), 7, 1e-3);
    EXPECT_NEAR(x(2 - c, Wrap::mirror), 0, 1e-3);
    EXPECT_NEAR(x(-5, Wrap::clamp), 0, 1e-3);
    EXPECT_NEAR(x(5, Wrap::clamp), 7, 1e-3);
    for (const float strange : {1e30f, -1e30f, HUGE_VALF, -HUGE_VALF, NAN})
        for (const Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp}) {
            const float v = x(strange, wrap);
            EXPECT_TRUE(v >= 0 && v <= 7.01f) << strange;
        }
}

// The example of KHR_texture_transform: the lower left quarter of the picture, turned clockwise.
TEST(Textures, RotationIsThatOfGltf) {
    TextureMap map;
    map.offset = {0, 1}, map.rotation = 1.57079632679f, map.scale = {0.5f, 0.5f};
    const auto expect_near = [&](Vec2 uv, Vec2 expected) {
        EXPECT_NEAR(place(map, uv).x, expected.x, 1e-6);
        EXPECT_NEAR(place(map, uv).y, expected.y, 1e-6);
    };
    expect_near({0, 0}, {0, 1});  // a surface's upper left corner shows the picture's lower left
    expect_near({1, 0}, {0, 0.5f});
    expect_near({0, 1}, {0.5f, 1});
    expect_near({1, 1}, {0.5f, 0.5f});
}

TEST(Textures, AreTheSameWhateverWasAskedBeforeAndFromAllThreads) {
    Image image(1024, 1024, 3);
    for (size_t i = 0; i < image.pixels().size(); ++i) image.pixels()[i] = unit_float(mix(i));
    const Scene scene = scene_with({{"noise.png", png(image, Depth::u8)}});
    constexpr size_t count = 20000;
    std::vector<Vec2> uv(count);
    std::vector<float> width(count), random(count);
    for (size_t i = 0; i < count; ++i) {
        uv[i] = {unit_float(mix(i * 3)), unit_float(mix(i * 3 + 1))};
        width[i] = 0.01f * unit_float(mix(i * 3 + 2));
        random[i] = unit_float(mix(i + 1000000));
    }
    const auto all = [&](const Textures& textures, size_t batch) {
        std::vector<float> rgba(4 * count);
        for (size_t i = 0; i < count; i += batch) {
            const size_t n = std::min(batch, count - i);
            textures.lookup(0, Wrap::repeat, Wrap::repeat, {&uv[i], n}, {&width[i], n},
                            {&random[i], n}, {&rgba[4 * i], 4 * n});
        }
        return rgba;
    };
    const auto expected = all(*open_textures(scene), count);
    // A cache of one megabyte for a picture of eleven.
    const auto small = open_textures(scene, 1 << 20);
    EXPECT_EQ(all(*small, 64), expected);
    std::vector<std::vector<float>> found(4);
    std::vector<std::thread> threads;
    const auto shared = open_textures(scene, 4 << 20);
    for (auto& f : found) threads.emplace_back([&] { f = all(*shared, 256); });
    for (auto& t : threads) t.join();
    for (const auto& f : found) EXPECT_EQ(f, expected);
}

// Threads that outlive scenes, as a pool's do, meet nothing of an earlier one's textures.
TEST(Textures, OfOneSceneAfterAnotherOnTheSameThreads) {
    constexpr int scenes = 300, threads = 3;
    std::unique_ptr<Textures> textures;
    std::barrier step(threads + 1);
    std::vector<std::jthread> pool;
    std::atomic<int> wrong = 0;
    for (int k = 0; k < threads; ++k)
        pool.emplace_back([&, k] {
            for (int i = 0; i < scenes; ++i) {
                step.arrive_and_wait();
                // Not every thread in every scene.
                for (int n = 0; n < 40 && (i + k) % 3 > 0; ++n)
                    wrong += std::abs(one(*textures, 0, {(float(n) + 0.5f) / 64, 0.5f})[0] -
                                      float(n) / 64) > 1e-3f;
                step.arrive_and_wait();
            }
        });
    const auto picture = png(ramp(64, 64));
    for (int i = 0; i < scenes; ++i) {
        textures = open_textures(scene_with({{"ramp.png", picture, false}}));
        step.arrive_and_wait();
        step.arrive_and_wait();
        textures.reset();
    }
    EXPECT_EQ(wrong, 0);
}

TEST(Textures, HeightsBecomeTheNormalsThatTheyMake) {
    // A hill along x: up 0.2 a texel, then down as much; white is 5 texels above black.
    Image hill(8, 8, 1);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) hill.at(x, y)[0] = 0.2f * float(x < 4 ? x : 8 - x);
    Scene scene = scene_with({{"hill.png", png(hill), false, 5}});
    const auto at = [&](const Scene& s, int x, int y) {
        const auto c = one(*open_textures(s), 0, {(float(x) + 0.5f) / 8, (float(y) + 0.5f) / 8});
        return Vec3{2 * c[0] - 1, 2 * c[1] - 1, 2 * c[2] - 1};
    };
    const auto expect_near = [](Vec3 n, Vec3 expected) {
        EXPECT_LT(length(n - unit(expected)), 2e-3f) << n.x << " " << n.y << " " << n.z;
    };
    expect_near(at(scene, 2, 3), {-1, 0, 1});  // 45 degrees: it looks to the left
    expect_near(at(scene, 6, 3), {1, 0, 1});
    expect_near(at(scene, 4, 3), {0, 0, 1});
    expect_near(at(scene, 0, 3), {0, 0, 1});  // the valley, across the picture's edge
    scene.textures[0].bump = -2.5f;
    expect_near(at(scene, 2, 3), {0.5f, 0, 1});
    // Upright: what rises down the picture looks up it.
    Image slope(8, 8, 1);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) slope.at(x, y)[0] = 0.1f * float(y);
    scene = scene_with({{"slope.png", png(slope), false, 10}});
    expect_near(at(scene, 3, 4), {0, 1, 1});
    // A normal map in the place of heights is itself; a grey as long as a normal is not one.
    Image normals(8, 8, 3);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) {
            const Vec3 n = unit(Vec3{0.1f * float(x - 4), 0.1f * float(y - 4), 1});
            for (size_t c = 0; c < 3; ++c)
                normals.at(x, y)[c] = 0.5f + 0.5f * (c == 0 ? n.x : c == 1 ? n.y : n.z);
        }
    scene = scene_with({{"normals.png", png(normals), false, 5}});
    expect_near(at(scene, 6, 1), {0.2f, -0.3f, 1});
    Image grey(8, 8, 3);
    for (float& v : grey.pixels()) v = 0.5f + 0.5f / std::sqrt(3.0f);
    scene = scene_with({{"grey.png", png(grey), false, 5}});
    expect_near(at(scene, 6, 1), {0, 0, 1});
}

TEST(Textures, FloatFilesAreLinearAlready) {
    TestFolder folder;
    Image image(4, 4, 3);
    for (float& v : image.pixels()) v = 3.5f;
    image.color_space = "lin_rec709";
    std::vector<std::string> warnings;
    write_picture(folder / "hdr.exr", image, {}, warnings);
    const auto textures = open_textures(scene_with({{folder / "hdr.exr", nullptr}}));
    EXPECT_NEAR(one(*textures, 0, {0.5f, 0.5f})[0], 3.5, 2e-3);
}

TEST(Textures, WhatIsMissingOrNoPictureIsTold) {
    EXPECT_EQ(error_of([] {
                  open_textures(scene_with({{"/nowhere/wood.png", nullptr}}));
              }),
              "/nowhere/wood.png: the texture cannot be read: no such file");
    const auto words = std::make_shared<const std::string>("these are words");
    EXPECT_NE(error_of([&] {
                  open_textures(scene_with({{"words.png", words}}));
              }).find("words.png: not a picture that can be read"),
              std::string::npos);
    // The header is whole, the rest is not: found when it is first needed.
    const auto whole = png(ramp(64, 64));
    const auto cut = std::make_shared<const std::string>(whole->substr(0, whole->size() / 2));
    const auto textures = open_textures(scene_with({{"cut.png", cut}}));
    EXPECT_NE(error_of([&] {
                  one(*textures, 0, {0.5f, 0.9f});
              }).find("cut.png: not a whole picture"),
              std::string::npos);
}

TEST(Textures, ASceneWithoutAnyNeedsNoModule) {
    EXPECT_NE(open_textures(Scene()), nullptr);
    Scene scene = scene_with({});
    scene.textures.push_back({"/nowhere/unused.png", nullptr});
    EXPECT_EQ(error_of([&] { open_textures(scene); }), "");
}

}  // namespace
}  // namespace weft
