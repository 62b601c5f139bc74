// Reflection models: densities integrate to one, samples fall as their densities say, light goes
// both ways alike, and no surface returns more than it gets.
#include "render/bsdf.h"

#include <gtest/gtest.h>

#include <cmath>

#include "samples/random.h"

namespace weft::render {
namespace {

struct Named {
    const char* name;
    Bsdf bsdf;
    bool transmits = false, reciprocal = true;
};

std::vector<Named> all_smooth_bsdfs() {
    const Vec3 gold{1.0f, 0.8f, 0.4f};
    return {
        {"diffuse", {DiffuseBsdf{white}}},
        {"conductor, sharp", {ConductorBsdf{gold, 0.05f}}},
        {"conductor, rough", {ConductorBsdf{white, 0.6f}}},
        {"dielectric, smooth", {DielectricBsdf{white, 1.5f, 0.1f}}, true, false},
        {"dielectric, rough", {DielectricBsdf{white, 1.5f, 0.5f}}, true, false},
        {"metallic-roughness, plastic", {MetallicRoughnessBsdf{white, 0, 0.09f, 1.5f, 0}}},
        {"metallic-roughness, half metal", {MetallicRoughnessBsdf{gold, 0.5f, 0.3f, 1.5f, 0}}},
        {"metallic-roughness, thin sheet",
         {MetallicRoughnessBsdf{white, 0, 0.2f, 1.5f, 0.7f}},
         true},
    };
}

Vec3 direction(float z, float phi) {
    const float r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * std::cos(phi), r * std::sin(phi), z};
}
struct Numbers {
    float a, b, c;
};
Numbers numbers(std::uint64_t i) {
    return {unit_float(mix(3 * i)), unit_float(mix(3 * i + 1)), unit_float(mix(3 * i + 2))};
}

constexpr float views[] = {0.05f, 0.3f, 0.7f, 1.0f};

TEST(Bsdf, densities_integrate_to_the_chance_of_a_sample) {
    for (const Named& n : all_smooth_bsdfs())
        for (const float z : views) {
            const Vec3 out = direction(z, 0.7f);
            // Midpoints in (cos, phi); finer about the poles by a cubic map of each hemisphere.
            double sum = 0;
            constexpr int rows = 1200, columns = 1200;
            for (int i = 0; i < rows; ++i)
                for (int j = 0; j < columns; ++j) {
                    const double s = (i + 0.5) / rows * 2 - 1;
                    const double cosine = s * (3 - s * s) / 2,
                                 dcos = 1.5 * (1 - s * s) * 2.0 / rows;
                    const Vec3 in =
                        direction(float(cosine), float(2 * double(pi) * (j + 0.5) / columns));
                    sum += double(n.bsdf.eval(out, in).density) * dcos * 2 * double(pi) / columns;
                }
            size_t made = 0;
            constexpr size_t tries = 40000;
            for (size_t i = 0; i < tries; ++i) {
                const Numbers r = numbers(i);
                made += n.bsdf.sample(out, r.a, r.b, r.c).value.density > 0;
            }
            const double chance = double(made) / double(tries);
            EXPECT_NEAR(sum, chance, 0.015) << n.name << " at cosine " << z;
            EXPECT_GT(chance, 0.3) << n.name;
        }
}

// Chi-square over 10 x 16 cells of (cos, phi), those with few expected samples joined.
TEST(Bsdf, samples_fall_as_their_density_says) {
    constexpr int rows = 20, columns = 16, fine = 24;
    constexpr double samples = 60000;
    for (const Named& n : all_smooth_bsdfs())
        for (const float z : {0.3f, 0.9f}) {
            const Vec3 out = direction(z, 0.7f);
            std::vector<double> expected(rows * columns, 0), seen(rows * columns, 0);
            for (int i = 0; i < rows * fine; ++i)
                for (int j = 0; j < columns * fine; ++j) {
                    const double c = (i + 0.5) / (rows * fine) * 2 - 1;
                    const Vec3 in =
                        direction(float(c), float(2 * double(pi) * (j + 0.5) / (columns * fine)));
                    expected[size_t(i / fine * columns + j / fine)] +=
                        double(n.bsdf.eval(out, in).density) * 2.0 / (rows * fine) * 2 *
                        double(pi) / (columns * fine) * samples;
                }
            for (size_t i = 0; i < size_t(samples); ++i) {
                const Numbers r = numbers(i + 1000003);
                const BsdfSample s = n.bsdf.sample(out, r.a, r.b, r.c);
                if (!(s.value.density > 0)) continue;
                const int row = std::clamp(int((s.in.z + 1) * 0.5f * rows), 0, rows - 1);
                float phi = std::atan2(s.in.y, s.in.x);
                if (phi < 0) phi += 2 * pi;
                const int column = std::clamp(int(phi / (2 * pi) * columns), 0, columns - 1);
                ++seen[size_t(row * columns + column)];
            }
            double chi = 0, rest_expected = 0, rest_seen = 0;
            int cells = 0;
            for (size_t i = 0; i < expected.size(); ++i) {
                if (expected[i] < 10) {
                    rest_expected += expected[i], rest_seen += seen[i];
                    continue;
                }
                chi += (seen[i] - expected[i]) * (seen[i] - expected[i]) / expected[i];
                ++cells;
            }
            if (rest_expected > 10)
                chi += (rest_seen - rest_expected) * (rest_seen - rest_expected) / rest_expected,
                    ++cells;
            // Mean cells, variance 2 cells; six standard deviations, and the quadrature's own
            // error.
            if (cells < 5) continue;  // a lobe within few cells: the integral above says enough
            EXPECT_LT(chi, cells + 6 * std::sqrt(2.0 * cells) + 0.02 * samples / 100)
                << n.name << " at cosine " << z;
        }
}

TEST(Bsdf, a_sample_carries_the_value_and_density_of_its_direction) {
    for (const Named& n : all_smooth_bsdfs())
        for (std::uint64_t i = 0; i < 2000; ++i) {
            const Vec3 out =
                direction(0.02f + 0.98f * unit_float(mix(i + 77)), 6 * unit_float(mix(i + 99)));
            const Numbers r = numbers(i);
            const BsdfSample s = n.bsdf.sample(out, r.a, r.b, r.c);
            if (!(s.value.density > 0)) continue;
            const BsdfValue v = n.bsdf.eval(out, s.in);
            ASSERT_EQ(v.density, s.value.density) << n.name;
            ASSERT_EQ(v.sum(), s.value.sum()) << n.name;
            ASSERT_NEAR(length(s.in), 1, 1e-4f) << n.name;
            ASSERT_EQ(s.through, s.in.z * out.z < 0) << n.name;
        }
}

TEST(Bsdf, light_goes_both_ways_alike) {
    for (const Named& n : all_smooth_bsdfs()) {
        const float ior = std::holds_alternative<DielectricBsdf>(n.bsdf.of) ? 1.5f : 1.0f;
        for (std::uint64_t i = 0; i < 3000; ++i) {
            const float side = n.transmits && mix(i) % 2 ? -1.0f : 1.0f;
            const Vec3 a =
                direction(0.05f + 0.95f * unit_float(mix(4 * i)), 6 * unit_float(mix(4 * i + 1)));
            const Vec3 b = direction(side * (0.05f + 0.95f * unit_float(mix(4 * i + 2))),
                                     6 * unit_float(mix(4 * i + 3)));
            const double ab = double(luminance(n.bsdf.eval(a, b).sum())) / double(std::fabs(b.z));
            double ba = 0;
            if (b.z > 0 || n.bsdf.has_inside())
                ba = double(luminance(n.bsdf.eval(b, a).sum())) / double(std::fabs(a.z));
            else
                ba = double(luminance(n.bsdf.eval({b.x, b.y, -b.z}, {a.x, a.y, -a.z}).sum())) /
                     double(std::fabs(a.z));
            // Through a boundary f / eta^2 is what is symmetric: f(a <- b) in air, f(b <- a) in
            // glass.
            if (b.z < 0) ba /= double(ior) * double(ior);
            EXPECT_NEAR(ab, ba, 2e-3 * (std::fabs(ab) + 1e-3)) << n.name;
        }
    }
}

TEST(Bsdf, no_surface_returns_more_light_than_it_gets) {
    for (const Named& n : all_smooth_bsdfs())
        for (const float z : views) {
            const Vec3 out = direction(z, 0.2f);
            double sum = 0;
            constexpr size_t samples = 40000;
            for (size_t i = 0; i < samples; ++i) {
                const Numbers r = numbers(i);
                const BsdfSample s = n.bsdf.sample(out, r.a, r.b, r.c);
                if (!(s.value.density > 0)) continue;
                double weight = double(largest(s.value.sum())) / double(s.value.density);
                // What enters glass is squeezed into fewer directions.
                if (s.through && n.bsdf.has_inside()) weight *= 1.5 * 1.5;
                sum += weight;
            }
            EXPECT_LT(sum / samples, 1.005) << n.name << " at cosine " << z;
            EXPECT_GT(sum / samples, 0.55) << n.name << " at cosine " << z;
        }
}

TEST(Bsdf, a_white_diffuse_surface_returns_all_of_it) {
    const BsdfSample s = Bsdf{DiffuseBsdf{white}}.sample({0, 0, 1}, 0.1f, 0.3f, 0.6f);
    EXPECT_NEAR(s.value.diffuse.x / s.value.density, 1, 1e-6f);
}

// What goes straight through is what shadow rays are told, and with what is reflected it is all.
TEST(Bsdf, a_clear_sheet_parts_light_and_loses_none) {
    for (const float color : {1.0f, 0.5f})
        for (const float z : {0.3f, 0.7f, 1.0f}) {
            const Vec3 out = direction(z, 0.2f);
            const Bsdf sheet =
                make_bsdf(Material::Kind::metallic_roughness, white * color, 0, 0, 1.5f, 1);
            double passed = 0, reflected_part = 0;
            constexpr size_t samples = 40000;
            for (size_t i = 0; i < samples; ++i) {
                const Numbers r = numbers(i);
                const BsdfSample s = sheet.sample(out, r.a, r.b, r.c);
                if (!(s.value.density > 0)) continue;
                ASSERT_EQ(s.through, s.unbent);
                (s.unbent ? passed : reflected_part) +=
                    double(s.value.sum().x / s.value.density) / samples;
                if (s.unbent) {
                    ASSERT_EQ(s.in, -out);
                    ASSERT_EQ(sheet.eval(out, s.in).density, 0);
                }
            }
            EXPECT_NEAR(passed, double(sheet.transmittance(out).x), 0.01);
            EXPECT_NEAR(passed / double(color) + reflected_part, 1, 0.02) << z;
        }
    // A frosted one scatters all that goes through.
    const Bsdf frosted = make_bsdf(Material::Kind::metallic_roughness, white, 0, 0.3f, 1.5f, 1);
    EXPECT_EQ(frosted.transmittance({0, 0, 1}), Vec3{});
}

TEST(Bsdf, glass_and_mirror_follow_the_laws) {
    const Bsdf glass{GlassBsdf{white, 1.5f}};
    const Vec3 out = direction(0.6f, 0.4f);
    const BsdfSample through = glass.sample(out, 0.9f, 0, 0);
    ASSERT_TRUE(through.through);
    // Snell: sines as 1.5 to 1, in one plane.
    EXPECT_NEAR(std::hypot(through.in.x, through.in.y) * 1.5f, std::hypot(out.x, out.y), 1e-5f);
    EXPECT_NEAR(through.in.x * out.y - through.in.y * out.x, 0, 1e-6f);
    EXPECT_LT(through.in.z, 0);
    // Inside, beyond the critical angle (cosine 0.745) all is reflected.
    for (const float lobe : {0.01f, 0.99f})
        EXPECT_FALSE(glass.sample(direction(-0.5f, 1), lobe, 0, 0).through);
    // Normal incidence: ((1.5 - 1) / (1.5 + 1))^2.
    EXPECT_NEAR(dielectric_fresnel(1, 1.5f), 0.04f, 1e-6f);
    const BsdfSample mirror = Bsdf{MirrorBsdf{white}}.sample(out, 0, 0, 0);
    EXPECT_EQ(mirror.in, (Vec3{-out.x, -out.y, out.z}));
    EXPECT_EQ(mirror.value.specular, white);
}

}  // namespace
}  // namespace weft::render
