// Kernels against their scalar forms, on every instruction set.
#include "tests/rpf/reference_kernels.h"
#include "tests/rpf/rpf_test.h"

namespace weft::rpf {
namespace {

Samples textured(int spp) {
    return feature_samples(
        24, 18, spp, [](const Drawn& d) { return 0.2f + 0.5f * d.l + (d.x > 11 ? 1.0f : 0.0f); },
        [](const Drawn& d) { return d.x > 11 ? 0.8f : 0.1f + 0.05f * d.u; });
}

// A pixel of the first `own` samples, about to look at the others.
Neighbourhoods alone(const SampleVectors& v, size_t own) {
    Neighbourhoods n;
    n.vectors = &v;
    n.block = {0, 0, 1, 1};
    n.own_pixels = {0};
    n.own_offset = {0, std::uint32_t(own)};
    for (size_t i = 0; i < own; ++i) n.sample.push_back(std::uint32_t(i));
    n.pitch = (v.size() + 15) / 16 * 16;
    return n;
}
struct Bounds {
    std::vector<float> centre, bound;
    explicit Bounds(const SampleVectors& v)
        : centre(v.stride() + 16, 0.0f),
          bound(v.stride() + 16, std::numeric_limits<float>::infinity()) {}
};
void take_near(const SampleVectors& v, const std::vector<std::uint32_t>& candidates,
               const Bounds& by, Neighbourhoods& n) {
    LayoutScratch scratch;
    DrawnSamples drawn;
    drawn.sample = candidates;
    drawn.extend(candidates.size(), PixelNear::some);
    WEFT_PICK(take_near)(v, drawn, by.centre.data(), by.bound.data(), scratch, n);
}

// A neighbourhood of everything.
Neighbourhoods everything(const SampleVectors& v, size_t own) {
    Neighbourhoods n = alone(v, own);
    std::vector<std::uint32_t> others;
    for (size_t i = own; i < v.size(); ++i) others.push_back(std::uint32_t(i));
    take_near(v, others, Bounds(v), n);
    return n;
}

Weights weights_of(const Neighbourhoods& n, float alpha, float beta) {
    Weights w;
    w.of_row.assign(n.rows(), 0.0f);
    for (size_t k = 0; k < n.vectors->components.size(); ++k)
        if (n.vectors->components[k].role == Role::feature)
            w.of_row[k] = beta * (1 + 0.1f * float(k % 3));
    for (size_t c = 0; c < 3; ++c) w.of_row[n.color_row(c)] = alpha;
    return w;
}

class Kernels : public testing::TestWithParam<Isa> {
  protected:
    PinnedIsa pinned{GetParam()};
};

TEST_P(Kernels, take_what_is_within_bounds) {
    const SampleVectors v = vectors_of(textured(3));
    Bounds by(v);
    for (size_t k = 7; k < v.components.size(); ++k) {
        by.centre[k] = v.of(100)[k];
        by.bound[k] = k % 2 ? 0.3f : 0.5f;
    }
    std::vector<std::uint32_t> candidates;
    for (size_t i = 0; i < v.size(); i += 2) candidates.push_back(std::uint32_t(i));
    Neighbourhoods n = alone(v, 3);
    take_near(v, candidates, by, n);
    const std::vector<std::uint32_t> own(n.sample.begin(), n.sample.begin() + 3),
        taken(n.sample.begin() + 3, n.sample.end());
    EXPECT_EQ(own, (std::vector<std::uint32_t>{0, 1, 2}));
    EXPECT_EQ(taken, reference::accept(v, candidates, by.centre.data(), by.bound.data()));
    EXPECT_GT(taken.size(), 10u);
    EXPECT_LT(taken.size(), candidates.size());
    Neighbourhoods none = alone(v, 3);
    take_near(v, {}, by, none);
    EXPECT_EQ(none.sample, own);
}

// Bounds around sample `of` of features that are compared, some of them.
Bounds around(const SampleVectors& v, size_t of, float far) {
    Bounds by(v);
    for (size_t k = v.bounds.first; k < v.components.size(); ++k) {
        by.centre[k] = v.of(of)[k];
        if (k % 3) by.bound[k] = far * (1 + 0.3f * float(k % 4));
    }
    return by;
}

TEST_P(Kernels, judge_pixels_as_their_samples_are) {
    Samples samples = feature_samples(
        45, 30, [](size_t pixel) { return pixel * 7 % 10; }, [](const Drawn& d) { return d.l; },
        [](const Drawn& d) { return d.x > 22 ? 0.8f : 0.3f + 0.1f * d.u; });
    std::vector<float> position(samples.values("position").begin(),
                                samples.values("position").end());
    position[3 * 500] = 100, position[3 * 501 + 1] = -100;  // far off all others
    samples.add("position", 3, position);
    const SampleVectors v = vectors_of(samples);
    ASSERT_FALSE(v.bounds.empty());
    std::array<size_t, 3> count{};
    for (size_t of = 0; of < v.size(); of += 97)
        for (const float far : {0.0f, 0.01f, 0.1f, 0.5f, 2.0f, 300.0f}) {
            const Bounds by = around(v, of, far);
            std::vector<NearCodes> codes;
            find_near_codes(v.bounds, by.centre, by.bound, codes);
            const size_t first = of % 40, n = samples.pixels() - first;
            std::vector<PixelNear> near((n + 63) / 64 * 64);
            WEFT_PICK(judge_pixels)(codes, first, n, near.data());
            for (size_t i = 0; i < n; ++i) {
                const auto [begin, end] = samples.of_pixel(first + i);
                std::vector<std::uint32_t> all;
                for (size_t j = begin; j < end; ++j) all.push_back(std::uint32_t(j));
                const size_t found =
                    reference::accept(v, all, by.centre.data(), by.bound.data()).size();
                if (near[i] != PixelNear::some) {
                    ASSERT_EQ(found, near[i] == PixelNear::all ? all.size() : 0u) << of << " " << i;
                }
                ++count[size_t(near[i])];
            }
        }
    for (const size_t n : count) EXPECT_GT(n, 4000u);
}

TEST_P(Kernels, take_the_same_whether_pixels_are_judged_or_not) {
    const SampleVectors v = vectors_of(textured(6));
    const Bounds by = around(v, 1300, 0.4f);
    std::vector<NearCodes> codes;
    find_near_codes(v.bounds, by.centre, by.bound, codes);
    for (const DrawRule rule : {DrawRule::gaussian, DrawRule::distinct}) {
        const DrawSettings settings{rule, 21, 900, 5.0f, 6, 7};
        const Places places = make_places(settings);
        const auto found = [&](std::span<const NearCodes> near) {
            DrawScratch scratch;
            DrawnSamples drawn;
            draw(v.samples, settings, places, {9, 8, 10, 9}, near, scratch, drawn);
            Neighbourhoods n = alone(v, 1);
            LayoutScratch layout;
            WEFT_PICK(take_near)(v, drawn, by.centre.data(), by.bound.data(), layout, n);
            return std::pair(n.sample, drawn.sample.size());
        };
        const auto [judged, few] = found(codes);
        const auto [all, many] = found({});
        EXPECT_EQ(judged, all);
        EXPECT_GT(all.size(), 50u);
        EXPECT_LT(few, many);
    }
}

TEST_P(Kernels, take_the_first_of_each_pixel) {
    const Samples samples = feature_samples(
        5, 2, [](size_t pixel) { return pixel * 7 % 40; }, [](const Drawn& d) { return d.l; },
        [](const Drawn&) { return 0.5f; });
    const std::vector<std::uint16_t> counts{3, 0, 5, 40, 9, 22};
    std::vector<std::uint32_t> taken(100), expected;
    taken.resize(size_t(WEFT_PICK(take_first)(samples, 2, counts, taken.data()) - taken.data()));
    for (size_t i = 0; i < counts.size(); ++i) {
        const auto [begin, end] = samples.of_pixel(2 + i);
        for (size_t j = begin; j < std::min(end, begin + counts[i]); ++j)
            expected.push_back(std::uint32_t(j));
    }
    EXPECT_EQ(taken, expected);
}

TEST_P(Kernels, take_any_of_each_pixel_as_often_as_asked) {
    const Samples samples = feature_samples(
        40, 30, [](size_t pixel) { return pixel % 9; }, [](const Drawn& d) { return d.l; },
        [](const Drawn&) { return 0.5f; });
    std::vector<std::uint16_t> counts;
    for (size_t i = 0; i < 1000; ++i) counts.push_back(std::uint16_t(i * 5 % 23));
    std::vector<std::uint32_t> taken(100000);
    std::vector<size_t> times(samples.size(), 0);
    for (std::uint32_t chance = 0; chance < 50; ++chance) {
        const auto* end = WEFT_PICK(take_any)(samples, 7, counts, chance * 77, taken.data());
        const std::uint32_t* next = taken.data();
        for (size_t i = 0; i < counts.size(); ++i) {
            const auto [first, last] = samples.of_pixel(7 + i);
            for (size_t k = 0; k < counts[i] && last > first; ++k) {
                ASSERT_GE(*next, first);
                ASSERT_LT(*next, last);
                ++times[*next++];
            }
        }
        ASSERT_EQ(next, end);
    }
    // As often as one another: chi-squared, over many pixels.
    double squares = 0, freedom = 0;
    for (size_t i = 0; i < counts.size(); ++i) {
        const auto [first, last] = samples.of_pixel(7 + i);
        if (last < first + 2 || counts[i] == 0) continue;
        const double expected = 50.0 * counts[i] / double(last - first);
        for (size_t j = first; j < last; ++j)
            squares += std::pow(double(times[j]) - expected, 2) / expected;
        freedom += double(last - first - 1);
    }
    EXPECT_NEAR(squares / freedom, 1, 5 * std::sqrt(2 / freedom));
}

TEST_P(Kernels, lay_out_rows_with_mean_and_deviation) {
    const SampleVectors v = vectors_of(textured(3));
    for (const size_t count : {1u, 7u, 16u, 129u, 1296u}) {
        Neighbourhoods n = alone(v, 1);
        std::vector<std::uint32_t> others;
        for (size_t i = 1; i < count; ++i) others.push_back(std::uint32_t(v.size() - i));
        take_near(v, others, Bounds(v), n);
        ASSERT_EQ(n.samples(), count);
        for (size_t k = 0; k < n.rows(); ++k) {
            double sum = 0, square = 0, low = 1e30, high = -1e30;
            for (size_t i = 0; i < count; ++i) {
                const float x = n.row(k)[i];
                ASSERT_EQ(x, v.of(n.sample[i])[k]);
                sum += double(x);
                low = std::min(low, double(x));
                high = std::max(high, double(x));
            }
            const double mean = sum / double(count);
            for (size_t i = 0; i < count; ++i) square += std::pow(double(n.row(k)[i]) - mean, 2);
            const double deviation = std::sqrt(square / std::max(1.0, double(count) - 1));
            EXPECT_NEAR(n.mean[k], mean, 1e-6 * std::max(1.0, std::abs(mean)));
            if (n.scale[k] > 0) {
                EXPECT_NEAR(n.scale[k] * deviation, 1, 1e-5) << k;
                EXPECT_NEAR(n.low[k], (low - mean) / deviation, 1e-4);
                EXPECT_NEAR(n.high[k], (high - mean) / deviation, 1e-4);
            } else {
                EXPECT_LE(deviation, 1e-6 * std::max(1.0, std::abs(mean))) << k;
            }
            for (size_t i = count; i < (count + 3) / 4 * 4; ++i) EXPECT_EQ(n.row(k)[i], 0.0f);
        }
    }
}

TEST_P(Kernels, filter_as_defined) {
    const Samples samples = textured(3);
    const SampleVectors v = vectors_of(samples);
    const Neighbourhoods n = everything(v, 7);
    const Weights w = weights_of(n, 0.7f, 0.2f);
    FilterScratch scratch;
    SampleColors out;
    out.take_own(n, samples);
    const Likeness by{1.3f, 6};
    WEFT_PICK(filter)(n, w, samples.rgb().data(), by, scratch, out);
    for (size_t i = 0; i < 7; ++i) {
        const auto exact = reference::filter(n, w, samples.rgb().data(), by, i);
        for (size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(out.rgb[3 * i + c], exact[c], 2e-5 * std::max(1.0, exact[c])) << i;
        EXPECT_GE(out.effective[i], 1.0f - 1e-4f);
        EXPECT_LE(out.effective[i], float(n.samples()));
    }
}

TEST_P(Kernels, weigh_pixels_as_defined) {
    Samples samples = textured(3);
    const SampleVectors v = vectors_of(samples);
    const Neighbourhoods n = everything(v, 4);
    const Weights w = weights_of(n, 0.9f, 0.6f);
    PixelLikeness by;
    by.radius = 4;
    PixelScratch scratch;
    std::vector<float> weights;
    for (const PixelBlock block :
         {PixelBlock{0, 0, 3, 2}, PixelBlock{10, 8, 13, 10}, PixelBlock{22, 17, 24, 18}}) {
        WEFT_PICK(weigh_pixels)(v, block, w, by, scratch, weights);
        const float* of = weights.data();
        for (int y = block.y0; y < block.y1; ++y)
            for (int x = block.x0; x < block.x1; ++x, of += by.size())
                for (int dy = -4; dy <= 4; ++dy)
                    for (int dx = -4; dx <= 4; ++dx) {
                        const double exact = reference::weigh_pixel(v, w, by, x, y, dx, dy);
                        EXPECT_NEAR(of[size_t(dy + 4) * by.pitch() + size_t(dx + 4)], exact,
                                    1e-4 * exact + 1e-6)
                            << x << " " << y << " " << dx << " " << dy;
                    }
    }
}

TEST_P(Kernels, average_pixels_and_their_samples_alike) {
    const Samples samples = textured(4);
    const SampleVectors v = vectors_of(samples);
    const Neighbourhoods n = everything(v, 4);
    PixelLikeness by;
    PixelScratch scratch;
    std::vector<float> weights;
    WEFT_PICK(weigh_pixels)(v, {12, 9, 13, 10}, weights_of(n, 1, 1), by, scratch, weights);
    float pixels[3], each[3], effective_pixels, effective_each;
    const std::vector<float> none(16, 0.0f);
    WEFT_PICK(average_pixels)(v, 12, 9, by, weights.data(), pixels, &effective_pixels);
    AroundScratch around;
    const std::vector<std::uint32_t> own = {0};
    WEFT_PICK(average_samples)
    (v, samples.rgb().data(), own, 12, 9, by, weights.data(), none, around, each, &effective_each);
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(pixels[c], each[c], 2e-4f);
    EXPECT_NEAR(effective_pixels / effective_each, 1, 0.01);
}

TEST_P(Kernels, average_samples_by_their_features_as_one_by_one) {
    const Samples samples = textured(4);
    const SampleVectors v = vectors_of(samples);
    const Neighbourhoods n = everything(v, 4);
    const PixelLikeness by;
    PixelScratch scratch;
    std::vector<float> weights;
    WEFT_PICK(weigh_pixels)(v, {0, 9, 1, 10}, weights_of(n, 1, 1), by, scratch, weights);
    const size_t features = v.components.size() - v.pixels.first;
    std::vector<float> factors((features + 15) / 16 * 16, 0.0f);
    for (size_t k = 0; k < features; ++k) factors[k] = k % 3 == 1 ? 0.0f : 2 + float(k);
    const auto [begin, end] = samples.of_pixel(9 * size_t(samples.width));
    std::vector<std::uint32_t> own;
    for (size_t i = begin; i < end; ++i) own.push_back(std::uint32_t(i));
    std::vector<float> rgb(3 * own.size()), effective(own.size());
    AroundScratch around;
    WEFT_PICK(average_samples)
    (v, samples.rgb().data(), own, 0, 9, by, weights.data(), factors, around, rgb.data(),
     effective.data());
    for (size_t o = 0; o < own.size(); ++o) {
        double w_sum = 0, ww_sum = 0, sum[3] = {};
        for (int y = 0; y < samples.height; ++y)
            for (int x = 0; x < samples.width; ++x) {
                if (std::abs(x) > by.radius || std::abs(y - 9) > by.radius) continue;
                const float pixel =
                    weights[size_t(y - 9 + by.radius) * by.pitch() + size_t(x + by.radius)];
                if (!(pixel > 1e-4f)) continue;
                const auto [from, to] = samples.of_pixel(size_t(y * samples.width + x));
                for (size_t j = from; j < to; ++j) {
                    double distance = 0;
                    for (size_t k = 0; k < features; ++k)
                        distance +=
                            std::pow(double(factors[k]) * double(v.of(j)[v.pixels.first + k] -
                                                                 v.of(own[o])[v.pixels.first + k]),
                                     2);
                    if (distance > 12) continue;
                    const double w = double(pixel) * std::exp(-distance);
                    w_sum += w;
                    ww_sum += w * w;
                    for (size_t c = 0; c < 3; ++c) sum[c] += w * double(samples.rgb()[3 * j + c]);
                }
            }
        for (size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(rgb[3 * o + c], sum[c] / w_sum, 1e-4 * std::abs(sum[c] / w_sum)) << o;
        EXPECT_NEAR(effective[o], w_sum * w_sum / ww_sum, 1e-3 * double(effective[o])) << o;
    }
}

INSTANTIATE_TEST_SUITE_P(All, Kernels, testing::ValuesIn(instruction_sets()),
                         [](const auto& isa) { return std::string(name_of(isa.param)); });

}  // namespace
}  // namespace weft::rpf
