#include "adaptive/factored_sheared_kernel.h"

#include <fmt/format.h>

#include "graph/error.h"

namespace weft::adaptive {

namespace {

// Of a grid's row that is not narrow on the film, by v: jittered samples differ less within a cell
// then.
constexpr size_t most_parts = 2;

size_t cell_of(float place, size_t cells) {
    return size_t(std::min(std::max(0.0f, place), float(cells - 1)));  // NaN: the first
}

}  // namespace

template <class RowOf>
LensCells::LensCells(const Samples& samples, size_t rows, const RowOf& row_of)
    : rows_(rows), width_(size_t(samples.width)) {
    const SamplePaths paths(samples);
    const auto rgb = samples.rgb(), weight = samples.values("weight");
    const size_t cells = samples.pixels() * rows;
    // work(place in first_, sample, what it stands for) for all samples that have a colour.
    const auto each = [&](const auto& work) {
        for (size_t pixel = 0; pixel < samples.pixels(); ++pixel) {
            const size_t y = pixel / width_, x = pixel % width_;
            const auto range = samples.of_pixel(pixel);
            for (size_t i = range.begin; i < range.end; ++i) {
                if (!std::isfinite(rgb[3 * i] + rgb[3 * i + 1] + rgb[3 * i + 2])) continue;
                const float stands =
                    weight.empty() ? 1 / float(range.end - range.begin) : weight[i];
                work((y * rows_ + row_of(i - range.begin, i)) * width_ + x, i, stands);
            }
        }
    };
    first_.assign(cells + 1, 0);
    each([&](size_t at, size_t, float) { ++first_[at + 1]; });
    for (size_t k = 0; k < cells; ++k) first_[k + 1] += first_[k];
    sorted_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    each([&](size_t at, size_t i, float stands) {
        const auto on = paths.uv(i);
        sorted_[next[at]++] = {
            paths.x(i), paths.y(i), on[0] / paths.lens().aspect,
            on[1],      stands,     {rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]}};
    });
}

LensCells LensCells::of_grid(const Samples& samples, float widest, std::string_view who) {
    const auto root = size_t(std::lround(std::sqrt(double(samples.spp))));
    if (samples.spp < 4 || root * root != size_t(samples.spp))
        throw Error(fmt::format(
            "'{}' needs samples in a grid over the lens, l x l in each pixel; this buffer has {} a "
            "pixel; render 4, 9, 16 ... in grid order, or set order to any",
            who, samples.spp > 0 ? fmt::format("{}", samples.spp) : "varying numbers"));
    const auto uv = samples.uv();
    const size_t spp = root * root;
    const size_t parts = 2 * widest / float(root) < narrow_on_film ? 1 : most_parts;
    for (const bool across : {true, false}) {
        std::vector<size_t> row(spp);
        for (size_t k = 0; k < spp; ++k) row[k] = across ? k / root : k % root;
        std::vector<Interval> range(root, {INFINITY, -INFINITY});
        for (size_t pixel = 0; pixel < samples.pixels(); ++pixel)
            for (size_t k = 0; k < spp; ++k) {
                const float v = uv[2 * (pixel * spp + k) + 1];
                Interval& r = range[row[k]];
                r.a = std::min(r.a, v), r.b = std::max(r.b, v);
            }
        bool apart = true;
        for (size_t j = 0; j + 1 < root; ++j) apart &= range[j].b <= range[j + 1].a;
        if (!apart) continue;
        return {samples, root * parts, [&](size_t k, size_t i) {
                    if (parts == 1) return row[k];
                    const Interval r = range[row[k]];
                    const float place = (uv[2 * i + 1] - r.a) / r.length() * float(parts);
                    return row[k] * parts + cell_of(place, parts);
                }};
    }
    throw Error(fmt::format(
        "'{}' needs samples in a grid over the lens: sample j {} + i of each pixel in row j of v "
        "from the least, rows apart from each other; this buffer's are in another order; set "
        "order to any",
        who, root));
}

LensCells LensCells::of_any(const Samples& samples, int rows) {
    const auto uv = samples.uv();
    return {samples, size_t(rows), [&](size_t, size_t i) {
                return cell_of((uv[2 * i + 1] + 1) / 2 * float(rows), size_t(rows));
            }};
}

FactoredSheared::FactoredSheared(const Samples& samples, const Image& slopes,
                                 const ShearedSettings& settings, const LensCells& cells)
    : samples_(samples),
      filter_(samples, &slopes, settings),
      slopes_(slopes, "factored-sheared"),
      cells_(cells) {}

void FactoredSheared::see(const ShearedFilter::Filter& f, int y, size_t row, SeenCell& out) const {
    const LensPieces& pieces = filter_.pieces(f);
    out.pieces = &pieces;
    std::fill_n(out.of.begin(), pieces.columns, SeenCell::Sums{});
    out.w = out.squares = out.y = out.v = 0;
    std::fill_n(out.low, 3, INFINITY), std::fill_n(out.high, 3, -INFINITY);
    const auto [left, right] = filter_.columns_of(f);
    const InsideBox inside(f.coc_x, f.half_x);
    const GaussianMass mass(0, f.sigma_lens);
    for (const LensCells::Sample& s : cells_.in(y, row, left, right)) {
        const float dx = s.x - f.x;
        const Interval x = inside(dx, s.u, -1, 1);
        if (x.empty()) continue;
        const auto at = double(dx - f.coc_x * s.u), r = double(s.rgb[0]), g = double(s.rgb[1]),
                   b = double(s.rgb[2]);
        const SeenCell::Sums each{{1, at, at * at, r, g, b, r * at, g * at, b * at}};
        double whole = 0;
        pieces.each_column(x, mass.around(s.u), [&](size_t k, float across) {
            const double w = double(s.stands) * double(across);
            out.of[k].add(w, each);
            whole += w;
        });
        if (!(whole > 0)) continue;
        out.w += whole, out.squares += whole * whole;
        out.y += whole * double(s.y), out.v += whole * double(s.v);
        for (int c = 0; c < 3; ++c)
            out.low[c] = std::min(out.low[c], s.rgb[c]),
            out.high[c] = std::max(out.high[c], s.rgb[c]);
    }
}

void FactoredSheared::add(const ShearedFilter::Filter& f, const SeenCell& cell,
                          ShearedFilter::Sums& to) const {
    const auto y = float(cell.y / cell.w), v = float(cell.v / cell.w);
    const Interval in = inside_box(y - f.y, f.coc_y, f.half_y, v, -1, 1);
    if (in.empty()) return;
    SeenCell::Sums sums;
    const GaussianMass mass(v, f.sigma_lens);
    const double whole = double(mass.in(in));
    for (size_t k = 0; k < cell.pieces->columns; ++k) {
        const Interval along = in.in(cell.pieces->v[k]);
        if (cell.of[k].w() > 0 && !along.empty())
            sums.add(along.a == in.a && along.b == in.b ? whole : double(mass.in(along)),
                     cell.of[k]);
    }
    if (!(sums.w() > 0)) return;
    const auto dy = double(y - f.y - f.coc_y * v);
    to.weight += sums.w();
    // Its samples differ among themselves as over the lens's whole width.
    to.squares += sums.w() * sums.w() * cell.squares / (cell.w * cell.w);
    to.px += sums.x(), to.py += sums.w() * dy;
    to.pxx += sums.xx(), to.pxy += sums.x() * dy, to.pyy += sums.w() * dy * dy;
    for (size_t c = 0; c < 3; ++c) {
        to.rgb[c] += sums.rgb(c), to.rgb_x[c] += sums.rgb_x(c), to.rgb_y[c] += sums.rgb(c) * dy;
        to.low[c] = std::min(to.low[c], cell.low[c]);
        to.high[c] = std::max(to.high[c], cell.high[c]);
    }
}

void FactoredSheared::column(int x, std::vector<SeenCell>& cells,
                             std::span<ShearedFilter::Pixel> out) const {
    const auto height = size_t(samples_.height);
    std::vector<ShearedFilter::Filter> filters(height);
    std::vector<bool> asked(height);
    std::vector<bool> kept(height);
    for (int y = 0; y < samples_.height; ++y) {
        const PixelSlopes s = slopes_(x, y);
        filters[size_t(y)] = filter_.filter_of(s, x, y);
        out[size_t(y)] = filter_.own_mean(x, y);
        kept[size_t(y)] = filter_.keeps_own(s, out[size_t(y)]);
        if (kept[size_t(y)]) continue;
        const auto [top, bottom] = filter_.rows_of(filters[size_t(y)]);
        for (int j = top; j <= bottom; ++j) asked[size_t(j)] = true;
    }
    cells.resize(height * cells_.rows());
    for (size_t y = 0; y < height; ++y)
        for (size_t row = 0; asked[y] && row < cells_.rows(); ++row)
            see(filters[y], int(y), row, cells[y * cells_.rows() + row]);
    for (size_t y = 0; y < height; ++y) {
        if (kept[y]) continue;
        ShearedFilter::Sums sums;
        const auto [top, bottom] = filter_.rows_of(filters[y]);
        for (size_t at = size_t(top) * cells_.rows(); at < size_t(bottom + 1) * cells_.rows(); ++at)
            if (cells[at].w > 0) add(filters[y], cells[at], sums);
        const ShearedFilter::Pixel found = sums.fitted();
        out[y] = found.effective > 0 ? filter_.better(found, out[y]) : filter_.filtered(x, int(y));
    }
}

}  // namespace weft::adaptive
