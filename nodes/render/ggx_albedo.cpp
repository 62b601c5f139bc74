#include "render/ggx_albedo.h"

#include <algorithm>
#include <array>

#include "render/microfacet.h"

namespace weft::render {
namespace {

constexpr int alphas = 16, cosines = 32, points = 64;

// Rows by the root of alpha (roughness), columns by the root of the cosine: both change fastest
// near 0.
struct Table {
    std::array<std::array<GgxAlbedo, cosines>, alphas> at;
    std::array<GgxAlbedo, alphas> mean;

    Table() {
        for (int r = 0; r < alphas; ++r) {
            const float roughness = std::max(float(r) / (alphas - 1), 0.05f);
            const Ggx ggx{roughness * roughness};
            for (int c = 0; c < cosines; ++c) {
                const float root = std::max(float(c) / (cosines - 1), 0.01f), z = root * root;
                at[size_t(r)][size_t(c)] = measure(ggx, {std::sqrt(1 - z * z), 0, z});
            }
            double scale = 0, bias = 0;
            constexpr int steps = 256;
            for (int i = 0; i < steps; ++i) {
                const float cosine = (float(i) + 0.5f) / steps;
                const GgxAlbedo e = look(at[size_t(r)], cosine);
                scale += 2.0 * double(e.scale * cosine) / steps;
                bias += 2.0 * double(e.bias * cosine) / steps;
            }
            mean[size_t(r)] = {float(scale), float(bias)};
        }
    }

    static GgxAlbedo measure(const Ggx& ggx, Vec3 out) {
        double scale = 0, bias = 0;
        for (int i = 0; i < points; ++i)
            for (int j = 0; j < points; ++j) {
                const Vec3 m =
                    ggx.sample_visible(out, (float(i) + 0.5f) / points, (float(j) + 0.5f) / points);
                const Vec3 in = reflected(out, m);
                if (in.z <= 0) continue;
                const float seen = ggx.masking_shadowing(out, in) / ggx.masking(out);
                const float w = schlick_weight(dot(out, m));
                scale += double(seen * (1 - w));
                bias += double(seen * w);
            }
        return {float(scale / (points * points)), float(bias / (points * points))};
    }

    static GgxAlbedo mixed(GgxAlbedo a, GgxAlbedo b, float s) {
        return {a.scale + (b.scale - a.scale) * s, a.bias + (b.bias - a.bias) * s};
    }
    static GgxAlbedo look(const std::array<GgxAlbedo, cosines>& row, float cosine) {
        const float place = std::sqrt(std::clamp(cosine, 0.0f, 1.0f)) * (cosines - 1);
        const int i = std::min(int(place), cosines - 2);
        return mixed(row[size_t(i)], row[size_t(i) + 1], place - float(i));
    }
};

const Table& table() {
    static const Table made;
    return made;
}

struct Row {
    size_t i;
    float s;
};
Row row_of(float alpha) {
    const float place = std::sqrt(std::clamp(alpha, 0.0f, 1.0f)) * (alphas - 1);
    const int i = std::min(int(place), alphas - 2);
    return {size_t(i), place - float(i)};
}

}  // namespace

GgxAlbedo ggx_albedo(float cosine, float alpha) {
    const auto [i, s] = row_of(alpha);
    return Table::mixed(Table::look(table().at[i], cosine), Table::look(table().at[i + 1], cosine),
                        s);
}

GgxAlbedo ggx_mean_albedo(float alpha) {
    const auto [i, s] = row_of(alpha);
    return Table::mixed(table().mean[i], table().mean[i + 1], s);
}

}  // namespace weft::render
