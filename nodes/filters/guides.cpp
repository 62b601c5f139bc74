#include "filters/guides.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "image/image_cost.h"
#include "runtime/isa.h"

namespace weft {
namespace {

using kernel::Planes;
using kernel::Similarity;
using kernel::Term;

constexpr int rows_at_once = 16;
constexpr float largest = 1e18f;   // whose square is still a float
constexpr float far_away = 1e15f;  // what a feature that is not finite becomes

void check_size(const Image& image, const Image* other, std::string_view name) {
    if (!other || (other->width() == image.width() && other->height() == image.height())) return;
    throw Error(fmt::format("'{}' is {} x {}, the picture {} x {}; expected the same size", name,
                            other->width(), other->height(), image.width(), image.height()));
}

// Channel numbers, those of the colour first.
struct ColorFirst {
    std::vector<int> order;
    int colors = 0;
};
ColorFirst color_first(const Image& image) {
    ColorFirst found;
    const int rgb[3] = {image.find("R"), image.find("G"), image.find("B")};
    if (rgb[0] >= 0 && rgb[1] >= 0 && rgb[2] >= 0) found.order.assign(rgb, rgb + 3);
    found.colors = found.order.empty() ? image.channels() : 3;
    for (int c = 0; c < image.channels(); ++c)
        if (std::find(found.order.begin(), found.order.end(), c) == found.order.end())
            found.order.push_back(c);
    return found;
}

// Where a picture has its variance of each of these channels.
std::vector<int> alike(const Image& image, const std::vector<int>& channels, const Image& variance,
                       std::string_view name) {
    std::vector<int> found;
    for (const int c : channels) {
        const std::string& channel = image.names()[size_t(c)];
        found.push_back(variance.find(channel));
        if (found.back() < 0)
            throw Error(fmt::format(
                "'{}' has no channel {}; it has {}: link what 'pixel-features' calls so", name,
                channel, fmt::join(variance.names(), " ")));
    }
    return found;
}

// "normal" of "normal.x"; R G B are one layer, "rgb".
std::string layer_of(const std::string& channel) {
    if (channel == "R" || channel == "G" || channel == "B") return "rgb";
    return channel.substr(0, channel.find('.'));
}

struct Layer {
    std::string name;
    std::vector<int> channels;
    float sigma = 1;
};
std::vector<Layer> layers_of(const Image& features, const LayerChoice& choice) {
    std::vector<Layer> all;
    for (int c = 0; c < features.channels(); ++c) {
        const std::string name = layer_of(features.names()[size_t(c)]);
        auto at = std::find_if(all.begin(), all.end(), [&](auto& l) { return l.name == name; });
        if (at == all.end()) at = all.insert(all.end(), Layer{name, {}, 1});
        at->channels.push_back(c);
    }
    std::vector<Layer> chosen;
    std::vector<std::string> names;
    for (const Layer& layer : all) names.push_back(layer.name);
    for (const std::string& name : choice.layers.empty() ? names : choice.layers) {
        const auto at =
            std::find_if(all.begin(), all.end(), [&](auto& l) { return l.name == name; });
        if (at == all.end())
            throw Error(
                fmt::format("'features' has no layer {}; it has {}", name, fmt::join(names, ", ")));
        chosen.push_back(*at);
    }
    if (choice.sigmas.size() != 1 && choice.sigmas.size() != chosen.size())
        throw Error(
            fmt::format("'sigmas' has {} values for the layers {}; expected one for all or "
                        "one each",
                        choice.sigmas.size(), fmt::join(names, ", ")));
    for (size_t i = 0; i < chosen.size(); ++i) {
        chosen[i].sigma = choice.sigmas[choice.sigmas.size() == 1 ? 0 : i];
        if (!(chosen[i].sigma > 0))
            throw Error(fmt::format("'sigmas' has {} for {}; expected a number above 0",
                                    chosen[i].sigma, chosen[i].name));
    }
    return chosen;
}

// Squared changes of a layer from the pixels of row y to those (dx, dy) away, its noise taken off;
// 0 where either is not finite: there is no slope to that.
void changes(const Planes& planes, const Term& term, int y, int dx, int dy, float* to) {
    const auto width = size_t(planes.width - dx);
    std::fill_n(to, width, 0.0f);
    for (int c = 0; c < term.components; ++c) {
        const float *a = planes.row(term.first + c, y),
                    *b = planes.row(term.first + c, y + dy) + dx;
        for (size_t x = 0; x < width; ++x) to[x] += (a[x] - b[x]) * (a[x] - b[x]);
    }
    if (term.variances >= 0) {
        const float *va = planes.row(term.variances, y),
                    *vb = planes.row(term.variances, y + dy) + dx;
        for (size_t x = 0; x < width; ++x) to[x] -= va[x] + vb[x];
    }
    for (size_t x = 0; x < width; ++x) to[x] = to[x] < far_away ? std::max(0.0f, to[x]) : 0.0f;
}

// Of each pixel of some rows: changes to the next pixel along both axes, each on the side where it
// changes less: an edge is no slope.
void slopes(Planes& planes, const Term& term, Rows rows) {
    const int width = planes.width;
    std::vector<float> right(size_t(width) + 1), up(size_t(width) + 1), down(up);
    const bool alone = width < 2;
    if (rows.begin > 0) changes(planes, term, rows.begin - 1, 0, 1, down.data());
    for (int y = rows.begin; y < rows.end; ++y) {
        std::swap(up, down);
        const bool above = y > 0, below = y + 1 < planes.height;
        if (below) changes(planes, term, y, 0, 1, down.data());
        if (!alone) changes(planes, term, y, 1, 0, right.data());
        float* to = planes.row(term.slope, y);
        for (int x = 0; x < width; ++x) {
            const float *r = &right[size_t(x)], u = up[size_t(x)], d = down[size_t(x)];
            const float across = alone            ? 0
                                 : x == 0         ? r[0]
                                 : x + 1 == width ? r[-1]
                                                  : std::min(r[-1], r[0]);
            to[x] = across + (above && below ? std::min(u, d) : above ? u : below ? d : 0.0f);
        }
    }
}

// Squared deviation of a layer over the picture, its noise taken off; places that are not finite
// do not count.
double deviation2(const Planes& planes, const Term& term, Context& ctx) {
    struct Sum {
        double n = 0, value = 0, square = 0, noise = 0;
    };
    double total = 0;
    for (int c = 0; c < term.components; ++c) {
        // About a value of the layer itself, so that squares of large values do not cancel.
        double about = 0;
        for (int y = 0, found = 0; y < planes.height && !found; ++y)
            for (int x = 0; x < planes.width && !found; ++x)
                if (planes.row(term.first + c, y)[x] < 0.5f * far_away)
                    about = double(planes.row(term.first + c, y)[x]), found = 1;
        const Sum sum = ctx.reduce<Sum>(
            size_t(planes.height), rows_at_once, {},
            [&](size_t begin, size_t end) {
                Sum s;
                for (int y = int(begin); y < int(end); ++y)
                    for (int x = 0; x < planes.width; ++x) {
                        const float value = planes.row(term.first + c, y)[x];
                        if (value >= 0.5f * far_away) continue;
                        const double v = double(value) - about;
                        s.n += 1, s.value += v, s.square += v * v;
                        if (term.variances >= 0 && c == 0)
                            s.noise += double(planes.row(term.variances, y)[x]);
                    }
                return s;
            },
            [](Sum a, const Sum& b) {
                a.n += b.n, a.value += b.value, a.square += b.square, a.noise += b.noise;
                return a;
            });
        if (sum.n > 0) total += (sum.square - sum.value * sum.value / sum.n - sum.noise) / sum.n;
    }
    return std::max(0.0, total);
}

}  // namespace

Guides guides_of(const Inputs& in) {
    return {&in.get<Image>("image"), in.find<Image>("variance"), in.find<Image>("features"),
            in.find<Image>("features-variance"), in.find<Image>("mask")};
}

std::vector<kernel::Tap> window(int radius, float sigma) {
    std::vector<kernel::Tap> taps;
    for (int dy = -radius; dy <= radius; ++dy)
        for (int dx = -radius; dx <= radius; ++dx)
            taps.push_back(
                {dx, dy,
                 sigma > 0 ? std::exp(-float(dx * dx + dy * dy) / (2 * sigma * sigma)) : 1.0f});
    return taps;
}

Similarity similarity_of(const Guides& guides, int reach, int patch, Context& ctx) {
    const Image& image = *guides.image;
    check_size(image, guides.variance, "variance");
    check_size(image, guides.features, "features");
    check_size(image, guides.features_variance, "features-variance");
    check_size(image, guides.mask, "mask");
    if (guides.mask && guides.mask->channels() < 1) throw Error("'mask' has no channel");
    const ColorFirst channels = color_first(image);
    std::vector<int> variances;
    if (guides.variance)
        variances = alike(image, {channels.order.begin(), channels.order.begin() + channels.colors},
                          *guides.variance, "variance");

    Similarity by;
    by.patch = patch;
    by.channels = image.channels();
    by.color.components = channels.colors;
    by.color.variances = guides.variance ? by.channels : -1;
    by.color.variance_planes = int(variances.size());
    by.known = by.channels + int(variances.size());
    int planes = by.known + 1;
    if (guides.features)  // and a plane of noise and one of slope a layer
        planes += guides.features->channels() + 2 * int(layers_of(*guides.features, {}).size());
    by.planes = Planes(image.width(), image.height(), planes,
                       std::min(reach, std::max(0, image.width() - 1)) + patch);

    const int alpha = guides.mask ? std::max(0, guides.mask->find("A")) : 0;
    std::atomic<bool> holes = false;
    ctx.parallel_rows(
        image.height(),
        [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y)
                for (int x = 0; x < image.width(); ++x) {
                    const float* from = image.at(x, y);
                    bool known = true;
                    for (int c = 0; c < by.channels; ++c) known &= std::fabs(from[c]) <= largest;
                    for (const int c : variances)
                        known &= guides.variance->at(x, y)[c] <= largest * largest;
                    if (guides.mask) {
                        const float part = guides.mask->at(x, y)[alpha];
                        known &= part < 0 || part > 0;
                    }
                    by.planes.row(by.known, y)[x] = known ? 1.0f : 0.0f;
                    if (!known) {
                        holes = true;
                        continue;
                    }
                    for (size_t c = 0; c < channels.order.size(); ++c)
                        by.planes.row(int(c), y)[x] = from[channels.order[c]];
                    for (size_t c = 0; c < variances.size(); ++c)
                        by.planes.row(by.channels + int(c), y)[x] =
                            std::max(0.0f, guides.variance->at(x, y)[variances[c]]);
                }
        },
        rows_at_once);
    by.holes = holes;
    return by;
}

void add_features(const Guides& guides, const LayerChoice& choice, Similarity& by, Context& ctx) {
    if (!guides.features || guides.features->channels() == 0) {
        if (!choice.layers.empty())
            throw Error(fmt::format("'layers' asks for {}, but no features are linked",
                                    fmt::join(choice.layers, ", ")));
        return;
    }
    const Image& features = *guides.features;
    const Image* noise = guides.features_variance;
    int next = by.known + 1;
    for (const Layer& layer : layers_of(features, choice)) {
        const std::vector<int> variances =
            noise ? alike(features, layer.channels, *noise, "features-variance")
                  : std::vector<int>();
        Term term;
        const auto n = int(layer.channels.size());
        term.first = next;
        term.components = n;
        term.slope = next + n;
        term.variances = noise ? next + n + 1 : -1;
        term.variance_planes = noise ? 1 : 0;
        ctx.parallel_rows(
            features.height(),
            [&](Rows rows) {
                for (int y = rows.begin; y < rows.end; ++y)
                    for (int x = 0; x < features.width(); ++x) {
                        bool finite = true;
                        float variance = 0;
                        for (const int c : layer.channels)
                            finite &= std::fabs(features.at(x, y)[c]) < 0.5f * far_away;
                        for (int c = 0; c < n; ++c)
                            by.planes.row(term.first + c, y)[x] =
                                finite ? features.at(x, y)[layer.channels[size_t(c)]] : far_away;
                        for (const int c : variances) {
                            const float v = noise->at(x, y)[c];
                            if (finite && v > 0 && v < largest) variance += v;
                        }
                        if (noise) by.planes.row(term.variances, y)[x] = variance;
                    }
            },
            rows_at_once);
        const double deviation = deviation2(by.planes, term, ctx);
        ctx.parallel_rows(
            features.height(), [&](Rows rows) { slopes(by.planes, term, rows); }, rows_at_once);
        term.k2 = choice.k_features * choice.k_features;
        term.slope_gain = 2 * layer.sigma * layer.sigma;
        // Never 0: a layer that is the same all over, but for places that are not finite.
        term.e = std::max(1e-30f, 2 * choice.least * choice.least * float(deviation));
        by.features.push_back(term);
        next += n + 2;
    }
}

Planes means(const Similarity& by, Context& ctx, double done, double of, Planes room) {
    const Planes& planes = by.planes;
    constexpr int block_width = 128, block_height = 32;
    Planes out = std::move(room);
    if (out.width != planes.width || out.height != planes.height ||
        out.count != kernel::output_planes(by))
        out = Planes(planes.width, planes.height, kernel::output_planes(by), 0);
    const int across = (planes.width + block_width - 1) / block_width,
              down = (planes.height + block_height - 1) / block_height;
    std::atomic<size_t> blocks = 0;
    const auto all = size_t(across) * size_t(down);
    const auto kernel = [] {
        using namespace kernel;
        return WEFT_PICK(similar_means);
    }();
    ctx.parallel(all, 1, [&](size_t begin, size_t end) {
        kernel::SimilarityScratch scratch;
        for (size_t i = begin; i < end; ++i) {
            const int x = int(i % size_t(across)) * block_width,
                      y = int(i / size_t(across)) * block_height;
            kernel(by,
                   {x, y, std::min(x + block_width, planes.width),
                    std::min(y + block_height, planes.height)},
                   scratch, out);
        }
        ctx.progress(double(all) * done + double(blocks += end - begin), double(all) * of,
                     "blocks");
    });
    return out;
}

Image picture_of(const Planes& means, const Guides& guides, const Similarity& by, Context& ctx) {
    Image picture = Image::like(*guides.image);
    const std::vector<int> order = color_first(picture).order;
    std::atomic<size_t> empty = 0;
    ctx.parallel_rows(
        picture.height(),
        [&](Rows rows) {
            for (int y = rows.begin; y < rows.end; ++y) {
                const float* total = means.row(means.count - 1, y);
                for (int x = 0; x < picture.width(); ++x) {
                    empty += !(total[x] > 0);
                    for (int c = 0; c < by.channels; ++c)
                        picture.at(x, y)[order[size_t(c)]] = means.row(c, y)[x];
                }
            }
        },
        rows_at_once);
    if (empty > 0)
        ctx.warn(
            fmt::format("{} of {} pixels are masked or not finite with no other pixel within "
                        "reach; they are 0",
                        empty.load(), size_t(picture.width()) * size_t(picture.height())));
    return picture;
}

Cost similarity_cost(const Shapes& in, double taps, int patch) {
    const Shape image = in["image"], features = in["features"];
    const double channels = double(image.channels), layers = double(features.channels),
                 planes = 3 * channels + 2 + 3 * layers,
                 operations = taps * (20 + 8 * channels + 4 * patch + 6 * layers);
    return cost_like(in, "image", "image", 0, planes, operations);
}

}  // namespace weft
