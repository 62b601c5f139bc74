#include "image/measures.h"

#include <fmt/format.h>

#include <cmath>

#include "graph/error.h"
#include "image/display_values.h"
#include "image/flip.h"
#include "image/picture_file.h"
#include "image/plane.h"

namespace weft {
namespace {

constexpr size_t rows_a_piece = 16;

// Sum of of(i) over all values of two pictures, row by row.
template <class Of>
double sum_over(const RgbPixels& p, Context& ctx, Of&& of) {
    const size_t a_row = size_t(p.width) * 3;
    return ctx.reduce<double>(
        size_t(p.height), rows_a_piece, 0.0,
        [&](size_t begin, size_t end) {
            double total = 0;
            for (size_t i = begin * a_row; i < end * a_row; ++i) total += of(i);
            return total;
        },
        [](double a, double b) { return a + b; });
}

double square(double v) {
    return v * v;
}

double ssim(const RgbPixels& a, const RgbPixels& b, Context& ctx) {
    const int width = a.width, height = a.height;
    // In double: the variances of smooth regions are small differences of large means.
    TapsOf<double> taps;
    double total = 0;
    for (int x = -5; x <= 5; ++x) taps.push_back(std::exp(-x * x / (2 * 1.5 * 1.5)));
    for (const double tap : taps) total += tap;
    for (double& tap : taps) tap /= total;

    using Values = PlaneOf<double>;
    Values la(width, height), lb(width, height), aa(width, height), bb(width, height),
        ab(width, height);
    for (size_t i = 0; i < la.values.size(); ++i) {
        const auto luma = [&](const RgbPixels& p) {
            return 0.2126f * p.values[3 * i] + 0.7152f * p.values[3 * i + 1] +
                   0.0722f * p.values[3 * i + 2];
        };
        const double u = luma(a), v = luma(b);
        la.values[i] = u, lb.values[i] = v, aa.values[i] = u * u, bb.values[i] = v * v,
        ab.values[i] = u * v;
    }
    for (Values* plane : {&la, &lb, &aa, &bb, &ab}) *plane = filtered(*plane, taps, taps, ctx);
    const int margin_x = width > 10 ? 5 : 0, margin_y = height > 10 ? 5 : 0;
    double sum = 0;
    for (int y = margin_y; y < height - margin_y; ++y)
        for (int x = margin_x; x < width - margin_x; ++x) {
            const size_t i = size_t(y) * size_t(width) + size_t(x);
            const double ma = la.values[i], mb = lb.values[i];
            const double va = aa.values[i] - ma * ma, vb = bb.values[i] - mb * mb,
                         cov = ab.values[i] - ma * mb;
            constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
            sum +=
                (2 * ma * mb + c1) * (2 * cov + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
        }
    return sum / (double(width - 2 * margin_x) * double(height - 2 * margin_y));
}

void check_alike(const Image& picture, const Image& reference) {
    if (picture.width() != reference.width() || picture.height() != reference.height())
        throw Error(
            fmt::format("the picture is {} x {}, its reference {} x {}; expected the same size",
                        picture.width(), picture.height(), reference.width(), reference.height()));
    if (picture.width() < 1 || picture.height() < 1) throw Error("the pictures have no pixels");
    if (picture.color_space != reference.color_space && !picture.color_space.empty() &&
        !reference.color_space.empty())
        throw Error(
            fmt::format("the picture is in '{}', its reference in '{}'; "
                        "bring them into one space with 'ocio-color-space'",
                        picture.color_space, reference.color_space));
}

// What each pixel counts, checked; empty: 1.
std::vector<float> weights_of(const Image* where, const Image& reference) {
    if (!where) return {};
    if (where->width() != reference.width() || where->height() != reference.height())
        throw Error(fmt::format("'where' is {} x {}, the reference {} x {}; expected the same size",
                                where->width(), where->height(), reference.width(),
                                reference.height()));
    std::vector<float> weights(size_t(where->width()) * size_t(where->height()));
    double sum = 0;
    for (size_t i = 0; i < weights.size(); ++i) {
        weights[i] = where->pixels()[i * size_t(where->channels())];
        if (!(weights[i] >= 0) || !std::isfinite(weights[i]))
            throw Error(fmt::format("'where' is {} at pixel {}, {}; expected weights from 0 up",
                                    weights[i], i % size_t(where->width()),
                                    i / size_t(where->width())));
        sum += double(weights[i]);
    }
    if (sum == 0) throw Error("'where' is 0 everywhere; expected a pixel that counts");
    return weights;
}

// A picture that does not say its space is taken to be in the other's.
Image spaced(const Image& picture, const Image& other) {
    Image copy = picture;
    if (copy.color_space.empty()) copy.color_space = other.color_space;
    return copy;
}

RgbPixels display_of(const Image& picture, const Image& other, Context& ctx) {
    return picture.color_space.empty() ? display_values(spaced(picture, other), ctx)
                                       : display_values(picture, ctx);
}

std::vector<float> value_map(const RgbPixels& a, const RgbPixels& b, ErrorKind kind) {
    std::vector<float> map(size_t(a.width) * size_t(a.height));
    for (size_t i = 0; i < map.size(); ++i) {
        double sum = 0;
        for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
            const double difference = double(a.values[c]) - b.values[c];
            sum += kind == ErrorKind::relative ? square(difference) / (square(b.values[c]) + 0.01)
                                               : std::abs(difference);
        }
        map[i] = float(kind == ErrorKind::relative ? std::sqrt(sum / 3) : sum / 3);
    }
    return map;
}

}  // namespace

Comparison compare_pictures(const Image& picture, const Image& reference, Context& ctx,
                            ErrorKind kind, float range, const Image* where) {
    check_alike(picture, reference);
    const RgbPixels a = rgb_values(picture), b = rgb_values(reference);
    if (a.not_finite)
        ctx.warn(
            fmt::format("{} values of the picture are NaN or infinite; taken as 0", a.not_finite));
    if (b.not_finite)
        ctx.warn(fmt::format("{} values of the reference are NaN or infinite; taken as 0",
                             b.not_finite));
    const double count = double(a.values.size());
    Comparison result;
    Measures& m = result.measures;
    const std::vector<float> weights = weights_of(where, reference);
    const auto weight = [&](size_t i) { return weights.empty() ? 1.0 : double(weights[i / 3]); };
    const double weighed = weights.empty() ? count : sum_over(a, ctx, weight);
    m.rmse = std::sqrt(
        sum_over(a, ctx,
                 [&](size_t i) { return weight(i) * square(double(a.values[i]) - b.values[i]); }) /
        weighed);
    m.rel_mse = sum_over(a, ctx,
                         [&](size_t i) {
                             return weight(i) * square(double(a.values[i]) - b.values[i]) /
                                    (square(b.values[i]) + 0.01);
                         }) /
                weighed;
    const RgbPixels da = display_of(picture, reference, ctx),
                    db = display_of(reference, picture, ctx);
    const double mse =
        sum_over(da, ctx, [&](size_t i) { return square(double(da.values[i]) - db.values[i]); }) /
        count;
    m.psnr = -10 * std::log10(mse);
    m.ssim = ssim(da, db, ctx);
    const std::vector<float> map = flip_map(db, da, usual_pixels_per_degree, ctx);
    double total = 0;
    for (const float value : map) total += value;
    m.flip = total / double(map.size());
    result.error = false_color(kind == ErrorKind::flip ? map : value_map(a, b, kind), a.width,
                               a.height, range);
    return result;
}

Comparison compare_files(const std::string& picture, const std::string& reference, Context& ctx) {
    const Image a = read_picture(picture), b = read_picture(reference);
    try {
        return compare_pictures(a, b, ctx);
    } catch (const Error& e) {
        throw Error(fmt::format("{} against {}: {}", picture, reference, e.what()));
    }
}

Table measures_table() {
    return Table({"picture", "rmse", "relmse", "psnr", "ssim", "flip"});
}

void add_row(Table& table, const std::string& name, const Measures& m) {
    table.add({name, m.rmse, m.rel_mse, m.psnr, m.ssim, m.flip});
}

std::vector<float> error_map(const Image& picture, const Image& reference, ErrorKind kind,
                             Context& ctx) {
    check_alike(picture, reference);
    if (kind == ErrorKind::flip)
        return flip_map(display_of(reference, picture, ctx), display_of(picture, reference, ctx),
                        usual_pixels_per_degree, ctx);
    return value_map(rgb_values(picture), rgb_values(reference), kind);
}

Image false_color(const std::vector<float>& map, int width, int height, float range) {
    constexpr float knots[5][3] = {{0.00f, 0.00f, 0.05f},
                                   {0.25f, 0.07f, 0.45f},
                                   {0.72f, 0.19f, 0.36f},
                                   {0.97f, 0.55f, 0.18f},
                                   {0.99f, 0.98f, 0.80f}};
    Image image(width, height, 3);
    image.color_space = image.display = "sRGB";
    for (size_t i = 0; i < map.size(); ++i) {
        const float at = 4 * std::min(std::max(map[i] / range, 0.0f), 1.0f);
        const int k = std::min(int(at), 3);
        const float part = at - float(k);
        for (int c = 0; c < 3; ++c)
            image.pixels()[3 * i + size_t(c)] =
                knots[k][c] + part * (knots[k + 1][c] - knots[k][c]);
    }
    return image;
}

}  // namespace weft
