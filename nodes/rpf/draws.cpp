#include "rpf/draws.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "samples/random.h"

namespace weft::rpf {
namespace {

constexpr size_t run_length = size_t(1) << 16;

// A point of the unit square to one of a Gaussian (Box and Muller 1958).
struct Normal {
    float x, y;
};
Normal normal(float a, float b, float sigma) {
    const float radius = sigma * std::sqrt(-2 * std::log(1 - a)), angle = 2 * std::numbers::pi_v<float> * b;
    return {radius * std::cos(angle), radius * std::sin(angle)};
}

// The pixel of a place within the box around a pixel: the nearest, or the next towards the middle.
bool round_into(Normal at, int box, bool towards_middle, Offset& place) {
    const float x = towards_middle ? std::trunc(at.x) : std::round(at.x), y = towards_middle ? std::trunc(at.y) : std::round(at.y);
    const auto half = float(box / 2);
    if (std::abs(x) > half || std::abs(y) > half) return false;
    place.dx = std::int16_t(x);
    place.dy = std::int16_t(y);
    return true;
}

// Points of the plane's most even lattice (Roberts 2018: steps by powers of the plastic number) carried to the
// Gaussian; what comes to lie on one pixel takes one sample of it after another.
std::vector<Offset> stratified_places(const DrawSettings& by) {
    std::vector<Offset> places;
    std::vector<std::uint16_t> times(size_t(by.box + 1) * size_t(by.box + 1), 0);
    const size_t tries = 16 * by.draws + 1024;
    for (size_t i = 0; i < tries && places.size() < by.draws; ++i) {
        const double a = 0.5 + 0.7548776662466927 * double(i), b = 0.5 + 0.5698402909980532 * double(i);
        Offset place{};
        if (!round_into(normal(float(a - std::floor(a)), float(b - std::floor(b)), by.sigma), by.box, false, place)) continue;
        std::uint16_t& n = times[size_t(place.dy + by.box / 2) * size_t(by.box + 1) + size_t(place.dx + by.box / 2)];
        if ((place.dx == 0 && place.dy == 0) || n >= by.spp) continue;
        place.turn = n++;
        places.push_back(place);
    }
    std::sort(places.begin(), places.end(), [](const Offset& a, const Offset& b) {
        return a.dy != b.dy ? a.dy < b.dy : a.dx != b.dx ? a.dx < b.dx : a.turn < b.turn;
    });
    return places;
}

std::vector<Offset> random_places(const DrawSettings& by) {
    std::vector<Offset> places;
    places.reserve(run_length);
    for (std::uint64_t i = 0; places.size() < run_length; ++i) {
        const std::uint64_t bits = mix(by.seed ^ mix(i));
        const Normal at = normal(unit_float(std::uint32_t(bits)), unit_float(std::uint32_t(bits >> 32)), by.sigma);
        Offset place{};
        const bool inside = round_into(at, by.box, by.rule == DrawRule::distinct, place);
        if (!inside && by.rule == DrawRule::gaussian) continue;
        if (!inside) place.dx = place.dy = INT16_MAX;
        place.turn = std::uint32_t(mix(bits) >> 32);
        places.push_back(place);
    }
    return places;
}

bool within(PixelBlock block, int x, int y) { return x >= block.x0 && x < block.x1 && y >= block.y0 && y < block.y1; }

}  // namespace

std::vector<Offset> make_places(const DrawSettings& by) {
    return by.rule == DrawRule::stratified ? stratified_places(by) : random_places(by);
}

void draw(const Samples& samples, const DrawSettings& by, const std::vector<Offset>& places, PixelBlock block,
          DrawScratch& scratch, std::vector<std::uint32_t>& drawn) {
    const int width = samples.width, height = samples.height;
    const int cx = (block.x0 + block.x1 - 1) / 2, cy = (block.y0 + block.y1 - 1) / 2;
    const std::uint64_t chance = mix(by.seed ^ mix(std::uint64_t(cy) * std::uint64_t(width) + std::uint64_t(cx)));
    const auto inside = [&](int x, int y) { return x >= 0 && x < width && y >= 0 && y < height && !within(block, x, y); };
    const auto pixel = [&](int x, int y) { return samples.of_pixel(size_t(y) * size_t(width) + size_t(x)); };

    if (by.rule == DrawRule::stratified) {
        const int sx = chance & 1 ? -1 : 1, sy = chance & 2 ? -1 : 1;
        const bool turned = chance & 4;
        for (const Offset& p : places) {
            const int x = cx + sx * (turned ? p.dy : p.dx), y = cy + sy * (turned ? p.dx : p.dy);
            if (!inside(x, y)) continue;
            const auto [begin, end] = pixel(x, y);
            const size_t n = end - begin;
            if (p.turn >= n) continue;
            const size_t from = size_t((chance >> 8) + std::uint64_t(x) * 3 + std::uint64_t(y) * 5);
            drawn.push_back(std::uint32_t(begin + (from + p.turn) % n));
        }
        return;
    }
    size_t at = size_t(chance % run_length);
    if (by.rule == DrawRule::gaussian) {
        // Near the picture's corners three of four draws fall outside: as many more are made.
        const size_t tries = 8 * by.draws;
        for (size_t i = 0, found = 0; i < tries && found < by.draws; ++i, at = (at + 1) % run_length) {
            const int x = cx + places[at].dx, y = cy + places[at].dy;
            if (!inside(x, y)) continue;
            const auto [begin, end] = pixel(x, y);
            if (begin == end) continue;
            drawn.push_back(std::uint32_t(begin + std::uint64_t(places[at].turn + std::uint32_t(i) * 0x9e3779b9u) % (end - begin)));
            ++found;
        }
        return;
    }
    const int half = by.box / 2, side = 2 * half + 1;
    scratch.counts.assign(size_t(side) * size_t(side), 0);
    for (size_t i = 0; i < by.draws; ++i, at = (at + 1) % run_length) {
        const Offset& p = places[at];
        if (std::abs(int(p.dx)) <= half && std::abs(int(p.dy)) <= half) ++scratch.counts[size_t(p.dy + half) * size_t(side) + size_t(p.dx + half)];
    }
    for (int dy = -half; dy <= half; ++dy)
        for (int dx = -half; dx <= half; ++dx) {
            const size_t times = scratch.counts[size_t(dy + half) * size_t(side) + size_t(dx + half)];
            if (times == 0 || !inside(cx + dx, cy + dy)) continue;
            const auto [begin, end] = pixel(cx + dx, cy + dy);
            for (size_t i = begin; i < std::min(end, begin + times); ++i) drawn.push_back(std::uint32_t(i));
        }
}

}  // namespace weft::rpf
