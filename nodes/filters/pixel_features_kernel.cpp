#include "filters/pixel_features_kernel.h"

#include <cmath>
#include <limits>
#include <vector>

namespace weft::kernel {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

float weight_of(const PixelMoments& in, size_t sample) {
    const float w = in.weight.empty() ? 1.0f : in.weight[sample];
    return w > 0 && w < infinity ? w : 0.0f;
}

enum class Value { finite, infinite, bad };
Value kind_of(const PixelMoments& in, size_t sample) {
    const float* v = &in.values[sample * size_t(in.components)];
    bool finite = true, infinite = in.may_be_infinite;
    for (int c = 0; c < in.components; ++c) {
        finite &= std::isfinite(v[c]);
        infinite &= v[c] == infinity;
    }
    return finite ? Value::finite : infinite ? Value::infinite : Value::bad;
}

// Sums over samples that count.
struct Moments {
    explicit Moments(int components) : mean(size_t(components)), square(size_t(components)) {}

    double weight = 0, weight2 = 0;
    size_t count = 0, infinite = 0, dropped = 0, first_dropped = 0;
    std::vector<double> mean, square;  // of values; sum of w^2 (x - mean)^2

    void clear() {
        weight = weight2 = 0;
        count = infinite = dropped = 0;
        std::fill(mean.begin(), mean.end(), 0.0);
        std::fill(square.begin(), square.end(), 0.0);
    }
    template <class Each>  // each(work): calls work(sample) for all samples
    void take(const PixelMoments& in, const Each& each, bool deviations) {
        clear();
        const size_t n = size_t(in.components);
        each([&](size_t s) {
            const double w = double(weight_of(in, s));
            const Value kind = kind_of(in, s);
            if (kind == Value::bad && dropped++ == 0) first_dropped = s;
            infinite += kind == Value::infinite;
            if (kind != Value::finite || w == 0) return;
            ++count;
            weight += w;
            weight2 += w * w;
            for (size_t c = 0; c < n; ++c) mean[c] += w * double(in.values[s * n + c]);
        });
        if (count == 0) return;
        for (double& m : mean) m /= weight;
        if (!deviations) return;
        each([&](size_t s) {
            const double w = double(weight_of(in, s));
            if (w == 0 || kind_of(in, s) != Value::finite) return;
            for (size_t c = 0; c < n; ++c) {
                const double off = double(in.values[s * n + c]) - mean[c];
                square[c] += w * w * off * off;
            }
        });
    }
    double variance_of_mean(size_t component) const {
        return square[component] / (weight * weight - weight2);
    }
};

}  // namespace

DroppedSamples moment_rows(const PixelMoments& in, int begin, int end, size_t stride, float* mean,
                           float* variance, float* used) {
    const Samples& samples = *in.samples;
    const int width = samples.width;
    DroppedSamples dropped;
    Moments own(in.components), around(in.components);
    const auto samples_of = [&](int x, int y, const auto& work) {
        const auto range = samples.of_pixel(size_t(y) * size_t(width) + size_t(x));
        for (size_t s = range.begin; s < range.end; ++s) work(s);
    };
    for (int y = begin; y < end; ++y)
        for (int x = 0; x < width; ++x) {
            const size_t pixel = size_t(y) * size_t(width) + size_t(x);
            own.take(
                in, [&](const auto& work) { samples_of(x, y, work); }, variance != nullptr);
            if (own.dropped > 0 && dropped.count == 0) dropped.first = own.first_dropped;
            dropped.count += own.dropped;
            for (size_t c = 0; c < own.mean.size(); ++c)
                mean[pixel * stride + c] =
                    own.count == 0 && own.infinite > 0 ? infinity : float(own.mean[c]);
            if (used) used[pixel] = float(own.count);
            if (!variance) continue;
            float* to = variance + pixel * stride;
            for (size_t c = 0; c < own.mean.size(); ++c) to[c] = 0;
            if (own.count > 1) {
                for (size_t c = 0; c < own.mean.size(); ++c) to[c] = float(own.variance_of_mean(c));
            } else if (own.count == 1) {
                around.take(
                    in,
                    [&](const auto& work) {
                        for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, samples.height - 1);
                             ++ny)
                            for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, width - 1);
                                 ++nx)
                                samples_of(nx, ny, work);
                    },
                    true);
                if (around.count < 2) continue;
                // A sample's variance is that of the mean of n times (sum w)^2 / sum w^2, their
                // effective number.
                const double effective = around.weight * around.weight / around.weight2;
                for (size_t c = 0; c < own.mean.size(); ++c)
                    to[c] = float(around.variance_of_mean(c) * effective);
            }
        }
    return dropped;
}

}  // namespace weft::kernel
