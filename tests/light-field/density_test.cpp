// Buffers whose density varies, any number of samples a pixel, and buffers with next to nothing in
// them.
#include "light-field/build_hierarchy_kernel.h"
#include "light-field/kernels.h"
#include "light-field/local_radius.h"
#include "samples/analytic_scene.h"
#include "samples/sample_shape.h"
#include "tests/light-field/light_field_test.h"

namespace weft {
namespace {
using namespace light_field;

// The samples of those pixels of `from` for which `keep` is true, and of `other` elsewhere.
template <class Keep>
Samples merged(const Samples& from, const Samples& other, Keep&& keep) {
    Samples s;
    s.width = from.width;
    s.height = from.height;
    s.lens = from.lens;
    std::vector<std::uint64_t> first = {0};
    std::vector<std::vector<float>> values(from.channels.size());
    for (int y = 0; y < s.height; ++y)
        for (int x = 0; x < s.width; ++x) {
            const Samples& source = keep(x, y) ? from : other;
            const auto range = source.of_pixel(size_t(y) * size_t(s.width) + size_t(x));
            first.push_back(first.back() + (range.end - range.begin));
            for (size_t c = 0; c < values.size(); ++c) {
                const Channel& channel = *source.find(from.channels[c].name);
                const auto view = channel.values.view();
                const auto k = size_t(channel.components);
                if (!channel.whole())
                    values[c].insert(values[c].end(),
                                     view.begin() + std::ptrdiff_t(k * range.begin),
                                     view.begin() + std::ptrdiff_t(k * range.end));
            }
        }
    s.set_size(first.back());
    s.first = first;
    for (size_t c = 0; c < values.size(); ++c)
        if (!from.channels[c].whole())
            s.add(from.channels[c].name, from.channels[c].components, std::move(values[c]));
    return s;
}

Samples without(const Samples& from, int x0, int y0, int x1, int y1) {
    Samples none = from;
    none.spp = 0;
    none.first = std::vector<std::uint64_t>(from.pixels() + 1, 0);
    return merged(from, none, [&](int x, int y) { return x < x0 || x >= x1 || y < y0 || y >= y1; });
}

Image reconstructed(const Samples& samples, const std::string& locations = R"("per-pixel": 64)",
                    int tile = 32, int threads = 1) {
    PlainContext ctx;
    const TestFolder folder;
    write_npz(samples, folder / "samples.npz", false, ctx);
    return GraphRun(tlfr_text(folder / "samples.npz", locations), tile, threads).picture;
}

AnalyticOptions options_of(int spp) {
    AnalyticOptions options;
    options.width = 96;
    options.height = 48;
    options.spp = spp;
    return options;
}

double rms(const Image& picture, const char* scene, int x0, int x1) {
    const AnalyticOptions options = options_of(1);
    double sum = 0;
    size_t n = 0;
    for (int y = 3; y < options.height - 3; ++y)
        for (int x = x0; x < x1; ++x)
            if (const auto exact = analytic_exact(scene, options, x, y))
                for (size_t c = 0; c < 3; ++c, ++n)
                    sum += std::pow(double(picture.at(x, y)[c]) - (*exact)[c], 2);
    EXPECT_GT(n, 0u);
    return std::sqrt(sum / double(std::max<size_t>(n, 1)));
}

TEST(LocalRadii, AreNoneWhereDensityIsOne) {
    PlainContext ctx;
    const Samples even = random_samples(12, 9, 3, Kind_of::defocused);
    EXPECT_TRUE(local_radii(even, 1, ctx).empty());
    // The same with counts, and with one sample of 324 gone.
    EXPECT_TRUE(local_radii(merged(even, even, [](int, int) { return true; }), 1, ctx).empty());
    Samples one_less = even;
    one_less.spp = 0;
    std::vector<std::uint64_t> first(even.pixels() + 1);
    for (size_t i = 0; i < first.size(); ++i) first[i] = 3 * i - (i > 40);
    one_less.first = first;
    EXPECT_TRUE(local_radii(one_less, 1, ctx).empty());
}

TEST(LocalRadii, AreThoseOfEvenBuffersAwayFromSeams) {
    PlainContext ctx;
    const Samples halves =
        merged(random_samples(40, 20, 1, Kind_of::defocused),
               random_samples(40, 20, 16, Kind_of::defocused), [](int x, int) { return x < 20; });
    const auto radii = local_radii(halves, 0.5, ctx);
    ASSERT_EQ(radii.size(), 800u);
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 40; ++x) {
            const float r = radii[size_t(40 * y + x)];
            if (x < 17 || x >= 20) {
                EXPECT_FLOAT_EQ(r, 0.5f * dispersion_radius(x < 17 ? 1 : 16)) << x;
            } else {
                EXPECT_GE(r, 0.5f * dispersion_radius(16));
            }
        }
}

TEST(LocalRadii, GrowIntoHolesAndEnd) {
    PlainContext ctx;
    const auto radii =
        local_radii(without(random_samples(60, 60, 4, Kind_of::defocused), 10, 10, 50, 50), 1, ctx);
    ASSERT_EQ(radii.size(), 3600u);
    EXPECT_FLOAT_EQ(radii[0], dispersion_radius(4));
    EXPECT_FLOAT_EQ(radii[60 * 30 + 30], dispersion_radius(0));
    EXPECT_GT(radii[60 * 30 + 10], dispersion_radius(4));
}

TEST(LocalRadii, NarrowKeepsWhatIsWithinEachLocationsOwn) {
    PlainContext ctx;
    Hierarchy h =
        build_hierarchy(random_samples(20, 10, 6, Kind_of::defocused), Arrangement::layers, 1, ctx);
    for (int i = 0; i < 200; ++i) h.radii.push_back(0.3f + 0.1f * float(i % 7));
    Locations at;
    at.shared = true;
    at.u = {0.3f}, at.v = {-0.2f}, at.t = {0.5f};
    at.x1 = 20, at.y1 = 10;
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0, 1);
    for (int i = 0; i < 300; ++i) {
        at.x.push_back(20 * unit(random));
        at.y.push_back(10 * unit(random));
        at.own_pixels.push_back(0);
    }
    at.pixels = at.own_pixels;
    Block block;
    Candidates all, c;
    all.pixels = c.pixels = at.pixels;
    EXPECT_FLOAT_EQ(h.largest_radius(0, 0, 20, 10), 0.9f);
    collect(h, 0, 0, 20, 10, 2, block);
    for (Candidates* to : {&all, &c}) WEFT_PICK(gather_each)(h, block, at, 1.8f, *to);
    narrow(2, {}, c);
    for (size_t l = 0; l < at.size(); ++l) {
        const float radius = h.radii[size_t(at.y[l]) * 20 + size_t(at.x[l])];
        EXPECT_FLOAT_EQ(c.ratio[l] * h.radius, radius);
        std::vector<std::uint32_t> expected;
        for (std::uint32_t i = all.offset[l]; i < all.offset[l + 1]; ++i)
            if (all.dx[i] * all.dx[i] + all.dy[i] * all.dy[i] < 4 * radius * radius)
                expected.push_back(all.sample[i]);
        ASSERT_EQ(
            std::vector<std::uint32_t>(&c.sample[c.offset[l]], c.sample.data() + c.offset[l + 1]),
            expected)
            << l;
    }
}

// 1 spp on the left and 16 on the right: each half as good as in a buffer that is all like it. A
// blurred edge and a checker in focus; smooth-radiance, which has its own radius, left out.
class Halves : public testing::TestWithParam<const char*> {};

TEST_P(Halves, AreEachAsGoodAsAnEvenBuffer) {
    const char* scene = GetParam();
    PlainContext ctx;
    const Samples few = analytic_samples(scene, options_of(1), ctx),
                  many = analytic_samples(scene, options_of(16), ctx);
    const auto picture_of = [&](const Samples& samples) {
        const TestFolder folder;
        write_npz(samples, folder / "samples.npz", false, ctx);
        std::string text = tlfr_text(folder / "samples.npz", R"("per-pixel": 64)");
        const std::string linked = R"({"samples": "smooth"})";
        text.replace(text.find(linked), linked.size(), R"({"samples": "samples"})");
        return GraphRun(text).picture;
    };
    const Image halves = picture_of(merged(few, many, [](int x, int) { return x < 48; }));
    const Image low = picture_of(few), high = picture_of(many);
    EXPECT_LT(rms(halves, scene, 3, 40), 1.02 * rms(low, scene, 3, 40));
    EXPECT_LT(rms(halves, scene, 56, 93), 1.02 * rms(high, scene, 56, 93));
    // Near the seam no worse than the sparse half.
    EXPECT_LT(rms(halves, scene, 40, 48), 1.1 * rms(low, scene, 40, 48));
    EXPECT_LT(rms(halves, scene, 48, 56), 1.1 * rms(low, scene, 48, 56));
}
INSTANTIATE_TEST_SUITE_P(All, Halves, testing::Values("layers", "plane", "step"));

TEST(Density, BitsDoNotDependOnTilesAndThreadsWhereItVaries) {
    const Samples s = merged(random_samples(45, 37, 1, Kind_of::moving_in_depth),
                             random_samples(45, 37, 9, Kind_of::moving_in_depth),
                             [](int x, int y) { return (x / 9 + y / 7) % 2 == 0; });
    const auto whole = values_of(reconstructed(s, R"("per-pixel": 12)", 64));
    EXPECT_EQ(values_of(reconstructed(s, R"("per-pixel": 12)", 32, 2)), whole);
    EXPECT_EQ(values_of(reconstructed(s, R"("per-pixel": 12)", 7, 3)), whole);
}

TEST(Density, PlansKnowHowManySamplesAnAdaptiveFileHolds) {
    PlainContext ctx;
    const Samples s = without(random_samples(50, 40, 4, Kind_of::moving), 15, 10, 35, 30);
    const TestFolder folder;
    write_npz(s, folder / "samples.npz", false, ctx);
    const Shape shape = sample_shape(map_file(folder / "samples.npz"), {});
    EXPECT_EQ(shape.width, 50);
    EXPECT_NEAR(double(shape.records), double(s.size()),
                32);  // the array's header is counted with it
}

TEST(Density, HolesAreFilled) {
    Samples s = without(random_samples(50, 40, 4, Kind_of::moving), 15, 10, 35, 30);
    s.add("rgb", 3, std::vector<float>(3 * s.size(), 0.25f));
    for (float value : values_of(reconstructed(s, R"("per-pixel": 16)")))
        ASSERT_NEAR(value, 0.25f, 1e-5f);
}

TEST(Density, AnyNumberOfSamplesAPixelGivesItsShareOfQuality) {
    PlainContext ctx;
    for (const char* scene : {"layers", "step"}) {
        double before = 1e9;
        for (const int spp : {1, 3, 5, 6, 12}) {
            const double error =
                rms(reconstructed(analytic_samples(scene, options_of(spp), ctx)), scene, 3, 93);
            EXPECT_LT(error, 1.1 * before) << scene << ' ' << spp;
            before = error;
        }
    }
}

TEST(NextToNothing, OneSampleFillsThePicture) {
    Samples s = without(random_samples(8, 8, 1, Kind_of::still_pinhole), 0, 0, 8, 7);
    s = without(s, 0, 7, 7, 8);
    ASSERT_EQ(s.size(), 1u);
    const Image picture = reconstructed(s);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
            for (int c = 0; c < 3; ++c) ASSERT_NEAR(picture.at(x, y)[c], s.rgb()[size_t(c)], 1e-6f);
}

TEST(NextToNothing, OnePixelIsReconstructed) {
    for (const Kind_of kind : {Kind_of::still_pinhole, Kind_of::moving_in_depth})
        for (const int spp : {1, 2, 300}) {
            const Image picture = reconstructed(random_samples(1, 1, spp, kind));
            ASSERT_EQ(picture.width(), 1);
            for (float value : picture.pixels()) {
                EXPECT_TRUE(value >= 0 && value <= 1) << value;
            }
        }
}

TEST(NextToNothing, WhatIsBehindTheCameraAtHalfTimeIsFiniteAndBounded) {
    // Seen at the start of the shutter only.
    Samples s = random_samples(16, 12, 4, Kind_of::moving);
    std::vector<float> motion(3 * s.size()), z(s.z().begin(), s.z().end());
    for (size_t i = 0; i < s.size(); ++i) {
        if (std::isinf(z[i])) z[i] = 9;
        motion[3 * i + 2] = -4 * z[i];
    }
    s.add("z", 1, z);
    s.add("motion", 3, motion);
    s.add("t", 1, std::vector<float>(s.size(), 0));
    for (float value : values_of(reconstructed(s))) EXPECT_TRUE(value >= 0 && value <= 1) << value;
}

TEST(NextToNothing, InfinitelyFarIsAWallOfItsOwn) {
    for (const Kind_of kind : {Kind_of::defocused, Kind_of::moving_in_depth}) {
        Samples s = random_samples(16, 12, 2, kind);
        s.add("z", 1, std::vector<float>(s.size(), INFINITY));
        if (s.has_motion()) s.add("motion", 3, std::vector<float>(3 * s.size(), 0));
        s.add("rgb", 3, std::vector<float>(3 * s.size(), 0.75f));
        for (float value : values_of(reconstructed(s))) EXPECT_NEAR(value, 0.75f, 1e-5f);
    }
}

TEST(NextToNothing, RadianceThatIsNoNumberIsLeftOut) {
    Samples s = random_samples(20, 16, 4, Kind_of::defocused);
    std::vector<float> rgb(3 * s.size(), 0.5f);
    for (size_t i = 0; i < s.size(); i += 3) rgb[3 * i + i % 3] = i % 2 ? NAN : INFINITY;
    s.add("rgb", 3, rgb);
    for (float value : values_of(reconstructed(s))) EXPECT_NEAR(value, 0.5f, 1e-5f);
}

}  // namespace
}  // namespace weft
