#include "filters/pixel_filter_kernel.h"

#include <limits>

namespace weft::kernel {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

// A channel's running mean.
struct Sum {
    double weight = 0, size = 0;  // sums of weights and of their absolute values
    bool infinite = false;        // met a sample that is +inf here
};

bool usable(float weight) {
    return weight > 0 && weight < infinity;
}

// Whether all values are finite; +inf in all of them is told apart.
bool finite(const float* v, int components, bool& all_infinite) {
    bool good = true;
    all_infinite = true;
    for (int c = 0; c < components; ++c) {
        good &= std::isfinite(v[c]);
        all_infinite &= v[c] == infinity;
    }
    return good;
}

// Weights that cancel to less than this part of themselves say nothing.
constexpr double least_share = 1e-3;

// Puts a pixel's mean; false where a channel got no sample.
bool put(const FilterInput& in, const Sum* sums, const double* totals, float* out) {
    bool reached = true;
    int k = 0;
    for (size_t c = 0; c < in.channels.size(); ++c) {
        const Sum& sum = sums[c];
        const bool good = sum.weight > least_share * sum.size;
        for (int i = 0; i < in.channels[c].components; ++i, ++k)
            out[k] = good ? float(totals[k] / sum.weight) : sum.infinite ? infinity : 0.0f;
        reached &= good || sum.infinite;
    }
    return reached;
}

// Adds a sample with weight w.
void add(const FilterInput& in, size_t sample, float w, Sum* sums, double* totals) {
    int k = 0;
    for (size_t c = 0; c < in.channels.size(); ++c) {
        const int n = in.channels[c].components;
        const float* v = in.channels[c].values.data() + sample * size_t(n);
        bool all_infinite;
        if (finite(v, n, all_infinite)) {
            sums[c].weight += double(w);
            sums[c].size += double(std::fabs(w));
            for (int i = 0; i < n; ++i) totals[k + i] += double(w) * double(v[i]);
        } else {
            sums[c].infinite |= all_infinite;
        }
        k += n;
    }
}

int reach_of(const FilterInput& in, float radius) {
    return std::max(0, int(std::ceil(radius - 0.5f))) + in.slack;
}

// One pixel wide box, samples in their pixels: nothing to weigh.
size_t box_rows(const FilterInput& in, int begin, int end, float* out) {
    const Samples& samples = *in.samples;
    const int components = in.components();
    std::vector<Sum> sums(in.channels.size());
    std::vector<double> totals(static_cast<size_t>(components));
    size_t missing = 0;
    for (int y = begin; y < end; ++y)
        for (int x = 0; x < samples.width; ++x, out += components) {
            std::fill(sums.begin(), sums.end(), Sum{});
            std::fill(totals.begin(), totals.end(), 0.0);
            const auto range = samples.of_pixel(size_t(y) * size_t(samples.width) + size_t(x));
            for (size_t s = range.begin; s < range.end; ++s) {
                const float w = in.weight.empty() ? 1.0f : in.weight[s];
                if (usable(w)) add(in, s, w, sums.data(), totals.data());
            }
            missing += !put(in, sums.data(), totals.data(), out);
        }
    return missing;
}

template <class Filter>
size_t weighted_rows(const FilterInput& in, const Filter& filter, int begin, int end, float* out) {
    const Samples& samples = *in.samples;
    const int width = samples.width, reach = reach_of(in, filter.radius), span = 2 * reach + 1;
    const int components = in.components();
    const size_t channels = in.channels.size(), pixels = size_t(width) * size_t(end - begin);
    std::vector<Sum> sums(pixels * channels);
    std::vector<double> totals(pixels * size_t(components));
    std::vector<float> across(static_cast<size_t>(span)), down(static_cast<size_t>(span));

    for (int sy = std::max(begin - reach, 0); sy < std::min(end + reach, samples.height); ++sy)
        for (int sx = 0; sx < width; ++sx) {
            const auto range = samples.of_pixel(size_t(sy) * size_t(width) + size_t(sx));
            for (size_t s = range.begin; s < range.end; ++s) {
                const float own = in.weight.empty() ? 1.0f : in.weight[s];
                if (!usable(own)) continue;
                const float x = in.xy[2 * s], y = in.xy[2 * s + 1];
                for (int i = 0; i < span; ++i) {
                    across[size_t(i)] = filter.evaluate(x - (float(sx - reach + i) + 0.5f));
                    down[size_t(i)] = filter.evaluate(y - (float(sy - reach + i) + 0.5f));
                }
                const int y0 = std::max(sy - reach, begin), y1 = std::min(sy + reach, end - 1);
                const int x0 = std::max(sx - reach, 0), x1 = std::min(sx + reach, width - 1);
                for (int py = y0; py <= y1; ++py) {
                    const float wy = own * down[size_t(py - sy + reach)];
                    if (wy == 0) continue;
                    for (int px = x0; px <= x1; ++px) {
                        const float w = wy * across[size_t(px - sx + reach)];
                        if (!(std::fabs(w) > 0)) continue;
                        const size_t p = size_t(py - begin) * size_t(width) + size_t(px);
                        add(in, s, w, &sums[p * channels], &totals[p * size_t(components)]);
                    }
                }
            }
        }
    size_t missing = 0;
    for (size_t p = 0; p < pixels; ++p)
        missing += !put(in, &sums[p * channels], &totals[p * size_t(components)],
                        out + p * size_t(components));
    return missing;
}

}  // namespace

int FilterInput::components() const {
    int n = 0;
    for (const Source& source : channels) n += source.components;
    return n;
}

FilterInput filter_input(const Samples& samples, const std::vector<const Channel*>& channels) {
    FilterInput in{&samples, samples.xy(), samples.values("weight"), {}, 0};
    for (const Channel* channel : channels)
        in.channels.push_back({channel->values.view(), channel->components});
    float outside = 0;
    for (size_t p = 0; p < samples.pixels(); ++p) {
        const auto x = float(p % size_t(samples.width)), y = float(p / size_t(samples.width));
        const auto range = samples.of_pixel(p);
        for (size_t s = range.begin; s < range.end; ++s) {
            const float dx = in.xy[2 * s] - x, dy = in.xy[2 * s + 1] - y;
            if (dx >= 0 && dx < 1 && dy >= 0 && dy < 1) continue;
            // A sample on the far edge of its pixel is in the next: even then a pixel of slack.
            const float out = std::max(std::max(-dx, dx - 1), std::max(-dy, dy - 1));
            if (out >= 0) outside = std::max(outside, std::max(out, 0.5f));
        }
    }
    in.slack = int(std::ceil(std::min(outside, 2.0f)));
    return in;
}

size_t filter_rows(const FilterInput& in, const PixelFilter& filter, int begin, int end,
                   float* out) {
    if (is_pixel_box(filter) && in.slack == 0) return box_rows(in, begin, end, out);
    return std::visit([&](const auto& f) { return weighted_rows(in, f, begin, end, out); }, filter);
}

bool filter_pixel(const FilterInput& in, const PixelFilter& filter, int x, int y, float* out) {
    const Samples& samples = *in.samples;
    const int reach = reach_of(in, radius_of(filter));
    std::vector<Sum> sums(in.channels.size());
    std::vector<double> totals(size_t(in.components()));
    for (int sy = std::max(y - reach, 0); sy <= std::min(y + reach, samples.height - 1); ++sy)
        for (int sx = std::max(x - reach, 0); sx <= std::min(x + reach, samples.width - 1); ++sx) {
            const auto range = samples.of_pixel(size_t(sy) * size_t(samples.width) + size_t(sx));
            for (size_t s = range.begin; s < range.end; ++s) {
                const float own = in.weight.empty() ? 1.0f : in.weight[s];
                if (!usable(own)) continue;
                const float w = own * evaluate(filter, in.xy[2 * s + 1] - (float(y) + 0.5f)) *
                                evaluate(filter, in.xy[2 * s] - (float(x) + 0.5f));
                if (std::fabs(w) > 0) add(in, s, w, sums.data(), totals.data());
            }
        }
    return put(in, sums.data(), totals.data(), out);
}

size_t nearest_rows(const FilterInput& in, int begin, int end, float* out) {
    const Samples& samples = *in.samples;
    const int components = in.components();
    size_t missing = 0;
    for (int y = begin; y < end; ++y)
        for (int x = 0; x < samples.width; ++x, out += components) {
            const float cx = float(x) + 0.5f, cy = float(y) + 0.5f;
            float best = infinity;
            size_t nearest = 0;
            for (int sy = std::max(y - 1, 0); sy <= std::min(y + 1, samples.height - 1); ++sy)
                for (int sx = std::max(x - 1, 0); sx <= std::min(x + 1, samples.width - 1); ++sx) {
                    const auto range =
                        samples.of_pixel(size_t(sy) * size_t(samples.width) + size_t(sx));
                    for (size_t s = range.begin; s < range.end; ++s) {
                        const float dx = in.xy[2 * s] - cx, dy = in.xy[2 * s + 1] - cy;
                        const float distance = dx * dx + dy * dy;
                        if (distance < best) best = distance, nearest = s;
                    }
                }
            if (best == infinity) ++missing;
            int k = 0;
            for (const auto& channel : in.channels)
                for (int i = 0; i < channel.components; ++i, ++k)
                    out[k] = best == infinity
                                 ? 0.0f
                                 : channel.values[nearest * size_t(channel.components) + size_t(i)];
        }
    return missing;
}

}  // namespace weft::kernel
