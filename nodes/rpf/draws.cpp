#include "rpf/draws.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "rpf/kernels.h"
#include "samples/random.h"

namespace weft::rpf {
namespace {

constexpr size_t run_length = size_t(1) << 16;

int side_of(const DrawSettings& by) {
    return 2 * (by.box / 2) + 1;
}

// A point of the unit square to one of a Gaussian (Box and Muller 1958).
struct Normal {
    float x, y;
};
Normal normal(float a, float b, float sigma) {
    const float radius = sigma * std::sqrt(-2 * std::log(1 - a)),
                angle = 2 * std::numbers::pi_v<float> * b;
    return {radius * std::cos(angle), radius * std::sin(angle)};
}

// The pixel of a place within the box around a pixel: the nearest, or the next towards the middle.
bool round_into(Normal at, int box, bool towards_middle, Offset& place) {
    const float x = towards_middle ? std::trunc(at.x) : std::round(at.x),
                y = towards_middle ? std::trunc(at.y) : std::round(at.y);
    const auto half = float(box / 2);
    if (std::abs(x) > half || std::abs(y) > half) return false;
    place.dx = std::int16_t(x);
    place.dy = std::int16_t(y);
    return true;
}

// Points of the plane's most even lattice (Roberts 2018: steps by powers of the plastic number)
// carried to the Gaussian; what comes to lie on one pixel takes one sample of it after another.
std::vector<Offset> stratified_places(const DrawSettings& by) {
    std::vector<Offset> places;
    std::vector<std::uint16_t> times(size_t(by.box + 1) * size_t(by.box + 1), 0);
    const size_t tries = 16 * by.draws + 1024;
    for (size_t i = 0; i < tries && places.size() < by.draws; ++i) {
        const double a = 0.5 + 0.7548776662466927 * double(i),
                     b = 0.5 + 0.5698402909980532 * double(i);
        Offset place{};
        if (!round_into(normal(float(a - std::floor(a)), float(b - std::floor(b)), by.sigma),
                        by.box, false, place))
            continue;
        std::uint16_t& n = times[size_t(place.dy + by.box / 2) * size_t(by.box + 1) +
                                 size_t(place.dx + by.box / 2)];
        if ((place.dx == 0 && place.dy == 0) || n >= by.spp) continue;
        place.turn = n++;
        places.push_back(place);
    }
    std::sort(places.begin(), places.end(), [](const Offset& a, const Offset& b) {
        return a.dy != b.dy ? a.dy < b.dy : a.dx != b.dx ? a.dx < b.dx : a.turn < b.turn;
    });
    return places;
}

// The middle is the block's own, which is not drawn again.
Places random_places(const DrawSettings& by) {
    Places places;
    const bool distinct = by.rule == DrawRule::distinct;
    const int half = by.box / 2, side = side_of(by);
    for (std::uint64_t i = 0; places.cells.size() < run_length && i < 256 * run_length; ++i) {
        const std::uint64_t bits = mix(by.seed ^ mix(i));
        const Normal at = normal(unit_float(std::uint32_t(bits)),
                                 unit_float(std::uint32_t(bits >> 32)), by.sigma);
        Offset place{};
        const bool found =
            round_into(at, by.box, distinct, place) && (place.dx != 0 || place.dy != 0);
        if (found || distinct)
            places.cells.push_back(
                std::uint16_t(found ? (place.dy + half) * side + place.dx + half : side * side));
    }
    const size_t all = size_t(side) * size_t(side) + 1;
    places.in_run.assign(places.cells.size() / Places::run * all, 0);
    for (size_t i = 0; i < places.cells.size() / Places::run * Places::run; ++i)
        ++places.in_run[i / Places::run * all + places.cells[i]];
    return places;
}

// Adds how often each cell is among draws [begin, begin + some): whole runs at once.
void add_counts(const Places& places, size_t begin, size_t some,
                std::vector<std::uint16_t>& counts) {
    const size_t end = begin + some, all = counts.size();
    const auto one_by_one = [&](size_t to) {
        for (; begin < to; ++begin) ++counts[places.cells[begin]];
    };
    one_by_one(std::min(end, (begin + Places::run - 1) / Places::run * Places::run));
    for (; begin + Places::run <= end; begin += Places::run) {
        const std::uint16_t* of = &places.in_run[begin / Places::run * all];
        for (size_t cell = 0; cell < all; ++cell)
            counts[cell] = std::uint16_t(counts[cell] + of[cell]);
    }
    one_by_one(end);
}

bool within(PixelBlock block, int x, int y) {
    return x >= block.x0 && x < block.x1 && y >= block.y0 && y < block.y1;
}

// What draws around one block.
class Drawer {
  public:
    Drawer(const Samples& samples, const DrawSettings& by, PixelBlock block,
           std::span<const NearCodes> near)
        : samples_(samples),
          by_(by),
          block_(block),
          near_(near),
          cx_((block.x0 + block.x1 - 1) / 2),
          cy_((block.y0 + block.y1 - 1) / 2),
          chance_(mix(by.seed ^ mix(std::uint64_t(cy_) * std::uint64_t(samples.width) +
                                    std::uint64_t(cx_)))) {}

    void stratified(std::span<const Offset> places, DrawnSamples& drawn) const {
        const int sx = chance_ & 1 ? -1 : 1, sy = chance_ & 2 ? -1 : 1;
        const bool turned = chance_ & 4;
        for (const Offset& p : places) {
            const int x = cx_ + sx * (turned ? p.dy : p.dx), y = cy_ + sy * (turned ? p.dx : p.dy);
            if (!inside(x, y)) continue;
            const auto [begin, end] = pixel(x, y);
            const size_t n = end - begin;
            if (p.turn >= n) continue;
            const size_t from =
                size_t((chance_ >> 8) + std::uint64_t(x) * 3 + std::uint64_t(y) * 5);
            drawn.sample.push_back(std::uint32_t(begin + (from + p.turn) % n));
        }
        drawn.extend(drawn.sample.size(), PixelNear::some);
    }

    // Each draw takes any sample of its pixel.
    void gaussian(const Places& places, DrawScratch& scratch, DrawnSamples& drawn) const {
        find_inside(scratch);
        // Near the picture's corners three of four draws fall outside: as many more are made.
        count(places, 8 * by_.draws, scratch);
        take(scratch, drawn, [&](size_t pixel, std::span<const std::uint16_t> counts, auto* to) {
            return WEFT_PICK(take_any)(samples_, pixel, counts, std::uint32_t(chance_ >> 32), to);
        });
    }

    // How often each pixel was drawn is how many of its samples are taken, as far as it has so
    // many.
    void distinct(const Places& places, DrawScratch& scratch, DrawnSamples& drawn) const {
        scratch.counts.assign(size_t(side_of(by_)) * size_t(side_of(by_)) + 1, 0);
        const size_t all = places.cells.size(), at = size_t(chance_ % all);
        for (size_t left = by_.draws, begin = at; left > 0; begin = 0) {
            const size_t some = std::min(left, all - begin);
            add_counts(places, begin, some, scratch.counts);
            left -= some;
        }
        take(scratch, drawn, [&](size_t pixel, std::span<const std::uint16_t> counts, auto* to) {
            return WEFT_PICK(take_first)(samples_, pixel, counts, to);
        });
    }

  private:
    // Of each pixel as many samples as it was drawn, those of the block left out: to = some(first
    // pixel, counts, to) takes those of pixels side by side.
    template <class Some>
    void take(DrawScratch& scratch, DrawnSamples& drawn, Some&& some_of) const {
        each_row([&](size_t cell, int x, int y, int some) {
            for (int i = 0; i < some && y >= block_.y0 && y < block_.y1; ++i)
                if (within(block_, x + i, y)) scratch.counts[cell + size_t(i)] = 0;
        });
        drawn.sample.resize(by_.draws + 16);
        std::uint32_t *const first = drawn.sample.data(), *to = first;
        each_stretch(scratch, [&](size_t cell, size_t pixel, size_t some, PixelNear near) {
            if (near == PixelNear::none) return;
            to = some_of(pixel, std::span(&scratch.counts[cell], some), to);
            drawn.extend(size_t(to - first), near);
        });
        drawn.sample.resize(size_t(to - first));
    }
    // Draws until there are enough that are inside.
    void count(const Places& places, size_t tries, DrawScratch& scratch) const {
        scratch.counts.assign(scratch.inside.size(), 0);
        const size_t all = places.cells.size();
        if (all == 0) return;
        size_t at = size_t(chance_ % all), found = 0;
        while (tries > 0 && found < by_.draws) {
            // No more than are wanted, so that none is too many.
            const size_t some = std::min({tries, by_.draws - found, all - at});
            add_counts(places, at, some, scratch.counts);
            std::uint32_t inside = 0;
            for (size_t cell = 0; cell < scratch.inside.size(); ++cell)
                inside += std::uint32_t(scratch.counts[cell]) * scratch.inside[cell];
            found = inside;
            tries -= some;
            at = (at + some) % all;
        }
    }
    void find_inside(DrawScratch& scratch) const {
        const auto all = size_t(side_of(by_)) * size_t(side_of(by_));
        scratch.inside.assign(all + 1, 0);
        each_cell(
            [&](size_t cell, Samples::Range of) { scratch.inside[cell] = of.begin < of.end; });
    }
    // Of each row within box and picture its first cell, where that lies, and how many there are.
    template <class Do>
    void each_row(Do&& what) const {
        const int half = by_.box / 2, side = side_of(by_), x0 = std::max(0, cx_ - half),
                  x1 = std::min(samples_.width - 1, cx_ + half);
        for (int y = std::max(0, cy_ - half); y <= std::min(samples_.height - 1, cy_ + half); ++y)
            what(size_t(y - cy_ + half) * size_t(side) + size_t(x0 - cx_ + half), x0, y,
                 x1 + 1 - x0);
    }
    // what(first cell, first pixel, how many, which of their samples are near) for pixels of a row
    // that are alike in that, row by row.
    template <class Do>
    void each_stretch(DrawScratch& scratch, Do&& what) const {
        each_row([&](size_t cell, int x, int y, int some) {
            const size_t n = size_t(some), pixel = size_t(y) * size_t(samples_.width) + size_t(x);
            std::vector<PixelNear>& near = scratch.near;
            near.assign((n + 63) / 64 * 64, PixelNear::some);
            if (!near_.empty()) WEFT_PICK(judge_pixels)(near_, pixel, n, near.data());
            for (size_t begin = 0, end = 1; begin < n; begin = end++) {
                while (end < n && near[end] == near[begin]) ++end;
                what(cell + begin, pixel + begin, end - begin, near[begin]);
            }
        });
    }
    // Those outside the block, row by row.
    template <class Do>
    void each_cell(Do&& what) const {
        each_row([&](size_t cell, int x, int y, int some) {
            for (int i = 0; i < some; ++i)
                if (!within(block_, x + i, y)) what(cell + size_t(i), pixel(x + i, y));
        });
    }
    bool inside(int x, int y) const {
        return x >= 0 && x < samples_.width && y >= 0 && y < samples_.height &&
               !within(block_, x, y);
    }
    Samples::Range pixel(int x, int y) const {
        return samples_.of_pixel(size_t(y) * size_t(samples_.width) + size_t(x));
    }

    const Samples& samples_;
    const DrawSettings& by_;
    PixelBlock block_;
    std::span<const NearCodes> near_;
    int cx_, cy_;
    std::uint64_t chance_;
};

}  // namespace

Places make_places(const DrawSettings& by) {
    return by.rule == DrawRule::stratified ? Places{stratified_places(by), {}, {}}
                                           : random_places(by);
}

void DrawnSamples::extend(size_t end, PixelNear near) {
    if (end == (stretches.empty() ? 0 : stretches.back().end)) return;
    if (stretches.empty() || stretches.back().near != near) stretches.push_back({0, near});
    stretches.back().end = end;
}

void draw(const Samples& samples, const DrawSettings& by, const Places& places, PixelBlock block,
          std::span<const NearCodes> near, DrawScratch& scratch, DrawnSamples& drawn) {
    drawn.clear();
    const Drawer drawer(samples, by, block, near);
    switch (by.rule) {
        case DrawRule::stratified:
            return drawer.stratified(places.offsets, drawn);
        case DrawRule::gaussian:
            return drawer.gaussian(places, scratch, drawn);
        case DrawRule::distinct:
            return drawer.distinct(places, scratch, drawn);
    }
}

}  // namespace weft::rpf
