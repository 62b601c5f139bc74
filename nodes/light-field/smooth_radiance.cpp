// smooth-radiance: less noise in a sample buffer's radiance where it is noisy, and more contrast in
// fine detail where it is not, to make up for the filter to come (smooth_radiance_kernel.h says
// how). Only rgb changes.
#include "light-field/smooth_radiance_kernel.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "light-field/build_hierarchy_kernel.h"
#include "runtime/node.h"

namespace weft {
namespace light_field {

namespace {

constexpr size_t spare = 16;  // vectors may be read past the end

// Cuts memory for arrays of n values into them, with some to spare.
void lay_out(LargeArray<float>& memory, size_t n, std::initializer_list<std::span<float>*> arrays) {
    memory.resize((n + spare) * arrays.size());
    std::span<float> rest(memory);
    for (std::span<float>* array : arrays) {
        *array = rest.first(n + spare);
        rest = rest.subspan(n + spare);
        std::fill(array->begin() + std::ptrdiff_t(n), array->end(), 1.0f);
    }
}

// Runs of samples of one row, no wider than what they look at.
std::vector<SampleField::Block> blocks_of(const SampleField& s, float widest) {
    std::vector<SampleField::Block> blocks;
    blocks.reserve(s.size / SampleField::block_size * 5 / 4);
    for (int row = 0; row < s.rows; ++row) {
        const std::uint32_t* start = &s.start[size_t(row) * size_t(s.columns)];
        const std::uint32_t end = start[s.columns];
        for (std::uint32_t i = start[0]; i < end;) {
            const std::uint32_t begin = i,
                                most = std::min(end, i + std::uint32_t(SampleField::block_size));
            while (++i < most && std::abs(s.x[i] - s.x[begin]) < widest) {
            }
            blocks.push_back({begin, i});
        }
    }
    return blocks;
}

}  // namespace

void Stretch::keep(size_t from, size_t end) {
    for (auto array = memory.begin(); array != memory.end(); array += std::ptrdiff_t(room + spare))
        std::copy(array + std::ptrdiff_t(from - first), array + std::ptrdiff_t(end - first), array);
    first = from;
}

Filtered::Filtered(size_t n) {
    room = n;
    lay_out(memory, n, {&r, &g, &b, &weight});
}

Changes::Changes(size_t n) {
    static_assert(Smoothing::widths == 4);
    room = n;
    auto& [a, b, c, sharp] = of;
    lay_out(memory, n,
            {&a.gain, &a.way, &a.r, &a.g, &a.b, &b.gain, &b.way, &b.r, &b.g, &b.b, &c.gain, &c.way,
             &c.r, &c.g, &c.b, &sharp.gain, &sharp.way});
}

SampleField sample_field(const Samples& samples, float radius, Context& ctx) {
    const size_t n = samples.size();
    const Lens lens = samples.has_lens() ? *samples.lens : Lens{};
    SampleField s;
    s.size = n;
    // Positions may lie outside the picture by what lens and motion move them; beyond a quarter
    // they share cells.
    const float border = 0.25f * float(std::max(samples.width, samples.height));
    // There are some 4.8 samples in a square of the radius.
    s.cell_width = 0.3f * radius;
    s.cell_height = 1.8f * radius;
    s.x0 = s.y0 = -border;
    s.columns = int((float(samples.width) + 2 * border) / s.cell_width) + 1;
    s.rows = int((float(samples.height) + 2 * border) / s.cell_height) + 1;
    s.moving = samples.has_motion();
    const Places places = places_of(samples);
    // Of count samples, which `from` has; work(k, x, y, W) for each. One behind the camera at half
    // time is where it was seen, at depth 1.
    const auto each_place = [&](const Places& from, size_t count, auto&& work) {
        std::array<std::array<float, Fetched::most>, 6> path{};
        WEFT_PICK(recentre)
        (from, lens, count,
         {path[0].data(), path[1].data(), path[2].data(), path[3].data(), path[4].data(),
          path[5].data()});
        for (size_t k = 0; k < count; ++k) {
            Recentred p{path[0][k], path[1][k], path[2][k], path[3][k], path[4][k], path[5][k]};
            if (!(p.W > 0)) p = {from.xy[2 * k], from.xy[2 * k + 1], 1, 0, 0, 0};
            work(k, p, p.X / p.W, p.Y / p.W);
        }
    };
    LargeArray<std::uint32_t> cell(n);
    ctx.parallel(n, 4096, [&](size_t begin, size_t end) {
        for (size_t first = begin; first < end; first += Fetched::most)
            each_place(places.from(first), std::min(Fetched::most, end - first),
                       [&](size_t k, const Recentred&, float x, float y) {
                           cell[first + k] =
                               std::uint32_t(s.row_of(y) * s.columns + s.column_of(x));
                       });
    });
    // Counted one cell too far, so that each start is back at its own once its samples are put.
    s.start.assign(size_t(s.columns) * size_t(s.rows) + 2, 0);
    for (std::uint32_t c : cell) ++s.start[c + 2];
    for (size_t c = 2; c < s.start.size(); ++c) s.start[c] += s.start[c - 1];
    s.order.resize(n);
    for (size_t i = 0; i < n; ++i) s.order[s.start[cell[i] + 1]++] = std::uint32_t(i);
    lay_out(s.memory, n,
            {&s.x, &s.y, &s.slope, &s.velocity_x, &s.velocity_y, &s.log_depth, &s.r, &s.g, &s.b});
    const auto normal = samples.values("normal"), albedo = samples.values("albedo");
    if (!normal.empty()) lay_out(s.normals, n, {&s.normal[0], &s.normal[1], &s.normal[2]});
    if (!albedo.empty()) lay_out(s.albedos, n, {&s.albedo[0], &s.albedo[1], &s.albedo[2]});
    const auto rgb = samples.rgb();
    ctx.parallel(n, 4096, [&](size_t begin, size_t end) {
        Fetched fetched;
        for (size_t first = begin; first < end; first += Fetched::most) {
            const size_t count = std::min(Fetched::most, end - first);
            fetched.fetch(places, std::span(s.order).subspan(first, count));
            each_place(fetched.places(places), count,
                       [&](size_t k, const Recentred& p, float x, float y) {
                           const size_t to = first + k;
                           s.x[to] = x;
                           s.y[to] = y;
                           s.slope[to] = lens.c0 / p.W + lens.c1;
                           s.velocity_x[to] = (p.VX - x * p.VW) / p.W;
                           s.velocity_y[to] = (p.VY - y * p.VW) / p.W;
                           s.log_depth[to] = std::log(p.W);
                       });
        }
        for (size_t to = begin; to < end; ++to) {
            const size_t i = s.order[to];
            s.r[to] = rgb[3 * i];
            s.g[to] = rgb[3 * i + 1];
            s.b[to] = rgb[3 * i + 2];
            if (!normal.empty()) {
                const float* of = &normal[3 * i];
                const float length = std::sqrt(of[0] * of[0] + of[1] * of[1] + of[2] * of[2]);
                const bool none = !(length > 0 && std::isfinite(length));  // background, say
                for (size_t c = 0; c < 3; ++c) s.normal[c][to] = none ? 0 : of[c] / length;
            }
            if (!albedo.empty())
                for (size_t c = 0; c < 3; ++c)
                    s.albedo[c][to] = std::isfinite(albedo[3 * i + c]) ? albedo[3 * i + c] : 0;
        }
    });
    s.blocks = blocks_of(s, 4 * radius);
    return s;
}

namespace {

// The field goes through the kernels in bands of whole rows. What is around a sample lies in
// `reach` rows above and below its own: as many rows ahead of its treatment, and twice as many,
// have been through the kernels before, and as many behind it are kept.
struct Bands {
    const SampleField& s;
    int reach;

    size_t start(int row) const {
        return s.start[size_t(std::clamp(row, 0, s.rows)) * size_t(s.columns)];
    }
    // Where the band that begins with a row ends: it has samples enough for many threads, and for
    // what is kept to be little beside it.
    int end(int row) const {
        constexpr size_t enough = 65536;
        int last = row + 4 * reach;
        while (last < s.rows && start(last) - start(row) < enough) ++last;
        return std::min(last, s.rows);
    }
    // The most samples of a band and `behind` and `ahead` rows about it.
    size_t most(int behind, int ahead) const {
        size_t most = 0;
        for (int row = 0; row < s.rows; row = end(row))
            most = std::max(most, start(end(row) + ahead) - start(row - behind));
        return most;
    }
    size_t block(int row) const {
        const auto begins = [](const SampleField::Block& block, size_t sample) {
            return block.begin < sample;
        };
        return size_t(std::lower_bound(s.blocks.begin(), s.blocks.end(), start(row), begins) -
                      s.blocks.begin());
    }
};

}  // namespace

Array<float> smooth_radiance(const Samples& samples, float radius, float widest, Smoothing by,
                             Context& ctx) {
    for (size_t k = 0; k < Smoothing::widths; ++k)
        by.width[k] = radius * std::pow(widest, float(k) / float(Smoothing::widths - 1));
    by.window = by.width.back();
    const SampleField s = sample_field(samples, radius, ctx);
    std::atomic<size_t> done = 0;
    const Bands bands{s, int(by.window / s.cell_height) + 2};
    const auto each = [&](int first_row, int last_row, auto&& work) {
        ctx.parallel(bands.block(last_row) - bands.block(first_row), 64,
                     [&](size_t first, size_t last) {
                         work(first + bands.block(first_row), last + bands.block(first_row));
                         ctx.progress(double(done += last - first), 3 * double(s.blocks.size()),
                                      "blocks of samples");
                     });
    };
    Filtered filtered(bands.most(0, 2 * bands.reach));
    Changes changes(bands.most(bands.reach, bands.reach));
    const auto rgb = std::make_shared<LargeArray<float>>(3 * s.size);
    int filtered_to = 0, judged_to = 0;  // rows
    for (int row = 0; row < s.rows;) {
        const int end = bands.end(row), judged = std::min(end + bands.reach, s.rows),
                  ahead = std::min(judged + bands.reach, s.rows);
        filtered.keep(bands.start(row), bands.start(filtered_to));
        changes.keep(bands.start(row - bands.reach), bands.start(judged_to));
        each(filtered_to, ahead, [&](size_t first, size_t last) {
            WEFT_PICK(filter_samples)(s, by, first, last, filtered);
        });
        each(judged_to, judged, [&](size_t first, size_t last) {
            WEFT_PICK(find_errors)(s, filtered, by, first, last, changes);
        });
        each(row, end, [&](size_t first, size_t last) {
            WEFT_PICK(treat)(s, filtered, changes, by, first, last, *rgb);
        });
        filtered_to = ahead;
        judged_to = judged;
        row = end;
    }
    return {*rgb, rgb};
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
            .out<Samples>("samples", "the same with another rgb")
            .param("widest", &SmoothRadiance::widest, {.min = 1, .max = 16, .about = "widest kernel, in radii R of the gaps expected between samples"})
            .param("caution", &SmoothRadiance::caution, {.min = 0, .max = 10, .about = "standard errors by which a wider kernel must predict better to be used"})
            .param("sharp-caution", &SmoothRadiance::sharp_caution, {.min = 0, .max = 1e6, .about = "the same for sharpening, which the filter's blur is made up for with; 1e6: never"})
            .param("radius-scale", &SmoothRadiance::radius_scale, {.min = 0.1, .max = 10, .about = "of R"})
            .param("slope-tolerance", &SmoothRadiance::slope_tolerance, {.unit = "px", .min = 0, .max = 100, .about = "difference in slope over the lens within a surface"})
            .param("velocity-tolerance", &SmoothRadiance::velocity_tolerance,
                   {.unit = "px per shutter", .min = 0, .max = 1000, .about = "difference in velocity within a surface"})
            .param("depth-tolerance", &SmoothRadiance::depth_tolerance, {.min = 0, .max = 10, .about = "relative difference in depth within a surface"})
            .param("normal-tolerance", &SmoothRadiance::normal_tolerance,
                   {.min = 0.05, .max = 1e6, .about = "difference of unit normals from which on samples are not smoothed together; less of it takes weight"})
            .param("albedo-tolerance", &SmoothRadiance::albedo_tolerance,
                   {.min = 0, .max = 1e6, .about = "difference in albedo within a surface"});
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["samples"];
        const double n = double(s.records), band = std::min(n, 131072 + n / 8);
        return {{{"samples", {s.width, s.height, 0, s.records, s.bytes}}}, 64 * n + 84 * band, 800 * n};
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        const Samples& samples = in.get<Samples>("samples");
        samples.require("smooth-radiance", {"xy", "z", "rgb"});
        light_field::Smoothing by;
        by.slope = slope_tolerance;
        by.velocity = velocity_tolerance;
        by.depth = depth_tolerance;
        by.normal = normal_tolerance;
        by.albedo = albedo_tolerance;
        by.caution = caution;
        by.sharp_caution = sharp_caution;
        const auto rgb = samples.rgb();
        const double total = ctx.reduce(
            rgb.size(), 65536, 0.0,
            [&](size_t begin, size_t end) {
                double sum = 0;
                for (size_t i = begin; i < end; ++i) sum += std::abs(double(rgb[i]));
                return sum;
            },
            [](double a, double b) { return a + b; });
        if (!(total > 0)) {
            out.set("samples", samples);
            return;
        }
        by.epsilon = 0.3f * float(total / double(rgb.size()));
        Samples smooth = samples;
        const float radius = radius_scale * light_field::dispersion_radius(samples.mean_spp());
        Array<float> smoothed = light_field::smooth_radiance(samples, radius, widest, by, ctx);
        smooth.add(Channel{"rgb", 3, standard_role("rgb"), std::move(smoothed), {}});
        out.set("samples", std::move(smooth));
    }
};

WEFT_NODE(SmoothRadiance, "smooth-radiance", 6)

}  // namespace
}  // namespace weft
