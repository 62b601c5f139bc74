// Axis-aligned filtering of shadows: widths and counts by hand, filters that keep what they must,
// and visibility against what is exact.
#include <random>

#include "tests/shadows/shadow_test.h"
#include "tests/shadows/visibility_test.h"

namespace weft {
namespace {

// Bounds of one occluder at d2 of d1 = 10, under a light of half extent 1; a pixel is 0.02 wide.
Image bounds_of(double d2, float count = 9, int width = 1) {
    Image bounds(width, 1, {"s-lo", "s-hi", "count", "pixel"});
    for (int x = 0; x < width; ++x) {
        float* b = bounds.at(x, 0);
        b[0] = b[1] = float(10 / d2 - 1), b[2] = count, b[3] = 0.02f;
    }
    return bounds;
}
Image receivers_on_a_line(int width, float step) {
    Image receivers(
        width, 1,
        {"position.x", "position.y", "position.z", "normal.x", "normal.y", "normal.z", "id"});
    for (int x = 0; x < width; ++x) {
        float* r = receivers.at(x, 0);
        r[0] = float(x) * step, r[2] = 10, r[5] = -1;
    }
    return receivers;
}
LightView unit_light() {
    LightView view;
    view.name = "key";
    return view;
}
Image width_of(const Image& bounds, const Image& receivers, const LightView& view = unit_light(),
               const char* port = "width") {
    return RunNode("axis-aligned-width")
        .in("bounds", bounds)
        .in("receivers", receivers)
        .in("light-view", view)
        .out<Image>(port);
}

TEST(AxisAlignedWidth, widths_and_counts_are_those_worked_out_by_hand) {
    struct {
        double d2, beta, n;
    } const table[] = {{2, 1, 1.7424}, {5, 0.25, 12.1104}, {8, 0.0625, 45.1584}};
    for (const auto& row : table) {
        const Image receivers = receivers_on_a_line(1, 0.02f);
        const Image width = width_of(bounds_of(row.d2), receivers);
        EXPECT_NEAR(width.at(0, 0)[width.find("beta")], row.beta, 1e-6 * row.beta);
        EXPECT_NEAR(width.at(0, 0)[width.find("samples")], row.n, 1e-6 * row.n);
        EXPECT_NEAR(width.at(0, 0)[width.find("radius")], std::min(row.beta / 0.02, 64.0), 1e-4);
        const Image counts = width_of(bounds_of(row.d2), receivers, unit_light(), "counts");
        EXPECT_EQ(*counts.at(0, 0), float(std::max(9.0, std::ceil(row.n))));
        const Image more = width_of(bounds_of(row.d2), receivers, unit_light(), "more");
        EXPECT_EQ(*more.at(0, 0), *counts.at(0, 0) - 9);
    }
}

TEST(AxisAlignedWidth, more_rays_than_needed_make_it_narrower_by_their_fourth_root) {
    const Image receivers = receivers_on_a_line(1, 0.02f);
    const float enough = *width_of(bounds_of(5, 12), receivers).at(0, 0),
                many = *width_of(bounds_of(5, float(12.1104 * 16)), receivers).at(0, 0);
    EXPECT_NEAR(enough, 0.25, 1e-6);
    EXPECT_NEAR(many, 0.125, 1e-5);
}

TEST(AxisAlignedWidth, nothing_is_filtered_where_nothing_is_in_the_way_or_the_light_is_a_point) {
    Image bounds = bounds_of(5);
    bounds.at(0, 0)[0] = INFINITY, bounds.at(0, 0)[1] = 0;
    EXPECT_EQ(*width_of(bounds, receivers_on_a_line(1, 0.02f)).at(0, 0), 0.0f);
    LightView point = unit_light();
    point.shape = LightView::Shape::point, point.ax = point.ay = 0;
    const float beta = *width_of(bounds_of(5), receivers_on_a_line(1, 0.02f), point).at(0, 0);
    EXPECT_NEAR(beta, 0.04, 1e-6);  // p (1 + s2): nothing but the pixel
}

TEST(AxisAlignedWidth, depends_on_no_unit) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 50; ++i) {
        const double scale = std::exp(8 * unit(random) - 4);
        Image bounds = bounds_of(1 + 8 * unit(random));
        const Image one = width_of(bounds, receivers_on_a_line(1, 0.02f));
        LightView view = unit_light();
        view.ax *= scale, view.ay *= scale;
        bounds.at(0, 0)[3] *= float(scale);
        const Image other = width_of(bounds, receivers_on_a_line(1, 0.02f), view);
        EXPECT_NEAR(*other.at(0, 0) / scale, *one.at(0, 0), 1e-5 * *one.at(0, 0));
        EXPECT_NEAR(other.at(0, 0)[4], one.at(0, 0)[4], 1e-4 * one.at(0, 0)[4]);
    }
}

// A row of pixels filtered as a shadow on a line, 0.02 apart.
Image filtered(const Image& image, const Image& width, const Image& receivers) {
    return RunNode("axis-aligned-filter")
        .in("image", image)
        .in("width", width)
        .in("features", receivers)
        .out<Image>("image");
}

TEST(AxisAlignedFilter, keeps_a_constant_to_the_bit_and_a_ramp_away_from_its_ends) {
    constexpr int n = 401;
    const Image receivers = receivers_on_a_line(n, 0.02f);
    const Image width = width_of(bounds_of(2, 1, n), receivers);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(0, 1);
    for (int i = 0; i < 20; ++i) {
        Image image(n, 1, 1);
        const float value = unit(random);
        for (int x = 0; x < n; ++x) *image.at(x, 0) = value;
        const Image out = filtered(image, width, receivers);
        for (const float kept : out.pixels()) ASSERT_EQ(kept, value);
    }
    Image ramp(n, 1, 1);
    for (int x = 0; x < n; ++x) *ramp.at(x, 0) = float(x) / n;
    const Image out = filtered(ramp, width, receivers);
    for (int x = 51; x < n - 51; ++x) EXPECT_NEAR(*out.at(x, 0), *ramp.at(x, 0), 1e-6);
}

TEST(AxisAlignedFilter, blurs_the_ramp_of_an_edge_by_two_per_cent_at_most) {
    constexpr int n = 1001;
    const Image receivers = receivers_on_a_line(n, 0.02f);
    for (const auto& [d2, most] : {std::pair{2.0, 0.0205}, {5.0, 0.0205}, {8.0, 0.0125}}) {
        const Image width = width_of(bounds_of(d2, 1, n), receivers);
        Image exact(n, 1, 1);
        for (int x = 0; x < n; ++x)
            *exact.at(x, 0) = float(past_edge_quad(0.02 * (x - n / 2), 0, 10, d2));
        const Image out = filtered(exact, width, receivers);
        float worst = 0;
        for (int x = 0; x < n; ++x)
            worst = std::max(worst, std::abs(*out.at(x, 0) - *exact.at(x, 0)));
        EXPECT_LT(worst, most) << d2;
        EXPECT_GT(worst, 0.005) << d2;
    }
}

TEST(AxisAlignedFilter, does_not_mix_surfaces) {
    constexpr int n = 101;
    Image receivers = receivers_on_a_line(n, 0.02f);
    const Image width = width_of(bounds_of(2, 1, n), receivers);
    Image image(n, 1, 1);
    for (int x = 0; x < n; ++x) *image.at(x, 0) = x < n / 2 ? 0.0f : 1.0f;
    const std::vector<float> own(image.pixels().begin(), image.pixels().end());
    const auto kept = [&](const Image& features) {
        const Image out = filtered(image, width, features);
        return std::vector<float>(out.pixels().begin(), out.pixels().end()) == own;
    };
    EXPECT_FALSE(kept(receivers));
    Image ids = receivers, normals = receivers, planes = receivers;
    for (int x = n / 2; x < n; ++x) {
        ids.at(x, 0)[6] = 7;
        normals.at(x, 0)[3] = 0.5f, normals.at(x, 0)[5] = -0.8660254f;  // by 30 degrees
        planes.at(x, 0)[2] = 8.9f;
    }
    EXPECT_TRUE(kept(ids));
    EXPECT_TRUE(kept(normals));
    EXPECT_TRUE(kept(planes));
}

TEST(OccluderBounds, finds_the_slope_of_what_is_in_the_way) {
    KnownShadow known;
    known.occluder = half_plane(0);
    const SeenShadow seen(known);
    const Image bounds = seen.bounds("bounds"), receivers = seen.bounds("receivers"),
                visibility = seen.bounds("visibility");
    int shadowed = 0, spread = 0;
    for (int x = 0; x < known.width; ++x) {
        const float* b = bounds.at(x, 4);
        EXPECT_EQ(b[2], float(known.spp));
        EXPECT_NEAR(b[3], 2 * known.half_width / known.width, 1e-3);
        EXPECT_NEAR(receivers.at(x, 4)[2], 10, 1e-4);
        EXPECT_NEAR(std::abs(receivers.at(x, 4)[0]), std::abs(ground_x(known, x)), 1e-3);
        if (!(b[0] < INFINITY)) {
            EXPECT_EQ(*visibility.at(x, 4), 1.0f);
            continue;
        }
        ++shadowed;
        spread += *visibility.at(x, 4) == 1.0f;
        EXPECT_NEAR(b[0], 10.0 / 6 - 1, 1e-3);
        EXPECT_NEAR(b[1], 10.0 / 6 - 1, 1e-3);
    }
    EXPECT_GT(shadowed, known.width * 2 / 3);
    EXPECT_LT(shadowed, known.width);
    EXPECT_GE(spread, 5);  // rims that saw no occluder take their neighbours'
}

TEST(OccluderBounds, two_depths_are_two_slopes) {
    KnownShadow known;
    known.occluder =
        half_plane(0) +
        R"(, {"shape": "plane", "material": "grey", "at": [-40, 8, 0], "scale": [40, 1, 40]})";
    const Image bounds = SeenShadow(known).bounds("bounds");
    int both = 0;
    for (int x = 0; x < known.width; ++x) {
        const float* b = bounds.at(x, 4);
        if (!(b[0] < b[1])) continue;
        ++both;
        EXPECT_NEAR(b[0], 10.0 / 6 - 1, 1e-3);
        EXPECT_NEAR(b[1], 10.0 / 2 - 1, 2e-2);
    }
    EXPECT_GT(both, 0);
}

// The whole row, on scenes whose shadows are exact.
struct Known {
    const char* name;
    KnownShadow shadow;
    std::function<double(double, double)> exact;
};
double quad_past(double x, double edge) {
    return past_edge_quad(x, edge, 10, 6);
}
double disc_past(double x, double edge) {
    const double y = std::clamp((edge - x * 0.6) / 0.4, -1.0, 1.0);
    return (std::acos(y) - y * std::sqrt(1 - y * y)) / pi_d;
}
// Shared area of the unit disc and one of radius r at distance d, in parts of the unit disc.
double shared_discs(double r, double d) {
    if (d >= 1 + r) return 0;
    if (d <= std::abs(1 - r)) return std::min(r * r, 1.0);
    const double a = std::acos((d * d + 1 - r * r) / (2 * d)),
                 b = std::acos((d * d + r * r - 1) / (2 * d * r));
    return (a - std::sin(2 * a) / 2 + r * r * (b - std::sin(2 * b) / 2)) / pi_d;
}
double ramp_integral(double s) {
    return s < 0 ? 0 : s < 1 ? s * s / 2 : s - 0.5;
}
// Oracle of an edge that moves from -0.5 by 1 over the shutter.
double moving_past(double x) {
    const auto part = [&](double e) { return (1 - (e - 0.6 * x) / 0.4) / 2; };  // unclamped
    const double from = part(-0.5), to = part(0.5);                             // falls with e
    return (ramp_integral(from) - ramp_integral(to)) / (from - to);
}

Image sheared(const SeenShadow& seen, const Image& receivers) {
    return RunNode("sheared-visibility")
        .in("samples", seen.samples)
        .in("light-view", seen.view)
        .in("light-samples", seen.rays)
        .in("bounds", seen.bounds("bounds"))
        .in("receivers", receivers)
        .out<Image>("visibility");
}

class AxisAlignedShadow : public testing::TestWithParam<Known> {};

TEST_P(AxisAlignedShadow, IsNearTheTruth) {
    const Known& known = GetParam();
    const SeenShadow seen(known.shadow);
    const Image receivers = seen.bounds("receivers"), own = seen.bounds("visibility");
    const Image width = RunNode("axis-aligned-width")
                            .in("bounds", seen.bounds("bounds"))
                            .in("receivers", receivers)
                            .in("light-view", seen.view)
                            .out<Image>("width");
    const Image out = filtered(own, width, receivers);
    const VisibilityError before = error_of(own, known.shadow, known.exact),
                          after = error_of(out, known.shadow, known.exact);
    ASSERT_GT(before.pixels, 50);
    EXPECT_LT(after.rmse, 0.03) << "bias " << after.bias << ", unfiltered " << before.rmse;
    EXPECT_LT(after.rmse, before.rmse);
    // The sheared filter of the same rays.
    const Image slid = sheared(seen, receivers);
    const VisibilityError other = error_of(slid, known.shadow, known.exact);
    EXPECT_LT(other.rmse, 0.03) << "bias " << other.bias << ", unfiltered " << before.rmse;
    EXPECT_LT(other.rmse, before.rmse);
    EXPECT_LT(std::abs(other.bias), 0.01);
    RecordProperty("sheared", std::to_string(other.rmse));
    RecordProperty("rmse", std::to_string(after.rmse));
    RecordProperty("unfiltered", std::to_string(before.rmse));
    EXPECT_LT(std::abs(after.bias), 0.01);
}

KnownShadow shadow_of(const char* light, const std::string& occluder, int height = 8,
                      int seed = 1) {
    KnownShadow known;
    known.light = light, known.occluder = occluder, known.height = height, known.seed = seed;
    return known;
}
std::vector<Known> known_shadows() {
    const std::string disc =
        R"({"shape": "disc", "material": "grey", "at": [0, 4, 0], "scale": 0.3})";
    std::vector<Known> all = {
        {"edge_under_a_quad", shadow_of("quad", half_plane(0)),
         [](double x, double) { return quad_past(x, 0); }},
        {"edge_under_a_disc", shadow_of("disc", half_plane(0)),
         [](double x, double) { return disc_past(x, 0); }},
        {"disc_under_a_disc", shadow_of("disc", disc, 32),
         [](double x, double z) { return 1 - shared_discs(0.75, 1.5 * std::hypot(x, z)); }},
        {"moving_edge", shadow_of("quad", half_plane(-0.5, 1)),
         [](double x, double) { return moving_past(x); }},
    };
    // Random variants.
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    static const char* const names[] = {"variant_1", "variant_2", "variant_3", "variant_4"};
    for (const char* name : names) {
        const double edge = 0.6 * unit(random) - 0.3;
        const bool quad = unit(random) < 0.5;
        all.push_back(
            {name, shadow_of(quad ? "quad" : "disc", half_plane(edge), 16, int(100 * unit(random))),
             [=](double x, double) { return quad ? quad_past(x, edge) : disc_past(x, edge); }});
    }
    return all;
}
INSTANTIATE_TEST_SUITE_P(Oracles, AxisAlignedShadow, testing::ValuesIn(known_shadows()),
                         [](const auto& of) { return std::string(of.param.name); });

TEST(AxisAlignedShadow, the_oracles_are_the_published_numbers) {
    EXPECT_NEAR(quad_past(0.25, 0), 0.6875, 1e-12);
    EXPECT_NEAR(disc_past(0.25, 0), 0.73301273, 1e-7);
    EXPECT_NEAR(1 - shared_discs(0.75, 1.5 * 0.4), 0.57741107, 1e-7);
    EXPECT_NEAR(moving_past(0.25), 0.6484375, 1e-12);
}

TEST(AxisAlignedFilter, says_what_does_not_fit) {
    const Image image(3, 3, 1), small(2, 3, {"beta"}), other(3, 3, {"beta", "x"});
    EXPECT_NE(error_of([&] {
                  RunNode("axis-aligned-filter")
                      .in("image", image)
                      .in("width", small)
                      .out<Image>("image");
              }).find("'width' is 2 x 3"),
              std::string::npos);
    EXPECT_NE(error_of([&] {
                  RunNode("axis-aligned-filter")
                      .in("image", image)
                      .in("width", other)
                      .out<Image>("image");
              }).find("expected beta"),
              std::string::npos);
}

TEST(MultiplyVisibility, leaves_textures_sharp) {
    Image share(2, 1, 1), light(2, 1, 3), rest(2, 1, 3);
    *share.at(0, 0) = 0.5f, *share.at(1, 0) = 0;
    for (int c = 0; c < 3; ++c) light.at(0, 0)[c] = float(c), rest.at(1, 0)[c] = 1;
    const Image out = RunNode("multiply-visibility")
                          .in("visibility", share)
                          .in("light", light)
                          .in("rest", rest)
                          .out<Image>("image");
    EXPECT_EQ(out.at(0, 0)[2], 1.0f);
    EXPECT_EQ(out.at(1, 0)[0], 1.0f);
}

}  // namespace
}  // namespace weft
