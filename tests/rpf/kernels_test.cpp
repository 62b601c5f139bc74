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

// A neighbourhood of everything, normalised.
Neighbourhoods everything(const SampleVectors& v, size_t own) {
    Neighbourhoods n;
    n.vectors = &v;
    n.block = {0, 0, 1, 1};
    n.own_pixels = {0};
    n.own_offset = {0, std::uint32_t(own)};
    for (size_t i = 0; i < v.size(); ++i) n.sample.push_back(std::uint32_t(i));
    n.pitch = (n.samples() + 15) / 16 * 16;
    n.values.assign(n.rows() * n.pitch, 0.0f);
    n.mean.resize(n.rows());
    n.scale.resize(n.rows());
    n.low.resize(n.rows());
    n.high.resize(n.rows());
    WEFT_PICK(lay_out)(v.values.data(), v.stride, n.sample, n.pitch, n.values.data());
    for (size_t i = 0; i < n.samples(); ++i)
        for (size_t c = 0; c < 3; ++c)
            n.values[n.color_row(c) * n.pitch + i] = v.samples.rgb()[3 * i + c];
    WEFT_PICK(normalise)
    (n.values.data(), n.rows(), n.samples(), n.pitch, n.mean.data(), n.scale.data(), n.low.data(),
     n.high.data());
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

TEST_P(Kernels, accept_what_is_within_bounds) {
    const SampleVectors v = vectors_of(textured(3));
    std::vector<float> centre(v.stride + 16, 0.0f),
        bound(v.stride + 16, std::numeric_limits<float>::infinity());
    for (size_t k = 7; k < v.components.size(); ++k) {
        centre[k] = v.of(100)[k];
        bound[k] = k % 2 ? 0.3f : 0.5f;
    }
    std::vector<std::uint32_t> candidates, accepted(v.size());
    for (size_t i = 0; i < v.size(); i += 2) candidates.push_back(std::uint32_t(i));
    accepted.resize(WEFT_PICK(accept)(v, candidates, centre.data(), bound.data(), accepted.data()));
    EXPECT_EQ(accepted, reference::accept(v, candidates, centre.data(), bound.data()));
    EXPECT_GT(accepted.size(), 10u);
    EXPECT_LT(accepted.size(), candidates.size());
}

TEST_P(Kernels, normalise_to_mean_zero_and_deviation_one) {
    const SampleVectors v = vectors_of(textured(3));
    const Neighbourhoods n = everything(v, 4);
    for (size_t k = 0; k < n.rows(); ++k) {
        if (k >= v.components.size() && k < v.stride) continue;  // only there to fill
        double sum = 0, square = 0;
        for (size_t i = 0; i < n.samples(); ++i) {
            sum += double(n.row(k)[i]);
            square += double(n.row(k)[i]) * double(n.row(k)[i]);
            EXPECT_GE(n.row(k)[i], n.low[k] - 1e-3f);
            EXPECT_LE(n.row(k)[i], n.high[k] + 1e-3f);
        }
        EXPECT_NEAR(sum / double(n.samples()), 0, 1e-3) << k;
        EXPECT_NEAR(square / double(n.samples() - 1), n.scale[k] > 0 ? 1 : 0, 1e-3) << k;
        for (size_t i = n.samples(); i < n.pitch; ++i) EXPECT_EQ(n.row(k)[i], 0.0f);
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
    WEFT_PICK(average_samples)
    (v, samples.rgb().data(), 0, 12, 9, by, weights.data(), none, each, &effective_each);
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(pixels[c], each[c], 2e-4f);
    EXPECT_NEAR(effective_pixels / effective_each, 1, 0.01);
}

INSTANTIATE_TEST_SUITE_P(All, Kernels, testing::ValuesIn(instruction_sets()),
                         [](const auto& isa) { return std::string(name_of(isa.param)); });

}  // namespace
}  // namespace weft::rpf
