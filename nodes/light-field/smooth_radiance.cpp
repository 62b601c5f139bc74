// smooth-radiance: less noise in a sample buffer's radiance where it is noisy, and more contrast in
// fine detail where it is not, to make up for the filter to come (smooth_radiance_kernel.h says
// how). Only rgb changes.
#include "light-field/smooth_radiance_kernel.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "light-field/build_hierarchy_kernel.h"
#include "runtime/node.h"

namespace weft {
namespace light_field {

namespace {

// Adds the blocks of a row: runs of its samples, no wider than what they look at.
void add_blocks(int row, SampleField& s) {
    const auto x_of = [&](std::uint32_t i) { return s.x[i - s.first]; };
    const auto end = std::uint32_t(s.start_of(row + 1));
    for (auto i = std::uint32_t(s.start_of(row)); i < end;) {
        const std::uint32_t begin = i, most = std::min(end, i + std::uint32_t(SampleField::block_size));
        while (++i < most && std::abs(x_of(i) - x_of(begin)) < s.block_width) {
        }
        s.blocks.push_back({begin, i});
    }
}

// Recentres count samples, which `from` has: work(k, path, x, y) for each. One behind the camera at
// half time is where it was seen, at depth 1.
template <class Work>
void each_place(const Places& from, const Lens& lens, size_t count, Work&& work) {
    std::array<std::array<float, Fetched::most>, 6> path{};
    auto& [X, Y, W, VX, VY, VW] = path;
    WEFT_PICK(recentre)
    (from, lens, count, {X.data(), Y.data(), W.data(), VX.data(), VY.data(), VW.data()});
    for (size_t k = 0; k < count; ++k) {
        Recentred p{X[k], Y[k], W[k], VX[k], VY[k], VW[k]};
        if (!(p.W > 0)) p = {from.xy[2 * k], from.xy[2 * k + 1], 1, 0, 0, 0};
        work(k, p, p.X / p.W, p.Y / p.W);
    }
}

Lens lens_of(const Samples& samples) {
    return samples.has_lens() ? *samples.lens : Lens{};
}

}  // namespace

void Stretch::lay_out(size_t room, std::span<std::span<float>* const> arrays) {
    constexpr size_t spare = 16;  // vectors may be read past the end
    length = room + spare;
    memory.resize(length * arrays.size());
    std::span<float> rest(memory);
    for (std::span<float>* array : arrays) {
        *array = rest.first(length);
        rest = rest.subspan(length);
    }
}

void Stretch::shift(size_t from, size_t end) {
    for (auto array = memory.begin(); array != memory.end(); array += std::ptrdiff_t(length))
        std::copy(array + std::ptrdiff_t(from), array + std::ptrdiff_t(end), array);
}

Filtered::Filtered(size_t room, size_t colors) {
    std::vector<std::span<float>*> arrays{&weight};
    for (Rgb& of : std::span(color).first(colors)) arrays.insert(arrays.end(), {&of.r, &of.g, &of.b});
    lay_out(room, arrays);
}

Changes::Changes(size_t room, size_t colors) {
    std::vector<std::span<float>*> arrays;
    for (Of& of : std::span(color).first(colors)) {
        for (Change& change : of) arrays.insert(arrays.end(), {&change.gain, &change.way});
        for (Change& change : std::span(of).first(Smoothing::widths - 1))
            arrays.insert(arrays.end(), {&change.r, &change.g, &change.b});
    }
    lay_out(room, arrays);
}

SampleField sample_field(const Samples& samples, float radius, Context& ctx) {
    const size_t n = samples.size();
    const Lens lens = lens_of(samples);
    SampleField s;
    s.size = n;
    // Positions may lie outside the picture by what lens and motion move them; beyond a quarter
    // they share cells.
    const float border = 0.25f * float(std::max(samples.width, samples.height));
    // There are some 4.8 samples in a square of the radius.
    s.cell_width = 0.3f * radius;
    s.cell_height = 1.8f * radius;
    s.block_width = 4 * radius;
    s.x0 = s.y0 = -border;
    s.columns = int((float(samples.width) + 2 * border) / s.cell_width) + 1;
    s.rows = int((float(samples.height) + 2 * border) / s.cell_height) + 1;
    s.moving = samples.has_motion();
    const Places places = places_of(samples);
    LargeArray<std::uint32_t> cell(n);
    ctx.parallel(n, 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; i += Fetched::most)
            each_place(places.from(i), lens, std::min(Fetched::most, end - i),
                       [&](size_t k, const Recentred&, float x, float y) {
                           cell[i + k] = std::uint32_t(s.row_of(y) * s.columns + s.column_of(x));
                       });
    });
    // Counted one cell too far, so that each start is back at its own once its samples are put.
    s.start.assign(size_t(s.columns) * size_t(s.rows) + 2, 0);
    for (std::uint32_t c : cell) ++s.start[c + 2];
    for (size_t c = 2; c < s.start.size(); ++c) s.start[c] += s.start[c - 1];
    s.order.resize(n);
    for (size_t i = 0; i < n; ++i) s.order[s.start[cell[i] + 1]++] = std::uint32_t(i);
    return s;
}

void make_room(const Samples& samples, size_t room, SampleField& s) {
    std::vector<std::span<float>*> arrays{&s.x,          &s.y,          &s.slope,
                                          &s.velocity_x, &s.velocity_y, &s.log_depth};
    for (Rgb& of : std::span(s.color).first(s.colors)) arrays.insert(arrays.end(), {&of.r, &of.g, &of.b});
    const auto add = [&](const char* channel, std::array<std::span<float>, 3>& values) {
        if (samples.values(channel).empty()) return;
        for (std::span<float>& value : values) arrays.push_back(&value);
    };
    add("normal", s.normal);
    add("albedo", s.albedo);
    s.lay_out(room, arrays);
}

void fetch(const Samples& samples, Radiances of, int first_row, int last_row, SampleField& s,
           Context& ctx) {
    const Lens lens = lens_of(samples);
    const Places places = places_of(samples);
    const auto normal = samples.values("normal"), albedo = samples.values("albedo");
    const size_t first = s.start_of(first_row);
    ctx.parallel(s.start_of(last_row) - first, 4096, [&](size_t begin, size_t end) {
        Fetched fetched;
        for (size_t from = first + begin; from < first + end; from += Fetched::most) {
            const auto some =
                std::span(s.order).subspan(from, std::min(Fetched::most, first + end - from));
            const size_t at = from - s.first;
            fetched.fetch(places, some);
            each_place(fetched.places(places), lens, some.size(),
                       [&](size_t k, const Recentred& p, float x, float y) {
                           const size_t to = at + k;
                           s.x[to] = x;
                           s.y[to] = y;
                           s.slope[to] = lens.c0 / p.W + lens.c1;
                           s.velocity_x[to] = (p.VX - x * p.VW) / p.W;
                           s.velocity_y[to] = (p.VY - y * p.VW) / p.W;
                           s.log_depth[to] = std::log(p.W);
                       });
            for (size_t k = 0; k < some.size(); ++k) {
                const size_t i = 3 * size_t(some[k]), to = at + k;
                for (size_t c = 0; c < s.colors; ++c) {
                    s.color[c].r[to] = of[c][i];
                    s.color[c].g[to] = of[c][i + 1];
                    s.color[c].b[to] = of[c][i + 2];
                }
                if (!normal.empty()) {
                    const float* n = &normal[i];
                    const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
                    const bool none = !(length > 0 && std::isfinite(length));  // background, say
                    for (size_t c = 0; c < 3; ++c) s.normal[c][to] = none ? 0 : n[c] / length;
                }
                if (!albedo.empty())
                    for (size_t c = 0; c < 3; ++c)
                        s.albedo[c][to] = std::isfinite(albedo[i + c]) ? albedo[i + c] : 0;
            }
        }
    });
    for (int row = first_row; row < last_row; ++row) add_blocks(row, s);
}

namespace {

// The field goes through the kernels in bands of whole rows. What is within the window of a sample
// lies in `reach` rows above and below its own, what is within the narrowest kernel in `near`: so
// far other kernels have to be ahead of its treatment, and so much behind it is kept.
struct Bands {
    const SampleField& s;
    int reach, near;

    int judged(int end) const { return std::min(end + reach, s.rows); }
    int filtered(int end) const { return std::min(end + reach + near, s.rows); }
    int fetched(int end) const { return std::min(end + reach + std::max(reach, 2 * near), s.rows); }

    // Where the band that begins with a row ends: it has samples enough for many threads, and for
    // what is kept to be little beside it.
    int end(int row) const {
        constexpr size_t enough = 65536;
        int last = row + 4 * reach;
        while (last < s.rows && s.start_of(last) - s.start_of(row) < enough) ++last;
        return std::min(last, s.rows);
    }
    // The most samples that are at hand for a band.
    size_t room() const {
        size_t most = 0;
        for (int row = 0; row < s.rows; row = end(row))
            most = std::max(most, s.start_of(fetched(end(row))) - s.start_of(row - reach));
        return most;
    }
    // The first block at hand of a row.
    size_t block(int row) const {
        const auto before = [](const SampleField::Block& block, size_t sample) {
            return block.begin < sample;
        };
        return size_t(
            std::lower_bound(s.blocks.begin(), s.blocks.end(), s.start_of(row), before) -
            s.blocks.begin());
    }
};

}  // namespace

std::vector<Array<float>> smooth_radiance(const Samples& samples, Radiances of, float radius,
                                          float widest, Smoothing by, Context& ctx) {
    for (size_t k = 0; k < Smoothing::widths; ++k)
        by.width[k] = radius * std::pow(widest, float(k) / float(Smoothing::widths - 1));
    by.window = by.width.back();
    SampleField s = sample_field(samples, radius, ctx);
    s.colors = of.size();
    const Bands bands{s, int(by.window / s.cell_height) + 2, int(by.width[0] / s.cell_height) + 2};
    const size_t room = bands.room();
    make_room(samples, room, s);
    Filtered filtered(room, s.colors);
    Changes changes(room, s.colors);
    std::vector<Array<float>> smoothed;
    std::array<std::span<float>, Smoothing::most_colors> rgb;
    for (size_t c = 0; c < s.colors; ++c) {
        const auto made = std::make_shared<LargeArray<float>>(3 * s.size);
        rgb[c] = *made;
        smoothed.push_back({*made, made});
    }
    std::atomic<size_t> done = 0;
    const auto each = [&](int first_row, int last_row, auto&& work) {
        const size_t from = bands.block(first_row), to = bands.block(last_row);
        ctx.parallel(to - from, 64, [&](size_t first, size_t last) {
            work(from + first, from + last);
            const size_t count = s.blocks[from + last - 1].end - s.blocks[from + first].begin;
            ctx.progress(double(done += count), 3 * double(s.size), "samples");
        });
    };
    for (int row = 0, last = 0; row < s.rows; row = last) {
        // The band before ended where this begins; before the first there is nothing.
        const auto before = [&](int to) { return row == 0 ? 0 : to; };
        const int fetched = before(bands.fetched(row)), filtered_to = before(bands.filtered(row)),
                  judged = before(bands.judged(row));
        const size_t first = s.start_of(row - bands.reach), gone = first - s.first;
        s.shift(gone, s.start_of(fetched) - s.first);
        filtered.shift(gone, s.start_of(filtered_to) - s.first);
        changes.shift(gone, s.start_of(judged) - s.first);
        s.blocks.erase(s.blocks.begin(),
                       s.blocks.begin() + std::ptrdiff_t(bands.block(row - bands.reach)));
        s.first = first;

        last = bands.end(row);
        fetch(samples, of, fetched, bands.fetched(last), s, ctx);
        each(filtered_to, bands.filtered(last), [&](size_t from, size_t to) {
            WEFT_PICK(filter_samples)(s, by, from, to, filtered);
        });
        each(judged, bands.judged(last), [&](size_t from, size_t to) {
            WEFT_PICK(find_errors)(s, filtered, by, from, to, changes);
        });
        each(row, last, [&](size_t from, size_t to) {
            WEFT_PICK(treat)(s, filtered, changes, by, from, to, rgb.data());
        });
    }
    return smoothed;
}

}  // namespace light_field

namespace {

struct SmoothRadiance {
    float widest = 4.25f, caution = 0.5f, sharp_caution = 2, radius_scale = 1;
    float slope_tolerance = 0.6f, velocity_tolerance = 1.5f, depth_tolerance = 0.03f;
    float normal_tolerance = 0.55f, albedo_tolerance = 0.1f;

    static void declare(Ports<SmoothRadiance>& node) {
        node.about("smooths noisy radiance of samples along their surfaces and sharpens clean detail, as leave-one-out errors find good")
            .in<Samples>("samples", "xy, z and rgb; uv with a lens, t, motion, normal and albedo where it has them")
            .out<Samples>("samples", "the same with another rgb");
        declare_parameters(node);
    }
    Cost cost(const Shapes& in) const { return cost_of(in, {"samples"}); }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        smooth({{{"samples", &in.get<Samples>("samples")}}}, out, ctx);
    }

  protected:
    // Where samples come in and go out.
    struct Part {
        const char* port;
        const Samples* samples;
    };
    using Parts = std::vector<Part>;

    template <class Node>
    static void declare_parameters(Ports<Node>& node) {
        const auto number = [&](const char* name, float SmoothRadiance::*field, Limits limits) {
            node.param(name, static_cast<float Node::*>(field), std::move(limits));
        };
        number("widest", &SmoothRadiance::widest, {.min = 1, .max = 16, .about = "widest kernel, in radii R of the gaps expected between samples"});
        number("caution", &SmoothRadiance::caution, {.min = 0, .max = 10, .about = "standard errors by which a wider kernel must predict better to be used"});
        number("sharp-caution", &SmoothRadiance::sharp_caution, {.min = 0, .max = 1e6, .about = "the same for sharpening, which the filter's blur is made up for with; 1e6: never"});
        number("radius-scale", &SmoothRadiance::radius_scale, {.min = 0.1, .max = 10, .about = "of R"});
        number("slope-tolerance", &SmoothRadiance::slope_tolerance, {.unit = "px", .min = 0, .max = 100, .about = "difference in slope over the lens within a surface"});
        number("velocity-tolerance", &SmoothRadiance::velocity_tolerance,
               {.unit = "px per shutter", .min = 0, .max = 1000, .about = "difference in velocity within a surface"});
        number("depth-tolerance", &SmoothRadiance::depth_tolerance, {.min = 0, .max = 10, .about = "relative difference in depth within a surface"});
        number("normal-tolerance", &SmoothRadiance::normal_tolerance,
               {.min = 0.05, .max = 1e6, .about = "difference of unit normals from which on samples are not smoothed together; less of it takes weight"});
        number("albedo-tolerance", &SmoothRadiance::albedo_tolerance,
               {.min = 0, .max = 1e6, .about = "difference in albedo within a surface"});
    }
    static Cost cost_of(const Shapes& in, std::initializer_list<const char*> ports) {
        const Shape s = in[*ports.begin()];
        const double n = double(s.records), band = std::min(n, 131072 + n / 8), parts = double(ports.size());
        Cost cost{{}, (8 + 12 * parts) * n + (68 + 80 * parts) * band, (300 + 400 * parts) * n};
        for (const char* port : ports) cost.outputs.push_back({port, {s.width, s.height, 0, s.records, s.bytes}});
        return cost;
    }
    // Samples of the parts differ in rgb alone.
    void smooth(Parts parts, Outputs& out, Context& ctx) const {
        const Samples& samples = *parts[0].samples;
        samples.require("smooth-radiance", {"xy", "z", "rgb"});
        light_field::Smoothing by;
        by.slope = slope_tolerance;
        by.velocity = velocity_tolerance;
        by.depth = depth_tolerance;
        by.normal = normal_tolerance;
        by.albedo = albedo_tolerance;
        by.caution = caution;
        by.sharp_caution = sharp_caution;
        std::vector<std::span<const float>> radiances;
        std::erase_if(parts, [&](const Part& part) {
            if (!out.wanted(part.port)) return true;
            const float level = mean_level(part.samples->rgb(), ctx);
            if (!(level > 0)) {
                out.set(part.port, *part.samples);
                return true;
            }
            by.epsilon[radiances.size()] = 0.3f * level;
            radiances.push_back(part.samples->rgb());
            return false;
        });
        if (parts.empty()) return;
        const float radius = radius_scale * light_field::dispersion_radius(samples.mean_spp());
        std::vector<Array<float>> smoothed = light_field::smooth_radiance(samples, radiances, radius, widest, by, ctx);
        for (size_t c = 0; c < parts.size(); ++c) {
            Samples smooth = *parts[c].samples;
            smooth.add(Channel{"rgb", 3, standard_role("rgb"), std::move(smoothed[c]), {}});
            out.set(parts[c].port, std::move(smooth));
        }
    }

  private:
    static float mean_level(std::span<const float> rgb, Context& ctx) {
        const double total = ctx.reduce(
            rgb.size(), 65536, 0.0,
            [&](size_t begin, size_t end) {
                double sum = 0;
                for (size_t i = begin; i < end; ++i) sum += std::abs(double(rgb[i]));
                return sum;
            },
            [](double a, double b) { return a + b; });
        return total > 0 ? float(total / double(rgb.size())) : 0.0f;
    }
};

// Both parts that separate-light makes of samples, in one go.
struct SmoothParts : SmoothRadiance {
    static void declare(Ports<SmoothParts>& node) {
        node.about("smooths two parts of the same samples' light as smooth-radiance does, at little more than the cost of one")
            .in<Samples>("rest", "xy, z and rgb; uv with a lens, t, motion, normal and albedo where it has them")
            .in<Samples>("direct", "the same but for rgb")
            .out<Samples>("rest", "the same with another rgb")
            .out<Samples>("direct", "the same with another rgb");
        declare_parameters(node);
    }
    Cost cost(const Shapes& in) const { return cost_of(in, {"rest", "direct"}); }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples &rest = in.get<Samples>("rest"), &direct = in.get<Samples>("direct");
        if (direct.size() != rest.size())
            ctx.fail(fmt::format("'direct' has {} samples and 'rest' {}; expected parts of the same ones", direct.size(), rest.size()));
        smooth({{"rest", &rest}, {"direct", &direct}}, out, ctx);
    }
};

WEFT_NODE(SmoothRadiance, "smooth-radiance", 7)
WEFT_NODE(SmoothParts, "smooth-parts", 1)

}  // namespace
}  // namespace weft
