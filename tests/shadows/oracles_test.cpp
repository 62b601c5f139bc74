// Shadows whose exact shape is known, reconstructed from 16 light samples a pixel at 256 points of
// the light; and the same at other places, sizes, densities and seeds.
#include "tests/shadows/shadow_test.h"

namespace weft {
namespace {

ShadowSetup half_plane(LightView::Shape shape, double edge, int spp = 16, unsigned seed = 1) {
    ShadowSetup s;
    s.shape = shape, s.spp = spp, s.seed = seed;
    s.occluder = flat_occluder(6, [=](double x, double, double) { return x < edge; });
    return s;
}

TEST(ShadowOracle, KnownNumbers) {
    EXPECT_DOUBLE_EQ(past_edge_quad(0, 0, 10, 6), 0.5);
    EXPECT_NEAR(past_edge_quad(.25, 0, 10, 6), 0.6875, 1e-12);
    EXPECT_NEAR(past_edge_disc(.25, 0, 10, 6), 0.73301273, 1e-8);
    EXPECT_NEAR(past_disc(0, .3, 10, 6), 0.4375, 1e-12);
    EXPECT_NEAR(past_disc(.4, .3, 10, 6), 0.57741107, 1e-8);
    EXPECT_NEAR(past_disc(1, .3, 10, 6), 0.95205090, 1e-8);
}

// 256 points of a light, 16 samples a pixel.
constexpr double most_rmse = 0.012, most_bias = 0.005, most_bias_of_triangles = 0.008;

TEST(ShadowOracle, EdgesUnderBothLights) {
    for (const bool rays : {true, false})
        for (const auto shape : {LightView::Shape::quad, LightView::Shape::disc}) {
            ShadowSetup s = half_plane(shape, 0);
            s.rays = rays;
            const ShadowTest test(s);
            const auto e = error_over(test, -0.66, 0.66, 41, [&](double x) {
                return shape == LightView::Shape::quad ? past_edge_quad(x, 0, 10, 6)
                                                       : past_edge_disc(x, 0, 10, 6);
            });
            EXPECT_LT(e.rmse, most_rmse) << rays;
            EXPECT_LT(std::abs(e.bias), rays ? most_bias : most_bias_of_triangles);
            EXPECT_EQ(test.share(-0.8), 0);
            EXPECT_EQ(test.share(0.8), 1);
        }
}

TEST(ShadowOracle, DiscUnderDiscLight) {
    ShadowSetup s;
    s.shape = LightView::Shape::disc;
    s.occluder = flat_occluder(6, [](double x, double y, double) { return x * x + y * y < 0.09; });
    const ShadowTest test(s);
    const auto exact = [](double x) { return past_disc(x, .3, 10, 6); };
    const auto e = error_over(test, 0, 1.1667, 41, exact);
    EXPECT_LT(e.rmse, most_rmse);
    EXPECT_LT(std::abs(e.bias), most_bias);
    EXPECT_EQ(test.share(1.6), 1);
    // The rim holds from few samples, too.
    for (const int spp : {1, 4}) {
        s.spp = spp;
        const auto few = error_over(ShadowTest(s), 0, 1.1667, 41, exact);
        EXPECT_LT(few.rmse, most_rmse) << spp;
        EXPECT_LT(std::abs(few.bias), 0.008) << spp;
    }
}

// Triangles leave the rim of what is small uncovered, by about a third of a sample's spacing: their
// corners are samples, inside the rim. Longer ones, as parts/soft-shadow-triangles.json has them, leave
// less; the hull of all samples, which no triangles pass, has an RMSE of 0.0117 and a bias of 0.0074.
TEST(ShadowOracle, DiscByTriangles) {
    ShadowSetup s;
    s.shape = LightView::Shape::disc;
    s.occluder = flat_occluder(6, [](double x, double y, double) { return x * x + y * y < 0.09; });
    s.rays = false;
    const auto exact = [](double x) { return past_disc(x, .3, 10, 6); };
    const auto once = error_over(ShadowTest(s), 0, 1.1667, 41, exact);
    EXPECT_LT(once.rmse, 0.016);
    EXPECT_LT(std::abs(once.bias), 0.012);
    const auto error = [&](double radius_scale) {
        constexpr unsigned seeds = 8;
        ShadowError all;
        for (s.seed = 1; s.seed <= seeds; ++s.seed) {
            const auto one = error_over(ShadowTest(s, radius_scale), 0, 1.1667, 41, exact);
            all.rmse += one.rmse * one.rmse / seeds, all.bias += one.bias / seeds;
        }
        all.rmse = std::sqrt(all.rmse);
        return all;
    };
    const ShadowError published = error(1), wider = error(2);
    EXPECT_LT(published.rmse, 0.014);
    EXPECT_LT(std::abs(published.bias), 0.0098);
    EXPECT_LT(wider.rmse, most_rmse);
    EXPECT_LT(std::abs(wider.bias), most_bias_of_triangles);
}

TEST(ShadowOracle, SphereUnderBothLights) {
    const std::vector<std::pair<double, double>> round{
        {0, .43431804}, {.2, .4462}, {.4, .5770}, {.8, .8467}};
    const std::vector<std::pair<double, double>> square{
        {0, .55571443}, {.2, .5605}, {.4, .6355}, {.8, .8519}};
    double squares = 0, sum = 0;
    constexpr unsigned seeds = 5;
    for (unsigned seed = 1; seed <= seeds; ++seed)
        for (const bool disc : {true, false}) {
            ShadowSetup s;
            s.shape = disc ? LightView::Shape::disc : LightView::Shape::quad;
            s.seed = seed;
            s.occluder = sphere_occluder({0, 0, 6}, .3);
            const ShadowTest test(s);
            for (const auto& [x, v] : disc ? round : square) {
                const double error = test.share(x) - v;
                EXPECT_NEAR(error, 0, 0.035) << x << (disc ? " disc " : " quad ") << seed;
                squares += error * error, sum += error;
            }
        }
    EXPECT_LT(std::sqrt(squares / (8 * seeds)), most_rmse);
    EXPECT_LT(std::abs(sum / (8 * seeds)), most_bias);
}

// Half-plane X < -.5 + t: the mean over the shutter.
double past_moving_edge(double x) {
    const auto ramp = [](double s) { return s < 0 ? 0 : s <= 1 ? s * s / 2 : s - 0.5; };
    const auto at = [&](double t) { return 0.5 - ((t - 0.5) - 0.6 * x) / 0.8; };
    return (ramp(at(0)) - ramp(at(1))) / 1.25;
}

TEST(ShadowOracle, MovingEdge) {
    EXPECT_NEAR(past_moving_edge(.25), 0.6484375, 1e-12);
    ShadowSetup s;
    s.timed = true;
    s.occluder =
        flat_occluder(6, [](double x, double, double t) { return x < -.5 + t; }, {1, 0, 0});
    const ShadowTest test(s);
    const auto e = error_over(test, -1, 1, 41, past_moving_edge);
    EXPECT_LT(e.rmse, most_rmse);
    EXPECT_LT(std::abs(e.bias), most_bias);
}

TEST(ShadowProperty, MovingEdgesOfAnySpeedPlaceAndSeed) {
    std::mt19937 random(13);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 6; ++i) {
        const double speed = 2 * unit(random) - 1, edge = 0.6 * unit(random) - 0.3,
                     d2 = 4 + 4 * unit(random);
        ShadowSetup s;
        s.timed = true;
        s.spp = std::vector{4, 16}[size_t(random() % 2)], s.seed = unsigned(random());
        s.occluder = flat_occluder(
            d2, [=](double x, double, double t) { return x < edge + speed * (t - 0.5); },
            {speed, 0, 0});
        const auto exact = [=](double x) {
            constexpr int steps = 400;
            double sum = 0;
            for (int k = 0; k < steps; ++k)
                sum += past_edge_quad(x, edge + speed * ((k + 0.5) / steps - 0.5), 10, d2);
            return sum / steps;
        };
        const double middle = edge * 10 / d2,
                     wide = (10 / d2 - 1) + 0.5 * std::abs(speed) * 10 / d2;
        const auto e = error_over(ShadowTest(s), middle - wide, middle + wide, 21, exact);
        const double spacing = 10.0 / 100 / std::sqrt(s.spp) / (2 * wide);
        EXPECT_LT(e.rmse, most_rmse + 0.4 * spacing) << speed << " " << d2 << " " << s.spp;
        EXPECT_LT(std::abs(e.bias), most_bias + 0.3 * spacing)
            << speed << " " << d2 << " " << s.spp;
    }
}

// Half of the shutter, or the other half: the same shadow at another time.
TEST(ShadowProperty, TimeCanBeShifted) {
    ShadowSetup early;
    early.timed = true, early.close = 0.5;
    ShadowSetup late = early;
    late.open = 0.5, late.close = 1;
    early.occluder = late.occluder =
        flat_occluder(6, [](double x, double, double) { return x < 0.1; });
    const ShadowTest still_early(early), still_late(late);
    for (const double x : {-0.3, 0.0, 0.2, 0.45})
        EXPECT_EQ(still_early.shares(x, 0.1, 16, {}), still_late.shares(x, 0.1, 16, {})) << x;
    // What moves is carried to times that round otherwise.
    const auto moving = [](double start) {
        return flat_occluder(
            6, [=](double x, double, double t) { return x < -0.4 + 2 * (t - start); }, {2, 0, 0});
    };
    early.occluder = moving(0), late.occluder = moving(0.5);
    const ShadowTest moving_early(early), moving_late(late);
    for (int i = -6; i <= 6; ++i)
        EXPECT_NEAR(moving_early.share(0.15 * i), moving_late.share(0.15 * i), 2.5 / 256) << i;
}

// A pixel as wide as a whole unit: the mean over film, light and shutter together.
TEST(ShadowOracle, MeanOverAPixelUnderAMovingEdge) {
    ShadowSetup s;
    s.timed = true;
    s.occluder =
        flat_occluder(6, [](double x, double, double t) { return x < -.5 + t; }, {1, 0, 0});
    const ShadowTest test(s);
    for (const double left : {-1.0, -0.4, 0.1}) {
        double exact = 0, mean = 0;
        constexpr int steps = 100000, places = 32;
        for (int i = 0; i < steps; ++i) exact += past_moving_edge(left + (i + 0.5) / steps) / steps;
        for (int i = 0; i < places; ++i) mean += test.share(left + (i + 0.5) / places) / places;
        EXPECT_NEAR(mean, exact, most_bias) << left;
    }
}

TEST(ShadowOracle, TiltedReceiversNeverShadowThemselves) {
    for (const double degrees : {0.0, 30.0, 60.0, 75.0})
        for (const int spp : {1, 4, 16})
            for (const auto test_kind :
                 {shadows::DepthTest::both_planes, shadows::DepthTest::inverse_depth}) {
                ShadowSetup s;
                s.spp = spp;
                s.normal = {std::sin(degrees * pi_d / 180), 0, std::cos(degrees * pi_d / 180)};
                s.reach = degrees > 70 ? 1 : 2;
                const ShadowTest test(s);
                shadows::VoteSettings vote;
                vote.test = test_kind;
                for (const double x : {-0.8, 0.0, 0.37, 0.9})
                    EXPECT_EQ(test.share(x, 0.2, 16, vote), 1) << degrees << " " << spp;
            }
}

TEST(ShadowOracle, BallsNeverShadowTheirLitSide) {
    // Receivers on a ball that bends away from the light: its own samples are the only ones.
    ShadowSetup s;
    s.spp = 4;
    s.occluder = [](Point3 light, Point3 receiver, double t) {
        return sphere_occluder({0, 0, 8}, 1.5)(light, receiver, t);
    };
    const ShadowTest test(s);
    const double z = 8 - std::sqrt(1.5 * 1.5 - 0.3 * 0.3);
    Locations at;
    ShadowQueries ask;
    const Point3 p{0.3, 0, z}, normal{0.3, 0, z - 8};
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    const size_t n = 200;
    at.own_pixels.assign(n, 0);
    at.pixels = at.own_pixels;
    const auto slope = test.view().inverse_depth_gradient(p, normal);
    for (size_t i = 0; i < n; ++i) {
        const double lx = 2 * unit(random) - 1, ly = 2 * unit(random) - 1;
        const auto q = test.view().project(p, lx, ly);
        at.x.push_back(float(q[0])), at.y.push_back(float(q[1]));
        at.u.push_back(float(lx)), at.v.push_back(float(ly)), at.t.push_back(0.5f);
    }
    at.x0 = 0, at.y0 = 0, at.x1 = test.view().width, at.y1 = test.view().height;
    ask.inverse_depth.assign(n, float(1 / p.z));
    ask.slope_x.assign(n, float(slope[0])), ask.slope_y.assign(n, float(slope[1]));
    ask.sample.assign(n, 0);
    const LightShares shares = test.run(at, ask, {});
    for (size_t i = 0; i < n; ++i) {
        EXPECT_EQ(shares.share[i], 1.0f) << i;
        EXPECT_GT(shares.votes[i], 0u) << i;
    }
}

TEST(ShadowOracle, LightWithoutSizeCastsHardShadows) {
    ShadowSetup s = half_plane(LightView::Shape::point, 0);
    s.half = 0;
    const ShadowTest test(s);
    for (int i = -10; i <= 10; ++i) {
        const double x = 0.25 * i + 0.11;
        EXPECT_EQ(test.share(x, 0.3, 4), x < 0 ? 0 : 1) << x;
    }
}

TEST(ShadowOracle, WhollyBlockedOrFreeIsExact) {
    ShadowSetup s;
    s.occluder = flat_occluder(6, [](double, double, double) { return true; });
    EXPECT_EQ(ShadowTest(s).share(0.3), 0);
    s.occluder = nullptr;
    EXPECT_EQ(ShadowTest(s).share(0.3), 1);
}

TEST(ShadowProperty, EdgesOfAnyPlaceSizeAndSeed) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 8; ++i) {
        const double edge = unit(random) - 0.5, d2 = 3 + 5 * unit(random),
                     half = 0.3 + 1.2 * unit(random);
        const int spp = std::vector{4, 9, 16}[size_t(random() % 3)];
        ShadowSetup s;
        s.half = half, s.spp = spp, s.seed = unsigned(random());
        s.occluder = flat_occluder(d2, [=](double x, double, double) { return x < edge; });
        const ShadowTest test(s);
        const double middle = edge * 10 / d2, wide = half * (10 / d2 - 1);
        const auto e = error_over(test, middle - wide, middle + wide, 21,
                                  [=](double x) { return past_edge_quad(x, edge, 10, d2, half); });
        // A mean of 256 points of its own, in squares of the light, and edges as uncertain as
        // samples are apart.
        const double spacing = 10.0 / 100 / std::sqrt(spp) / (2 * wide);
        EXPECT_LT(e.rmse, most_rmse + 0.4 * spacing)
            << edge << " " << d2 << " " << half << " " << spp;
        EXPECT_LT(std::abs(e.bias), most_bias + 0.3 * spacing)
            << edge << " " << d2 << " " << half << " " << spp;
    }
}

TEST(ShadowProperty, DiscsOfAnySizeAndSeed) {
    std::mt19937 random(12);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 8; ++i) {
        const double r = 0.15 + 0.5 * unit(random), d2 = 4 + 4 * unit(random);
        ShadowSetup s;
        s.shape = LightView::Shape::disc;
        s.spp = std::vector{4, 9, 16}[size_t(random() % 3)], s.seed = unsigned(random());
        s.occluder =
            flat_occluder(d2, [=](double x, double y, double) { return x * x + y * y < r * r; });
        const double far = (r + (1 - d2 / 10)) * 10 / d2;
        const auto e = error_over(ShadowTest(s), 0, far, 21,
                                  [=](double x) { return past_disc(x, r, 10, d2); });
        const double spacing = 10.0 / 100 / std::sqrt(s.spp) / (2 * (10 / d2 - 1));
        EXPECT_LT(e.rmse, most_rmse + 0.4 * spacing) << r << " " << d2 << " " << s.spp;
        EXPECT_LT(std::abs(e.bias), most_bias + 0.3 * spacing) << r << " " << d2 << " " << s.spp;
    }
}

// Layers that are apart: what one lets through the other may stop.
TEST(ShadowProperty, TwoEdgesOneBehindTheOther) {
    for (const int spp : {4, 16}) {
        ShadowSetup s;
        s.spp = spp;
        const auto near = flat_occluder(4, [](double x, double, double) { return x < -0.2; }),
                   far = flat_occluder(7, [](double x, double, double) { return x > 0.3; });
        s.occluder = [=](Point3 light, Point3 receiver, double t) {
            const auto first = near(light, receiver, t);
            return first ? first : far(light, receiver, t);
        };
        const ShadowTest test(s);
        // Light points that both leave: y > the first edge's, y < the second's.
        const auto exact = [](double x) {
            const double low = (-0.2 - 0.4 * x) / 0.6, high = (0.3 - 0.7 * x) / 0.3;
            return std::max(0.0, std::clamp(high, -1.0, 1.0) - std::clamp(low, -1.0, 1.0)) / 2;
        };
        const auto e = error_over(test, -1, 1, 41, exact);
        EXPECT_LT(e.rmse, most_rmse + 0.1 / spp) << spp;
        EXPECT_LT(std::abs(e.bias), most_bias + 0.02 / spp) << spp;
    }
}

// What random variants have in common: bounds of the oracles, wider by as much as samples are apart in
// a penumbra as wide as `wide` to both sides.
double spacing(const ShadowSetup& s, double wide) {
    return s.d1 / s.k / std::sqrt(s.spp) / (2 * wide);
}

TEST(ShadowProperty, EdgesUnderRoundLightsOfAnyPlaceSizeAndSeed) {
    std::mt19937 random(21);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 6; ++i) {
        const double edge = unit(random) - 0.5, d2 = 3 + 5 * unit(random);
        ShadowSetup s = half_plane(LightView::Shape::disc, edge);
        s.spp = std::vector{4, 9, 16}[size_t(random() % 3)], s.seed = unsigned(random());
        s.occluder = flat_occluder(d2, [=](double x, double, double) { return x < edge; });
        const double middle = edge * 10 / d2, wide = 10 / d2 - 1;
        const auto e = error_over(ShadowTest(s), middle - wide, middle + wide, 21,
                                  [=](double x) { return past_edge_disc(x, edge, 10, d2); });
        EXPECT_LT(e.rmse, most_rmse + 0.4 * spacing(s, wide)) << edge << " " << d2 << " " << s.spp;
        EXPECT_LT(std::abs(e.bias), most_bias + 0.3 * spacing(s, wide))
            << edge << " " << d2 << " " << s.spp;
    }
}

// Triangles, as published, on the same.
TEST(ShadowProperty, EdgesByTrianglesOfAnyPlaceSizeAndSeed) {
    std::mt19937 random(22);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 4; ++i) {
        const double edge = unit(random) - 0.5, d2 = 3 + 5 * unit(random);
        ShadowSetup s = half_plane(LightView::Shape::quad, edge, 16, unsigned(random()));
        s.rays = false;
        s.occluder = flat_occluder(d2, [=](double x, double, double) { return x < edge; });
        const double middle = edge * 10 / d2, wide = 10 / d2 - 1;
        const auto e = error_over(ShadowTest(s), middle - wide, middle + wide, 21,
                                  [=](double x) { return past_edge_quad(x, edge, 10, d2); });
        EXPECT_LT(e.rmse, most_rmse + 0.5 * spacing(s, wide)) << edge << " " << d2;
        EXPECT_LT(std::abs(e.bias), most_bias_of_triangles + 0.5 * spacing(s, wide))
            << edge << " " << d2;
    }
}

// What of a light a ball leaves, by quadrature over the light.
double past_ball(double x, Point3 centre, double radius, bool disc) {
    constexpr int steps = 200;
    int all = 0, open = 0;
    const auto ball = sphere_occluder(centre, radius);
    for (int j = 0; j < steps; ++j)
        for (int i = 0; i < steps; ++i) {
            const Point3 l{(i + 0.5) / steps * 2 - 1, (j + 0.5) / steps * 2 - 1, 0};
            if (disc && dot(l, l) > 1) continue;
            ++all;
            open += !ball(l, {x, 0, 10}, 0.5);
        }
    return double(open) / all;
}

TEST(ShadowProperty, BallsOfAnyPlaceSizeAndSeed) {
    EXPECT_NEAR(past_ball(0, {0, 0, 6}, 0.3, true), 0.43431804, 2e-3);
    std::mt19937 random(23);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 6; ++i) {
        const Point3 centre{unit(random) - 0.5, 0.4 * unit(random) - 0.2, 4.5 + 3 * unit(random)};
        const double radius = 0.2 + 0.3 * unit(random);
        ShadowSetup s;
        s.shape = i % 2 ? LightView::Shape::disc : LightView::Shape::quad;
        s.seed = unsigned(random());
        s.occluder = sphere_occluder(centre, radius);
        const double middle = centre.x * 10 / centre.z,
                     far = (radius + (1 - centre.z / 10)) * 10 / centre.z;
        const auto e = error_over(ShadowTest(s), middle - far, middle + far, 17, [&](double x) {
            return past_ball(x, centre, radius, s.shape == LightView::Shape::disc);
        });
        // As SphereUnderBothLights: few rays tell of what of its rim one point of the light sees.
        EXPECT_LT(e.rmse, 0.027) << centre.x << " " << centre.z << " " << radius;
        EXPECT_LT(std::abs(e.bias), 0.02) << centre.x << " " << centre.z << " " << radius;
    }
}

TEST(ShadowProperty, NoPlaneShadowsItself) {
    std::mt19937 random(24);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 12; ++i) {
        const double tilt = 75 * std::sqrt(unit(random)) * pi_d / 180,
                     way = 2 * pi_d * unit(random);
        ShadowSetup s;
        s.shape = i % 2 ? LightView::Shape::disc : LightView::Shape::quad;
        s.spp = std::vector{1, 4, 9}[size_t(random() % 3)], s.seed = unsigned(random());
        s.timed = i % 3 == 0;
        s.half = 0.2 + 1.3 * unit(random), s.focus = 4 + 10 * unit(random);
        s.normal = {std::sin(tilt) * std::cos(way), std::sin(tilt) * std::sin(way), std::cos(tilt)};
        s.reach = tilt > 70 * pi_d / 180 ? 1 : 1.5;
        s.rays = i % 4 != 3;
        const ShadowTest test(s);
        for (int k = 0; k < 4; ++k) {
            const double x = 1.6 * unit(random) - 0.8, y = 1.6 * unit(random) - 0.8;
            EXPECT_EQ(test.share(x, y), 1) << tilt << " " << way << " " << s.spp;
        }
    }
}

TEST(ShadowProperty, PointsCastHardShadowsOfAnyEdge) {
    std::mt19937 random(25);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 6; ++i) {
        const double edge = unit(random) - 0.5, d2 = 2 + 7 * unit(random);
        ShadowSetup s = half_plane(LightView::Shape::point, edge);
        s.half = 0, s.spp = std::vector{1, 4, 9}[size_t(random() % 3)], s.seed = unsigned(random());
        s.occluder = flat_occluder(d2, [=](double x, double, double) { return x < edge; });
        const ShadowTest test(s);
        const double rim = edge * 10 / d2;
        for (int k = 0; k < 20; ++k) {
            const double x = 5 * unit(random) - 2.5, share = test.share(x, 0.3, 4);
            EXPECT_TRUE(share == 0 || share == 1) << share;
            // A light pixel is 0.1 wide there, and samples are no farther apart.
            if (std::abs(x - rim) < 0.15) continue;
            EXPECT_EQ(share, x < rim ? 0 : 1) << x << " " << rim;
        }
    }
}

TEST(ShadowProperty, BlockedAndFreeAreExactForAnyLight) {
    std::mt19937 random(26);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 6; ++i) {
        ShadowSetup s;
        s.shape = i % 2 ? LightView::Shape::disc : LightView::Shape::quad;
        s.half = 0.1 + 2 * unit(random), s.spp = i % 3 ? 4 : 1, s.seed = unsigned(random());
        const double d2 = 3 + 6 * unit(random);
        s.occluder = flat_occluder(d2, [](double, double, double) { return true; });
        const double x = 2 * unit(random) - 1;
        EXPECT_EQ(ShadowTest(s).share(x), 0) << d2;
        s.occluder = nullptr;
        EXPECT_EQ(ShadowTest(s).share(x), 1) << d2;
    }
}

TEST(ShadowProperty, ScaleFocusAndTimeMakeNoDifference) {
    const auto mean_of = [](const ShadowSetup& s, double scale) {
        const ShadowTest test(s);
        double sum = 0;
        for (int i = -5; i <= 5; ++i) sum += test.share(0.1 * i * scale) / 11;
        return sum;
    };
    const double as_is = mean_of(half_plane(LightView::Shape::quad, 0.1), 1);
    for (const double scale : {0.01, 100.0}) {
        ShadowSetup s = half_plane(LightView::Shape::quad, 0.1);
        s.d1 *= scale, s.half *= scale, s.reach *= scale, s.focus *= scale;
        s.occluder =
            flat_occluder(6 * scale, [=](double x, double, double) { return x < 0.1 * scale; });
        ShadowTest test(s);
        double sum = 0;
        for (int i = -5; i <= 5; ++i) sum += test.share(0.1 * i * scale) / 11;
        EXPECT_NEAR(sum, as_is, 0.01) << scale;
    }
    for (const double focus : {4.0, 20.0, 1e9}) {
        ShadowSetup s = half_plane(LightView::Shape::quad, 0.1);
        s.focus = focus;
        EXPECT_NEAR(mean_of(s, 1), as_is, 0.01) << focus;
    }
}

}  // namespace
}  // namespace weft
