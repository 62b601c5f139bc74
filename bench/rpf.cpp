// What does each step of random parameter filtering cost, and how far is it from what its work must
// cost? Input: preset release's four passes on 128 x 128 pixels of 8 made-up samples, 18 features
// and 5 random parameters, on one thread. Prints, for each instruction set and pass, nanoseconds a
// sample of the picture (median of 5 rounds over 64 pixels), the floor and their ratio. The floor
// is a count: vector instructions that the step's cells, pairs and numbers take at the least, two
// of them a cycle, everything at hand in the nearest cache.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/cpu_time.h"
#include "rpf/draws.h"
#include "rpf/kernels.h"
#include "rpf/mutual_information.h"
#include "rpf/pixel_bounds.h"
#include "samples/random.h"

using namespace weft;
using namespace weft::rpf;

namespace {

constexpr int side = 128, spp = 8, pixels = 64, rounds = 5, repeats = 4;

float noise(size_t i, size_t k) {
    return unit_float(mix(mix(i) + k));
}

// Smooth over the picture, with noise, as features and colours are.
SampleVectors made_up() {
    SampleVectors v;
    Samples& s = v.samples;
    s.width = s.height = side;
    s.spp = spp;
    const size_t n = size_t(side) * side * spp;
    s.set_size(n);
    v.channels = {"xy", "uv", "t", "light_uv"};
    v.components = {{Role::position, 0}, {Role::position, 0}, {Role::random, 1}, {Role::random, 1},
                    {Role::random, 2},   {Role::random, 3},   {Role::random, 3}};
    for (const char* name : {"position", "normal", "albedo", "position2", "normal2", "albedo2"}) {
        for (int k = 0; k < 3; ++k) v.components.push_back({Role::feature, int(v.channels.size())});
        v.channels.push_back(name);
    }
    v.values.resize(n * v.stride() + SampleVectors::padding);
    std::fill(v.values.begin(), v.values.end(), 0.0f);
    std::vector<float> xy, rgb;
    for (size_t i = 0; i < n; ++i) {
        const size_t pixel = i / spp;
        const float x = float(pixel % side) + noise(i, 0), y = float(pixel / side) + noise(i, 1);
        float* to = &v.values[i * v.stride()];
        to[0] = x;
        to[1] = y;
        for (size_t k = 2; k < 7; ++k) to[k] = noise(i, k);
        for (size_t k = 7; k < v.components.size(); ++k)
            to[k] = std::sin(0.02f * float(k) * x + 0.03f * y) + 0.3f * noise(i, k) + 0.1f * to[2];
        xy.insert(xy.end(), {x, y});
        for (size_t c = 0; c < 3; ++c) {
            rgb.push_back(to[8 + c] + 1.5f + noise(i, 30) + 0.2f * to[5]);
            to[v.components.size() + c] = rgb.back();
        }
    }
    s.add("xy", 2, xy);
    s.add("rgb", 3, rgb);
    return v;
}

// Cycles a nanosecond: how long a chain of additions takes, each of which waits for the one before,
// when nobody disturbs.
double clock_rate() {
    constexpr size_t steps = 10'000'000;
    double best = 0;
    std::uint64_t x = 1;
    for (int run = 0; run < 20; ++run) {
        const double start = cpu_s();
        for (size_t i = 0; i < steps; ++i) asm volatile("add %0, %0" : "+r"(x));
        best = std::max(best, double(steps) / (cpu_s() - start) * 1e-9);
    }
    return best;
}

struct Step {
    const char* name;
    double cycles = 0;  // the floor
    double seconds = 0;
};

class Pass {
  public:
    Pass(const SampleVectors& v, int box, double share) : v_(v) {
        by_ = {DrawRule::distinct,
               box,
               size_t(share * box * box * spp),
               std::max(1.0f, float(box - 1) / 4),
               spp,
               1};
        places_ = make_places(by_);
    }

    // One pixel through all steps.
    void run(int x, int y, std::vector<Step>& steps) {
        const PixelBlock at{x, y, x + 1, y + 1};
        const double lanes = active_isa() == Isa::v4 ? 16 : active_isa() == Isa::v3 ? 8 : 4;
        const size_t first = (size_t(y) * side + size_t(x)) * spp;
        size_t step = 0;
        const auto time = [&](double cycles, auto&& what) {
            const double start = cpu_s();
            for (int i = 0; i < repeats; ++i) what();
            steps[step].seconds += (cpu_s() - start) / repeats;
            steps[step++].cycles += cycles;
        };
        std::vector<float> centre(v_.stride() + 16, 0.0f),
            bound(v_.stride() + 16, std::numeric_limits<float>::infinity());
        for (size_t k = 7; k < 16; ++k) {
            centre[k] = v_.of(first)[k];
            bound[k] = 0.9f;
        }
        find_near_codes(v_.bounds, centre, bound, near_);
        // A step's count is known once it has run, so the floor of the draw is that of the pixel
        // before: all are alike.
        time(double(by_.draws) + double(drawn_.sample.size()) / lanes,
             [&] { draw(v_.samples, by_, places_, at, near_, scratch_, drawn_); });
        n_.vectors = &v_;
        n_.own_offset = {0, spp};
        n_.pitch = ((spp + drawn_.sample.size() + 15) / 16 | 1) * 16;
        const auto take = [&] {
            n_.sample.resize(spp);
            for (std::uint32_t i = 0; i < spp; ++i) n_.sample[i] = std::uint32_t(first) + i;
            WEFT_PICK(take_near)(v_, drawn_, centre.data(), bound.data(), layout_, n_);
        };
        take();
        const auto n = double(n_.samples()), rows = double(n_.rows());
        // Comparisons; of what is taken two to lay out and five for the sums.
        time(2 * double(drawn_.sample.size()) * std::ceil(9 / lanes) + 3.5 * n * rows / lanes,
             take);

        std::vector<NumberRow> numbers;
        const auto add = [&](size_t row) {
            numbers.push_back(
                {n_.row(row), n_.low[row], n_.high[row], n_.mean[row], n_.scale[row]});
        };
        for (size_t k = 0; k < 7; ++k) add(k);
        for (size_t c = 0; c < 3; ++c) add(n_.color_row(c));
        for (size_t k = 7; k < v_.components.size(); ++k) add(k);
        sort_rows(numbers, n_.samples(), Binning::spanned, 5, binned_);
        const auto columns = double(binned_.pitch), parameters = double(binned_.end(6)),
                   colors = double(binned_.end(9)) - parameters;
        time(columns * n / lanes,
             [&] { sort_rows(numbers, n_.samples(), Binning::spanned, 5, binned_); });
        const double cells =
            (columns - parameters) * parameters + colors * (columns - parameters - colors);
        time(cells * (1.5 * n / (32 * lanes) + 1), [&] {
            information_(binned_, {7, 10}, {10, numbers.size()}, found_);
            information_(binned_, {7, numbers.size()}, {0, 7}, found_);
        });

        weights_.of_row.assign(n_.rows(), 0.0f);
        for (size_t k = 7; k < v_.components.size(); ++k) weights_.of_row[k] = 0.05f;
        for (size_t c = 0; c < 3; ++c) weights_.of_row[n_.color_row(c)] = 0.3f;
        out_.take_own(n_, v_.samples);
        time(spp * n / lanes * (2 * 21 + 20) / 2, [&] {
            WEFT_PICK(filter)(n_, weights_, v_.samples.rgb().data(), {1, 6}, filter_, out_);
        });
        cells_ += cells;
        pairs_ += spp * n;
        samples_ += n;
    }
    double cells() const { return cells_ / pixels / spp; }
    double pairs() const { return pairs_ / pixels / spp; }
    double neighbours() const { return samples_ / pixels; }
    void forget() { cells_ = pairs_ = samples_ = 0; }

  private:
    const SampleVectors& v_;
    DrawSettings by_;
    Places places_;
    DrawScratch scratch_;
    std::vector<NearCodes> near_;
    DrawnSamples drawn_;
    Neighbourhoods n_;
    BinnedRows binned_;
    MutualInformation information_;
    std::vector<double> found_;
    Weights weights_;
    FilterScratch filter_;
    LayoutScratch layout_;
    SampleColors out_;
    double cells_ = 0, pairs_ = 0, samples_ = 0;
};

}  // namespace

int main() {
    SampleVectors v = made_up();
    PlainContext ctx;
    find_pixel_bounds(v, ctx);
    const double clock = clock_rate();
    fmt::print("{:.2f} cycles a nanosecond\n", clock);
    const std::vector<Step> steps = {
        {"draw"}, {"take what is near"}, {"sort into bins"}, {"mutual information"}, {"filter"}};
    for (const Isa isa : {Isa::v2, Isa::v3, Isa::v4}) {
        if (isa > best_isa()) continue;
        pin_isa(isa);
        for (const auto& [box, share] :
             {std::pair{45, 1 / 3.0}, {30, 1 / 3.0}, {15, 0.5}, {5, 0.5}}) {
            Pass pass(v, box, share);
            std::vector<std::vector<double>> times(steps.size());
            std::vector<Step> now;
            for (int round = 0; round <= rounds; ++round) {  // the first is for caches and buffers
                now = steps;
                pass.forget();
                for (int i = 0; i < pixels; ++i) pass.run(48 + i % 8, 48 + i / 8, now);
                for (size_t s = 0; s < steps.size() && round > 0; ++s)
                    times[s].push_back(now[s].seconds);
            }
            fmt::print(
                "\n{}  box {}: {:.0f} neighbours a pixel; a sample: {:.0f} filter pairs, {:.0f} "
                "histogram cells\n",
                name_of(isa), box, pass.neighbours(), pass.pairs(), pass.cells());
            double all = 0, least = 0;
            const auto print = [&](const char* name, double ns, double floor) {
                fmt::print("    {:20}{:9.1f} ns  floor {:9.1f} ns  x {:.1f}\n", name, ns, floor,
                           ns / floor);
            };
            for (size_t s = 0; s < steps.size(); ++s) {
                std::sort(times[s].begin(), times[s].end());
                const double ns = times[s][rounds / 2] * 1e9 / pixels / spp,
                             floor = now[s].cycles / clock / pixels / spp;
                print(steps[s].name, ns, floor);
                all += ns;
                least += floor;
            }
            print("all", all, least);
        }
    }
}
