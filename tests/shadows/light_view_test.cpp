// The geometry of light views: slopes, planes seen from any point of a light, how pixels lie on its
// film.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "shadows/light_jacobian_kernel.h"
#include "shadows/light_view.h"

namespace weft {
namespace {

LightView example() {
    LightView view;
    view.k = 100, view.focus = 7.5;
    return view;
}

TEST(LightViews, SlopesAreThoseOfALens) {
    const LightView view = example();
    EXPECT_DOUBLE_EQ(view.c0x(), -100);
    EXPECT_NEAR(view.c1x(), 13.33333333, 1e-8);
    EXPECT_NEAR(view.c0x() / 10 + view.c1x(), 3.3333333, 1e-7);
    EXPECT_NEAR(view.c0x() / 6 + view.c1x(), -3.3333333, 1e-7);
}

TEST(LightViews, AProjectionIsTheRayFromTheLightsPoint) {
    LightView view = example();
    view.ax = 1.5, view.ay = 0.5, view.cx = 40, view.cy = 30;
    const Point3 p{1.2, -0.7, 5};
    const double lx = 0.4, ly = -0.9;
    const auto q = view.project(p, lx, ly);
    // On the plane of focus all points of the light see the same film.
    const Point3 from{view.ax * lx, view.ay * ly, 0}, at = from + (p - from) * (view.focus / p.z);
    EXPECT_NEAR(q[0], view.cx + view.k * at.x / view.focus, 1e-9);
    EXPECT_NEAR(q[1], view.cy + view.k * at.y / view.focus, 1e-9);
}

TEST(LightViews, PlanesAreLinearInInverseDepthFromAnyPoint) {
    const LightView view = example();
    const Point3 n{.5, .2, -1};
    const auto on_plane = [&](double px, double py) {
        const Point3 d{px / view.k, py / view.k, 1};
        return d * (dot(n, {0, 0, 8}) / dot(n, d));
    };
    const double lx = .7, ly = -.4;
    const Point3 a = on_plane(10, -5), b = on_plane(13, -1);
    const auto qa = view.project(a, lx, ly), qb = view.project(b, lx, ly);
    const auto h = view.inverse_depth_gradient(a, n);
    const double divisor = 1 + view.c0x() * h[0] * lx + view.c0y() * h[1] * ly;
    const double predicted = 1 / a.z + (h[0] * (qb[0] - qa[0]) + h[1] * (qb[1] - qa[1])) / divisor;
    EXPECT_NEAR(predicted, 1 / b.z, 1e-12);
    EXPECT_NEAR(predicted, .117125, 1e-6);
}

// The same of planes, lights and points of any kind.
TEST(LightViews, AnyPlaneIsLinearInInverseDepth) {
    std::mt19937 random(31);
    std::uniform_real_distribution<double> number(-1, 1);
    for (int i = 0; i < 300; ++i) {
        LightView view = example();
        view.ax = 1 + 0.9 * number(random), view.ay = 1 + 0.9 * number(random);
        view.k = 100 + 60 * number(random), view.focus = 8 + 5 * number(random);
        view.cx = 50 * number(random), view.cy = 50 * number(random);
        const Point3 n{number(random), number(random), -1.2}, at{number(random), number(random), 8};
        const auto on_plane = [&](double px, double py) {
            const Point3 d{px / view.k, py / view.k, 1};
            return d * (dot(n, at) / dot(n, d));
        };
        const Point3 a = on_plane(30 * number(random), 30 * number(random)),
                     b = on_plane(30 * number(random), 30 * number(random));
        const double lx = number(random), ly = number(random);
        const auto h = view.inverse_depth_gradient(a, n);
        const double divisor = 1 + view.c0x() * h[0] * lx + view.c0y() * h[1] * ly;
        if (!(a.z > 1) || !(b.z > 1) || std::abs(divisor) < 0.1) continue;
        const auto qa = view.project(a, lx, ly), qb = view.project(b, lx, ly);
        EXPECT_NEAR(1 / a.z + (h[0] * (qb[0] - qa[0]) + h[1] * (qb[1] - qa[1])) / divisor, 1 / b.z,
                    1e-10)
            << i;
    }
}

TEST(LightViews, WorldAndLightSpaceAreInverse) {
    LightView view = example();
    view.light_to_world[0] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {3, 2, 1}};
    view.light_to_world[1] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {3, 4, 1}};
    for (const size_t end : {0, 1}) view.world_to_light[end] = inverse(view.light_to_world[end]);
    for (const double t : {0.0, 0.3, 1.0}) {
        const Point3 p{0.5, -1, 7}, back = view.from_world(view.to_world(p, t), t);
        EXPECT_NEAR(back.x, p.x, 1e-12);
        EXPECT_NEAR(back.y, p.y, 1e-12);
        EXPECT_NEAR(back.z, p.z, 1e-12);
    }
}

TEST(LightViews, APointOfABallIsOnItsNearSide) {
    LightView view = example();
    view.shape = LightView::Shape::sphere;
    view.radius = 0.5, view.ax = view.ay = 1.4;
    const Point3 p{2, 1, 6};
    for (int i = 0; i < 100; ++i) {
        const auto l = view.point((i % 10 + 0.5) / 10, (i / 10 + 0.5) / 10, p);
        const Point3 at{view.ax * l[0], view.ay * l[1], 0}, way = p - at;
        const double along = dot(p, way) / dot(way, way);
        const Point3 nearest = p - way * along;
        EXPECT_LT(std::sqrt(dot(nearest, nearest)), 0.5 + 1e-9);
    }
}

// The plane n.P = c in camera space, seen by both.
TEST(LightJacobian, IsTheDifferenceOfBothProjections) {
    LightView view = example();
    view.cx = 12, view.cy = -3;
    // Camera pixels (x z, y z, z) to light space: a turned, moved pinhole.
    const double s = 250, a = 0.7;
    const Map3 m{{std::cos(a) / s, 0.1 / s, -std::sin(a) / s},
                 {0.02 / s, std::cos(0.3) / s, 0.1 / s},
                 {std::sin(a) - 0.5, 0.2, std::cos(a)},
                 {-1, 0.4, 2}};
    const Point3 normal{0.3, -0.4, -1};
    const Point3 on{0.8, 0.3, 7};
    const auto seen = [&](double x, double y) {
        const Point3 d = m.vector({x, y, 1});
        const double z = dot(normal, on - m.origin) / dot(normal, d);
        return Point3{x * z, y * z, z};
    };
    const auto q = [&](double x, double y) { return view.project(m.point(seen(x, y)), 0, 0); };
    const double x = 31, y = -22, e = 1e-4;
    const shadows::Jacobian j = shadows::light_jacobian(view, m, seen(x, y), normal, 1e6);
    for (size_t r = 0; r < 2; ++r) {
        EXPECT_NEAR(j[r][0], (q(x + e, y)[r] - q(x - e, y)[r]) / (2 * e),
                    1e-4 * std::abs(j[r][0]) + 1e-9);
        EXPECT_NEAR(j[r][1], (q(x, y + e)[r] - q(x, y - e)[r]) / (2 * e),
                    1e-4 * std::abs(j[r][1]) + 1e-9);
    }
    // Of any plane, anywhere, within bounds that it does not reach.
    std::mt19937 random(32);
    std::uniform_real_distribution<double> number(-1, 1);
    for (int i = 0; i < 100; ++i) {
        const Point3 any{0.8 * number(random), 0.8 * number(random), -1};
        const auto seen_any = [&](double px, double py) {
            const Point3 d = m.vector({px, py, 1});
            const double z = dot(any, on - m.origin) / dot(any, d);
            return Point3{px * z, py * z, z};
        };
        const auto q_any = [&](double px, double py) {
            return view.project(m.point(seen_any(px, py)), 0, 0);
        };
        const double px = 40 * number(random), py = 40 * number(random);
        if (!(m.point(seen_any(px, py)).z > 1) || !(seen_any(px, py).z > 1)) continue;
        const shadows::Jacobian jj =
            shadows::light_jacobian(view, m, seen_any(px, py), any, 1e6);
        for (size_t r = 0; r < 2; ++r) {
            const double size = std::abs(jj[r][0]) + std::abs(jj[r][1]);
            EXPECT_NEAR(jj[r][0], (q_any(px + e, py)[r] - q_any(px - e, py)[r]) / (2 * e),
                        1e-4 * size)
                << i;
            EXPECT_NEAR(jj[r][1], (q_any(px, py + e)[r] - q_any(px, py - e)[r]) / (2 * e),
                        1e-4 * size)
                << i;
        }
    }
    // Within bounds, whatever the plane.
    for (const Point3 n :
         {Point3{1, 0, 0}, Point3{0, 1, 1e-7}, Point3{0, 0, 1}, Point3{1, -1, 0.01}}) {
        const shadows::Jacobian bounded = shadows::light_jacobian(view, m, seen(x, y), n, 4);
        const Point3 p = m.point(seen(x, y));
        const double scale =
            view.k / p.z * seen(x, y).z * std::sqrt(0.5 * (dot(m.x, m.x) + dot(m.y, m.y)));
        const auto jj = shadows::metric_of(bounded);
        const double mean = 0.5 * (jj[0] + jj[2]),
                     spread = std::hypot(0.5 * (jj[0] - jj[2]), jj[1]);
        EXPECT_LE(std::sqrt(mean + spread), 4 * scale * (1 + 1e-6));
        EXPECT_GE(std::sqrt(std::max(mean - spread, 0.0)), scale / 4 * (1 - 1e-6));
        EXPECT_TRUE(std::isfinite(shadows::area_of(bounded)));
    }
}

}  // namespace
}  // namespace weft
