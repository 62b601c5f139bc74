// What is said of bad values, and what becomes of them.
#include "samples/check_samples.h"

#include "sample_files.h"

namespace weft::testing {
namespace {

// 10 x 10 pixels of 4 samples, all good; `change` spoils some of one channel's values.
struct Spoiled {
    Samples samples = small_buffer(10, 10, 4);
    PlainContext ctx;

    template <class Change>
    void change(const std::string& name, Change&& change) {
        const Channel* c = samples.find(name);
        std::vector<float> values(c->values.view().begin(), c->values.view().end());
        change(values);
        const int components = c->components;
        samples.add(name, components, std::move(values));
    }
    void set(const std::string& name, size_t index, float value) {
        change(name, [&](std::vector<float>& values) { values[index] = value; });
    }
    void check(double tolerate = 0.01) { check_samples(samples, "a.npz", tolerate, ctx); }
    std::string warning() const { return ctx.warnings.empty() ? "" : ctx.warnings.back(); }
};

TEST(BadValues, good_samples_are_left_where_they_are) {
    Spoiled s;
    const float* before = s.samples.rgb().data();
    s.check();
    EXPECT_TRUE(s.ctx.warnings.empty());
    EXPECT_EQ(s.samples.rgb().data(), before);
    EXPECT_EQ(s.samples.spp, 4);
}

TEST(BadValues, radiance_that_is_no_number_is_dropped) {
    Spoiled s;
    s.set("rgb", 3 * 41 + 1, nan);
    s.set("rgb", 3 * 77, inf);
    const Samples before = s.samples;
    s.check(0);  // not held against the buffer
    ASSERT_EQ(s.ctx.warnings.size(), 1u);
    EXPECT_SAYS(s.warning(),
                "a.npz: rgb: radiance is NaN or infinite in 2 samples; first: pixel (0, 1), "
                "sample 1, rgb = (");
    EXPECT_SAYS(s.warning(), ", nan, ");
    EXPECT_SAYS(s.warning(), "(dropped)");
    EXPECT_EQ(s.samples.size(), 398u);
    EXPECT_EQ(s.samples.spp, 0);
    EXPECT_EQ(s.samples.of_pixel(9).end, 40u);
    EXPECT_EQ(s.samples.of_pixel(10).end, 43u);
    EXPECT_EQ(s.samples.of_pixel(19).end, 78u);
    EXPECT_EQ(s.samples.of_pixel(99).end, 398u);
    EXPECT_EQ(s.samples.xy()[2 * 41],
              before.xy()[2 * 42]);  // the others moved up, in every channel
    EXPECT_EQ(s.samples.z()[76], before.z()[78]);
}

TEST(BadValues, negative_radiance_is_kept) {
    Spoiled s;
    for (size_t i = 0; i < 50; ++i) s.set("rgb", 3 * i, -1);
    s.check();
    ASSERT_EQ(s.ctx.warnings.size(), 1u);
    EXPECT_SAYS(s.warning(),
                "rgb: radiance is negative in 50 samples; first: pixel (0, 0), sample 0");
    EXPECT_SAYS(s.warning(), "(kept)");
    EXPECT_EQ(s.samples.size(), 400u);
}

TEST(BadValues, depth_must_be_above_zero) {
    for (const float bad : {0.0f, -1.0f, nan, -inf}) {
        Spoiled s;
        s.set("z", 399, bad);
        s.check();
        EXPECT_SAYS(s.warning(),
                    "z: depth is NaN or not above 0 in 1 sample; first: pixel (9, 9), sample 3");
        EXPECT_EQ(s.samples.size(), 399u);
    }
}

TEST(BadValues, infinite_depth_is_background) {
    Spoiled s;
    s.change("z", [](std::vector<float>& z) { z.assign(z.size(), inf); });
    s.check();
    EXPECT_TRUE(s.ctx.warnings.empty());
}

TEST(BadValues, lens_positions_lie_in_the_disk) {
    Spoiled s;
    s.set("uv", 0, 1.0005f);
    s.set("uv", 1, 0);
    s.check();
    EXPECT_TRUE(s.ctx.warnings.empty());
    s.set("uv", 0, 0.8f);
    s.set("uv", 1, -0.8f);
    s.check();
    EXPECT_SAYS(s.warning(),
                "uv: lens position lies outside the unit disk in 1 sample; first: pixel (0, 0), "
                "sample 0, uv = (0.8, -0.8) (dropped)");
}

TEST(BadValues, a_light_is_a_square_without_pixels) {
    Spoiled s;
    s.samples.domain = "light";
    s.set("uv", 0, 0.99f);
    s.set("uv", 1, -0.99f);
    s.set("xy", 0, -100);
    s.check();
    EXPECT_TRUE(s.ctx.warnings.empty());
    s.set("uv", 3, 1.01f);
    s.check();
    EXPECT_SAYS(s.warning(),
                "uv: position on the light lies outside [-1, 1] in 1 sample; first: sample 1,");
    EXPECT_EQ(s.samples.size(), 399u);
}

TEST(BadValues, time_lies_in_the_shutter) {
    for (const float bad : {-0.001f, 1.001f, nan}) {
        Spoiled s;
        s.set("t", 5, bad);
        s.check();
        EXPECT_SAYS(s.warning(),
                    "t: time lies outside [0, 1] in 1 sample; first: pixel (1, 0), sample 1, t = ");
    }
}

TEST(BadValues, positions_may_be_a_pixel_outside_their_pixel) {
    Spoiled s;
    s.set("xy", 2 * 222, 4.1f);  // pixel (5, 5)
    s.set("xy", 2 * 222 + 1, 6.9f);
    s.check();
    EXPECT_TRUE(s.ctx.warnings.empty());
    s.set("xy", 2 * 222, 3.9f);
    s.check();
    EXPECT_SAYS(s.warning(),
                "xy: position lies more than a pixel outside its pixel in 1 sample; first: pixel "
                "(5, 5), sample 2, xy = (3.9, 6.9) (dropped)");
}

TEST(BadValues, motion_alpha_and_weight_are_numbers) {
    for (const char* name : {"motion", "alpha", "weight"}) {
        Spoiled s;
        s.samples.add("alpha", 1, std::vector<float>(400, 1));
        s.samples.add("weight", 1, std::vector<float>(400, 1));
        s.set(name, 0, inf);
        s.check();
        EXPECT_SAYS(s.warning(), std::string(name) + ": value is NaN or infinite in 1 sample");
        EXPECT_EQ(s.samples.size(), 399u);
    }
}

TEST(BadValues, nan_in_other_channels_is_kept_and_told) {
    Spoiled s;
    s.samples.add("normal", 3, std::vector<float>(1200, 0.5f));
    s.set("normal", 7, nan);
    s.check();
    EXPECT_SAYS(s.warning(), "normal: value is NaN in 1 sample; first: pixel (0, 0), sample 2");
    EXPECT_SAYS(s.warning(), "(kept)");
}

TEST(BadValues, more_than_is_tolerated_is_an_error) {
    Spoiled s;
    for (size_t i = 0; i < 4; ++i) s.set("z", 10 * i, 0);
    Spoiled t = s;
    s.check();  // 1 % exactly
    EXPECT_EQ(s.samples.size(), 396u);
    t.set("z", 50, 0);
    t.set("t", 51, 2);
    const std::string message = error_of([&] { t.check(); });
    EXPECT_SAYS(message,
                "a.npz: 6 of 400 samples (1.5 %) cannot be used, more than the 1 % tolerated. ");
    EXPECT_SAYS(
        message,
        "z: depth is NaN or not above 0 in 5 samples; first: pixel (0, 0), sample 0, z = 0");
    EXPECT_SAYS(message,
                "t: time lies outside [0, 1] in 1 sample; first: pixel (2, 1), sample 3, t = 2");
    EXPECT_SAYS(message, "set 'tolerate' of read-samples higher");
    t.check(0.02);
    EXPECT_EQ(t.samples.size(), 394u);
}

TEST(BadValues, nothing_left_is_an_error) {
    Spoiled s;
    s.change("rgb", [](std::vector<float>& rgb) { rgb.assign(rgb.size(), nan); });
    EXPECT_SAYS(error_of([&] { s.check(1); }), "a.npz: no sample can be used");
}

TEST(BadValues, buffers_with_varying_counts_are_compacted_too) {
    Samples s;
    s.width = 3;
    s.height = 1;
    s.first = std::vector<std::uint64_t>{0, 2, 2, 3};
    s.add("xy", 2, {.5f, .5f, .25f, .5f, 2.5f, .5f});
    s.add("rgb", 3, {1, 1, 1, nan, 1, 1, 2, 2, 2});
    s.add_ids("id", {7, 8, 9});
    PlainContext ctx;
    check_samples(s, "a.npz", 0.01, ctx);
    EXPECT_SAYS(ctx.warnings.at(0), "pixel (0, 0), sample 1");
    EXPECT_TRUE(std::ranges::equal(s.first.view(), std::vector<std::uint64_t>{0, 1, 1, 2}));
    EXPECT_TRUE(std::ranges::equal(s.find("id")->ids.view(), std::vector<std::uint32_t>{7, 9}));
    EXPECT_EQ(s.rgb()[3], 2);
}

TEST(BadValues, findings_are_the_same_however_the_work_is_split) {
    // More samples than one piece of work, with faults on both sides of the seams.
    Samples many = small_buffer(256, 256, 4);
    std::vector<float> z(many.z().begin(), many.z().end());
    for (const size_t i :
         {size_t{2047}, size_t{2048}, size_t{65535}, size_t{65536}, size_t{262143}})
        z[i] = 0;
    many.add("z", 1, z);
    struct Backwards : PlainContext {
        void parallel(size_t count, size_t grain,
                      const std::function<void(size_t, size_t)>& work) override {
            for (size_t begin = (count - 1) / grain * grain;; begin -= grain) {
                work(begin, std::min(count, begin + grain));
                if (begin == 0) break;
            }
        }
    };
    Samples again = many;
    PlainContext forwards;
    Backwards backwards;
    check_samples(many, "a.npz", 0.01, forwards);
    check_samples(again, "a.npz", 0.01, backwards);
    expect_equal(many, again);
    EXPECT_EQ(forwards.warnings, backwards.warnings);
    EXPECT_SAYS(forwards.warnings.at(0), "in 5 samples; first: pixel (255, 1), sample 3");
}

}  // namespace
}  // namespace weft::testing
