#include "rpf/draws.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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
    return places;
}

bool within(PixelBlock block, int x, int y) {
    return x >= block.x0 && x < block.x1 && y >= block.y0 && y < block.y1;
}

// What draws around one block.
class Drawer {
  public:
    Drawer(const Samples& samples, const DrawSettings& by, PixelBlock block)
        : samples_(samples),
          by_(by),
          block_(block),
          cx_((block.x0 + block.x1 - 1) / 2),
          cy_((block.y0 + block.y1 - 1) / 2),
          chance_(mix(by.seed ^ mix(std::uint64_t(cy_) * std::uint64_t(samples.width) +
                                    std::uint64_t(cx_)))) {}

    void stratified(std::span<const Offset> places, std::vector<std::uint32_t>& drawn) const {
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
            drawn.push_back(std::uint32_t(begin + (from + p.turn) % n));
        }
    }

    // Each draw takes any sample of its pixel.
    void gaussian(std::span<const std::uint16_t> cells, DrawScratch& scratch,
                  std::vector<std::uint32_t>& drawn) const {
        find_inside(scratch);
        // Near the picture's corners three of four draws fall outside: as many more are made.
        count(cells, 8 * by_.draws, scratch);
        drawn.resize(by_.draws);
        std::uint32_t* to = drawn.data();
        std::uint64_t state = chance_;
        each_cell([&](size_t cell, Samples::Range of) {
            const std::uint32_t* const last = to + scratch.counts[cell] * scratch.inside[cell];
            for (; to < last; ++to) {
                state = state * 6364136223846793005u +
                        1442695040888963407u;  // Knuth's linear congruence, upper half
                *to = std::uint32_t(of.begin + ((state >> 32) * (of.end - of.begin) >> 32));
            }
        });
        drawn.resize(size_t(to - drawn.data()));
    }

    // How often each pixel was drawn is how many of its samples are taken, as far as it has so
    // many.
    void distinct(std::span<const std::uint16_t> cells, DrawScratch& scratch,
                  std::vector<std::uint32_t>& drawn) const {
        scratch.counts.assign(size_t(side_of(by_)) * size_t(side_of(by_)) + 1, 0);
        const size_t at = size_t(chance_ % cells.size());
        for (size_t left = by_.draws, begin = at; left > 0; begin = 0) {
            const size_t some = std::min(left, cells.size() - begin);
            for (const std::uint16_t cell : cells.subspan(begin, some)) ++scratch.counts[cell];
            left -= some;
        }
        drawn.resize(by_.draws + 2 * at_once);
        std::uint32_t* to = drawn.data();
        each_cell([&](size_t cell, Samples::Range of) {
            // As many as a vector holds are written whether taken or not, which is sooner done than
            // asked.
            const size_t taken = std::min<size_t>(scratch.counts[cell], of.end - of.begin);
            for (size_t i = 0; i < std::max(taken, at_once); i += at_once) {
                const auto begin = std::uint32_t(of.begin + i);
                for (std::uint32_t k = 0; k < at_once; ++k) to[i + k] = begin + k;
            }
            to += taken;
        });
        drawn.resize(size_t(to - drawn.data()));
    }

  private:
    static constexpr size_t at_once = 8;

    // Draws until there are enough that are inside.
    void count(std::span<const std::uint16_t> cells, size_t tries, DrawScratch& scratch) const {
        scratch.counts.assign(scratch.inside.size(), 0);
        if (cells.empty()) return;
        size_t at = size_t(chance_ % cells.size()), found = 0;
        while (tries > 0 && found < by_.draws) {
            // No more than are wanted, so that none is too many.
            const size_t some = std::min({tries, by_.draws - found, cells.size() - at});
            for (const std::uint16_t cell : cells.subspan(at, some)) {
                ++scratch.counts[cell];
                found += scratch.inside[cell];
            }
            tries -= some;
            at = (at + some) % cells.size();
        }
    }
    void find_inside(DrawScratch& scratch) const {
        const auto all = size_t(side_of(by_)) * size_t(side_of(by_));
        scratch.inside.assign(all + 1, 0);
        each_cell(
            [&](size_t cell, Samples::Range of) { scratch.inside[cell] = of.begin < of.end; });
    }
    // Those within the picture and outside the block, row by row.
    template <class Do>
    void each_cell(Do&& what) const {
        const int half = by_.box / 2, side = side_of(by_);
        for (int y = std::max(0, cy_ - half); y <= std::min(samples_.height - 1, cy_ + half); ++y)
            for (int x = std::max(0, cx_ - half); x <= std::min(samples_.width - 1, cx_ + half);
                 ++x)
                if (!within(block_, x, y))
                    what(size_t(y - cy_ + half) * size_t(side) + size_t(x - cx_ + half),
                         pixel(x, y));
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
    int cx_, cy_;
    std::uint64_t chance_;
};

}  // namespace

Places make_places(const DrawSettings& by) {
    return by.rule == DrawRule::stratified ? Places{stratified_places(by), {}} : random_places(by);
}

void draw(const Samples& samples, const DrawSettings& by, const Places& places, PixelBlock block,
          DrawScratch& scratch, std::vector<std::uint32_t>& drawn) {
    drawn.clear();
    const Drawer drawer(samples, by, block);
    switch (by.rule) {
        case DrawRule::stratified:
            return drawer.stratified(places.offsets, drawn);
        case DrawRule::gaussian:
            return drawer.gaussian(places.cells, scratch, drawn);
        case DrawRule::distinct:
            return drawer.distinct(places.cells, scratch, drawn);
    }
}

}  // namespace weft::rpf
