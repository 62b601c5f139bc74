// filter-visible's view-test: a surface whose radiance depends on where on the lens and when it is
// seen.
#include <fmt/format.h>

#include "tests/light-field/light_field_test.h"

namespace weft {
namespace {

// A plane out of focus that fills the picture, lit by `radiance` of (u, v, t) and `noise`; 8
// samples a pixel.
struct Plane {
    int width = 40, height = 30, spp = 8;
    float slope = 3, noise = 0;

    template <class Radiance>
    Samples samples(const Radiance& radiance) const {
        std::mt19937 random(7);
        std::uniform_real_distribution<float> unit(0, 1);
        Samples s;
        s.width = width;
        s.height = height;
        s.spp = spp;
        s.lens = Lens{-32, 4};
        const size_t n = s.pixels() * size_t(spp);
        std::vector<float> xy, uv, t, rgb;
        for (size_t i = 0; i < n; ++i) {
            const size_t pixel = i / size_t(spp);
            xy.insert(xy.end(), {float(pixel % size_t(width)) + unit(random),
                                 float(pixel / size_t(width)) + unit(random)});
            const float r = std::sqrt(unit(random)), a = 6.2831853f * unit(random);
            uv.insert(uv.end(), {r * std::cos(a), r * std::sin(a)});
            t.push_back(unit(random));
            const float light =
                radiance(uv[2 * i], uv[2 * i + 1], t[i]) + noise * (unit(random) - 0.5f);
            rgb.insert(rgb.end(), {light, light, light});
        }
        s.set_size(n);
        s.add("xy", 2, xy);
        s.add("uv", 2, uv);
        s.add("t", 1, t);
        s.add("z", 1, std::vector<float>(n, 32 / (4 - slope)));
        s.add("motion", 3, std::vector<float>(3 * n, 0.0f));
        s.add("rgb", 3, rgb);
        return s;
    }
};

// What place (u, v) on the lens sees at time t, as filter-visible has it.
Image seen_from(const Samples& samples, float u, float v, float t, float view_test) {
    const TestFolder folder;
    PlainContext ctx;
    write_npz(samples, folder / "samples.npz", false, ctx);
    return GraphRun(fmt::format(R"({{"weft": 1, "nodes": {{
        "samples":   {{"type": "read-samples", "set": {{"file": "{}"}}}},
        "hierarchy": {{"type": "build-hierarchy", "in": {{"samples": "samples"}}}},
        "locations": {{"type": "output-locations", "in": {{"hierarchy": "hierarchy"}},
                       "set": {{"per-pixel": 16, "lens": "fixed", "u": {}, "v": {}, "time": "fixed", "t": {}}}}},
        "reproject": {{"type": "reproject", "in": {{"locations": "locations", "hierarchy": "hierarchy"}}}},
        "surfaces":  {{"type": "same-surface-cluster", "in": {{"candidates": "reproject.candidates"}}}},
        "coverage":  {{"type": "coverage", "in": {{"candidates": "reproject.candidates", "surfaces": "surfaces", "locations": "locations"}}}},
        "filter":    {{"type": "filter-visible", "in": {{"candidates": "reproject.candidates", "surfaces": "surfaces", "visibility": "coverage.visibility"}},
                       "set": {{"view-test": {}}}}},
        "picture":   {{"type": "accumulate", "in": {{"colors": "filter", "locations": "locations"}}}},
        "write":     {{"type": "write-image", "in": {{"image": "picture"}}, "set": {{"file": "OUT", "depth": "float"}}}}}}}})",
                                folder / "samples.npz", u, v, t, view_test))
        .picture;
}

// Of pixels in which a location is decided: the others are a second pass's business.
double rms(const Image& image, float expected) {
    double sum = 0, n = 0;
    for (int y = 0; y < image.height(); ++y)
        for (int x = 0; x < image.width(); ++x)
            if (const float is = image.at(x, y)[0]; is != 0)
                sum += std::pow(double(is) - double(expected), 2), ++n;
    EXPECT_GT(n, 0.6 * image.width() * image.height());
    return std::sqrt(sum / n);
}

TEST(ViewFilter, ReadsAReflectionWhereItIsLookedAtFrom) {
    const auto gloss = [](float u, float v, float t) {
        return 2 + u + 0.5f * v - 0.8f * (t - 0.5f);
    };
    const Samples samples = Plane{.noise = 0.1f}.samples(gloss);
    for (const auto& [u, v, t] :
         {std::tuple{0.0f, 0.0f, 0.5f}, {0.6f, 0.0f, 0.2f}, {-0.5f, 0.5f, 0.9f}}) {
        const double averaged = rms(seen_from(samples, u, v, t, 0), gloss(u, v, t)),
                     read = rms(seen_from(samples, u, v, t, 3), gloss(u, v, t));
        EXPECT_LT(read, 0.12) << u << " " << v << " " << t;
        EXPECT_LT(read, 0.25 * averaged + 0.05) << u << " " << v << " " << t;
    }
}

TEST(ViewFilter, LeavesNoiseToTheMean) {
    const Samples samples = Plane{.noise = 1}.samples([](float, float, float) { return 2.0f; });
    const double averaged = rms(seen_from(samples, 0.3f, 0, 0.5f, 0), 2),
                 read = rms(seen_from(samples, 0.3f, 0, 0.5f, 4), 2);
    EXPECT_LT(read, 1.15 * averaged);
}

TEST(ViewFilter, OfAConstantIsThatConstant) {
    const Samples samples = Plane{}.samples([](float, float, float) { return 0.25f; });
    EXPECT_LT(rms(seen_from(samples, 0.9f, 0, 0.1f, 1), 0.25f), 1e-5);
}

// With a test that nothing passes the mean is left, and both ways of taking it agree.
TEST(ViewFilter, AgreesWithTheFastFilterWhereNothingDependsOnTheView) {
    for (const Kind_of kind :
         {Kind_of::still_pinhole, Kind_of::defocused, Kind_of::moving_in_depth}) {
        const Samples samples = random_samples(24, 20, 3, kind);
        const auto fast = values_of(seen_from(samples, 0, 0, 0.5f, 0)),
                   slow = values_of(seen_from(samples, 0, 0, 0.5f, 1e6f));
        ASSERT_EQ(fast.size(), slow.size());
        for (size_t i = 0; i < fast.size(); ++i) EXPECT_NEAR(fast[i], slow[i], 2e-5f) << i;
    }
}

}  // namespace
}  // namespace weft
