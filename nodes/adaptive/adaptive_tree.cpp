#include "adaptive/adaptive_tree.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "samples/random.h"

namespace weft::adaptive {
namespace {

constexpr size_t least_round = 256;  // leaves
constexpr size_t most_samples = 66;  // a leaf ever has: capacity is 64 at most
constexpr size_t most_in_small = 8;  // samples of a leaf that is too small to be cut

// Numbers of a place in the tree: of a leaf as it is now, by candidate and axis.
class Numbers {
  public:
    Numbers(std::uint64_t seed, std::uint64_t key, size_t samples)
        : of_leaf_(mix(seed ^ mix(key))), samples_(std::uint64_t(samples) << 40) {}
    float operator()(size_t candidate, size_t axis) const {
        return unit_float(mix(of_leaf_ ^ (samples_ | std::uint64_t(candidate) << 8 | axis)));
    }

  private:
    std::uint64_t of_leaf_, samples_;
};

// How many first cells along each axis.
std::vector<size_t> initial_cells(const TreeSettings& settings, size_t wanted, size_t most) {
    const std::vector<float>& extent = settings.extent;
    const int bits = settings.bits, extra_bits = settings.extra_bits;
    if (bits >= 0) {
        int extra = extra_bits;
        if (extra < 0) {
            const double each = std::pow(2.0, bits * double(extent.size()));
            extra = std::max(
                0, int(std::floor(std::log2(double(std::max<size_t>(wanted, 1)) / each) / 2)));
        }
        std::vector<size_t> cells(extent.size(), size_t(1) << bits);
        cells[0] <<= extra, cells[1] <<= extra;
        return cells;
    }
    // At least one for 4 px of picture and two along the others, unless that takes more than half
    // the budget; beyond that as many as `wanted`, of about equal sides.
    const auto cells_of = [&](double side, double px) {
        std::vector<size_t> cells;
        for (size_t d = 0; d < extent.size(); ++d) {
            const size_t least = d < 2 ? size_t(std::ceil(double(extent[d]) / px)) : 2;
            cells.push_back(std::max(least, size_t(double(extent[d]) / side)));
        }
        return cells;
    };
    const auto count = [](const std::vector<size_t>& cells) {
        double all = 1;
        for (const size_t n : cells) all *= double(n);
        return all;
    };
    double px = 4;
    while (px < 64 && count(cells_of(1e9, px)) > 0.5 * double(most)) px *= 1.25;
    const double allowed = std::min(double(wanted), 0.5 * double(most));
    double fine = 1e-3, coarse = 1e9;
    for (int step = 0; step < 100; ++step) {
        const double side = std::sqrt(fine * coarse);
        (count(cells_of(side, px)) > allowed ? fine : coarse) = side;
    }
    return cells_of(coarse, px);
}

}  // namespace

double leaf_error(std::span<const float> rgb, double volume, Contrast contrast) {
    const size_t n = rgb.size() / 3;
    if (n == 0) return 0;
    const double each = 1 / double(n);
    double sum = 0;
    for (size_t c = 0; c < 3; ++c) {
        double mean = 0;
        for (size_t i = 0; i < n; ++i) mean += double(rgb[3 * i + c]);
        mean *= each;
        double off = 0;
        // Fireflies draw no more than sixteen times what is around them.
        const double most = mean > 0 ? 16 * mean : 1e300;
        for (size_t i = 0; i < n; ++i)
            off += std::abs(std::min(double(rgb[3 * i + c]), most) - mean);
        off *= each;
        const double level = std::max(mean, 0.0) + 1e-3;
        sum += contrast == Contrast::absolute
                   ? off
                   : off / (contrast == Contrast::sqrt ? std::sqrt(level) : level);
    }
    return volume * (sum + 1e-5);
}

float plane_between(std::span<const float> along) {
    const size_t left = along.size() / 2;
    return 0.5f * (along[left - 1] + along[left]);
}

// Rows and columns of cells are shifted from one slab (of the axes behind x and y) to the next:
// what a cell leaves unresolved at its sides then averages out over the slabs, where sides in line
// would add up.
Tree::Tree(const TreeSettings& settings, size_t initial_samples, size_t budget)
    : settings_(settings) {
    const size_t axes = dimensions();
    requested_.resize(axes);
    const std::vector<size_t> cells =
        initial_cells(settings_, initial_samples / settings_.capacity, budget / settings_.capacity);
    size_t slabs = 1;
    for (size_t d = 2; d < axes; ++d) slabs *= cells[d];
    const auto along = [&](size_t d, size_t slab) {
        std::vector<float> sides{0};
        const float side = settings_.extent[d] / float(cells[d]);
        const float shift = slabs > 1 ? unit_float(mix(mix(settings_.seed ^ d) ^ slab)) : 0;
        for (size_t k = 1; k < cells[d] + 1; ++k) {
            const float at = (float(k) - shift) * side;
            if (at > 0.25f * side && settings_.extent[d] - at > 0.25f * side) sides.push_back(at);
        }
        sides.push_back(settings_.extent[d]);
        return sides;
    };
    std::vector<CellSlab> grid;
    for (size_t slab = 0; slab < slabs; ++slab) {
        grid.push_back({along(0, slab), along(1, slab), std::uint32_t(leaves_.size())});
        const std::vector<float>&x = grid.back().x, &y = grid.back().y;
        for (size_t j = 0; j + 1 < y.size(); ++j)
            for (size_t i = 0; i + 1 < x.size(); ++i) {
                Leaf leaf{};
                leaf.key = mix(leaves_.size());
                leaf.lo[0] = x[i], leaf.hi[0] = x[i + 1];
                leaf.lo[1] = y[j], leaf.hi[1] = y[j + 1];
                size_t rest = slab;
                for (size_t d = 2; d < axes; ++d) {
                    const size_t k = rest % cells[d];
                    rest /= cells[d];
                    leaf.lo[d] = settings_.extent[d] * float(k) / float(cells[d]);
                    leaf.hi[d] = settings_.extent[d] * float(k + 1) / float(cells[d]);
                }
                leaves_.push_back(std::move(leaf));
            }
    }
    errors_.resize(leaves_.size());
    rests_.resize(leaves_.size());
    if (settings_.reach == Reach::neighbours) neighbours_ = LeafNeighbours(grid, cells);
}

double Tree::volume(const Leaf& leaf) const {
    double v = 1;
    for (size_t d = 0; d < dimensions(); ++d) v *= double(leaf.hi[d]) - double(leaf.lo[d]);
    return v;
}

double Tree::largest_error() const {
    return errors_.empty() ? 0 : *std::max_element(errors_.begin(), errors_.end());
}
double Tree::total_error() const {
    return std::accumulate(errors_.begin(), errors_.end(), 0.0);
}

// Those of largest error, or, with alpha, each by chance; in order.
std::vector<std::uint32_t> Tree::chosen_leaves(size_t most) const {
    std::vector<std::uint32_t> chosen;
    if (settings_.alpha > 0) {
        double largest = 0;
        for (size_t l = 0; l < leaves_.size(); ++l)
            if (!rests_[l]) largest = std::max(largest, errors_[l]);
        for (std::uint32_t l = 0; l < leaves_.size() && chosen.size() < most; ++l) {
            const double probability = std::pow(errors_[l] / largest, settings_.alpha);
            const float chance = unit_float(mix(mix(settings_.seed + round_) ^ leaves_[l].key));
            if (!rests_[l] && double(chance) < probability) chosen.push_back(l);
        }
        return chosen;
    }
    const auto round =
        std::min(most, std::max(least_round, size_t(double(leaves_.size()) * settings_.round)));
    std::vector<double> wanting = errors_;  // no error is below 0
    for (size_t l = 0; l < wanting.size(); ++l)
        if (rests_[l]) wanting[l] = -1;
    std::vector<double> sorted = wanting;
    double least = 0;
    if (round < sorted.size()) {
        const auto last = sorted.begin() + std::ptrdiff_t(round) - 1;
        std::nth_element(sorted.begin(), last, sorted.end(), std::greater<>());
        least = std::max(least, *last);
    }
    // Of those whose error is the least the first ones.
    size_t equal = round;
    for (const double error : wanting) equal -= error > least && equal > 0 ? 1 : 0;
    for (std::uint32_t l = 0; l < wanting.size(); ++l)
        if (wanting[l] > least || (wanting[l] == least && equal > 0 && equal-- > 0))
            chosen.push_back(l);
    return chosen;
}

size_t Tree::request(size_t most) {
    ++round_;
    chosen_.clear();
    for (auto& axis : requested_) axis.clear();
    const auto place = [&](std::uint32_t l, const std::array<float, most_axes>& p) {
        chosen_.push_back(l);
        for (size_t d = 0; d < dimensions(); ++d)
            requested_[d].push_back(below_one(p[d] / settings_.extent[d]));
    };
    const auto candidate = [&](const Leaf& leaf, const Numbers& numbers, size_t which) {
        std::array<float, most_axes> p{};
        for (size_t d = 0; d < dimensions(); ++d)
            p[d] = leaf.lo[d] + (leaf.hi[d] - leaf.lo[d]) * numbers(which, d);
        return p;
    };
    if (samples() == 0) {
        // Along each axis one in each of as many parts, in an order of its own (a Latin hypercube).
        const size_t n = settings_.capacity;
        std::vector<std::array<size_t, most_axes>> part(n);
        for (std::uint32_t l = 0; l < leaves_.size(); ++l) {
            const Leaf& leaf = leaves_[l];
            for (size_t d = 0; d < dimensions(); ++d) {
                for (size_t k = 0; k < n; ++k) {
                    const Numbers numbers(settings_.seed, leaf.key, k);
                    const auto j = std::min(k, size_t(numbers(1, d) * float(k + 1)));
                    part[k][d] = part[j][d], part[j][d] = k;
                }
            }
            for (size_t k = 0; k < n; ++k) {
                const Numbers numbers(settings_.seed, leaf.key, k);
                std::array<float, most_axes> p{};
                for (size_t d = 0; d < dimensions(); ++d)
                    p[d] = leaf.lo[d] + (leaf.hi[d] - leaf.lo[d]) *
                                            ((float(part[k][d]) + numbers(0, d)) / float(n));
                place(l, p);
            }
        }
        return chosen_.size();
    }
    const std::vector<std::uint32_t> order = chosen_leaves(most);
    for (const std::uint32_t l : order) {
        const Leaf& leaf = leaves_[l];
        std::array<float, most_axes> best{};
        float farthest = -1;
        const Numbers numbers(settings_.seed, leaf.key, leaf.samples.size());
        for (size_t k = 0; k < size_t(settings_.candidates); ++k) {
            const auto p = candidate(leaf, numbers, k);
            const float nearest = nearest_sample(l, p.data(), farthest);
            if (nearest > farthest) farthest = nearest, best = p;
        }
        place(l, best);
    }
    return order.size();
}

// Square of the distance, px^2, to the nearest sample within reach; or any number that is not above
// `enough`, where that is so.
float Tree::nearest_sample(size_t l, const float* place, float enough) const {
    float nearest = 3e38f;
    const auto among = [&](const Leaf& leaf) {
        for (const std::uint32_t s : leaf.samples) {
            float d2 = 0;
            const float* at = &at_[s * dimensions()];
            for (size_t d = 0; d < dimensions(); ++d) d2 += (at[d] - place[d]) * (at[d] - place[d]);
            nearest = std::min(nearest, d2);
        }
    };
    among(leaves_[l]);
    if (neighbours_.empty()) return nearest;
    for (const std::uint32_t near : neighbours_.of(l)) {
        if (nearest <= enough) break;
        among(leaves_[near]);
    }
    return nearest;
}

void Tree::insert(std::span<const float> rgb) {
    const auto first = std::uint32_t(samples());
    for (size_t i = 0; i < chosen_.size(); ++i)
        for (size_t d = 0; d < dimensions(); ++d)
            at_.push_back(requested_[d][i] * settings_.extent[d]);
    rgb_.insert(rgb_.end(), rgb.begin(), rgb.end());
    for (size_t i = 0; i < chosen_.size(); ++i) add_to(chosen_[i], first + std::uint32_t(i));
}

void Tree::add_to(size_t l, std::uint32_t sample) {
    leaves_[l].samples.push_back(sample);
    if (leaves_[l].samples.size() <= settings_.capacity || !cut(l)) measure(l);
    rests_[l] = leaves_[l].samples.size() >= std::max(most_in_small, settings_.capacity + 1);
}

// Across the longest side, between the samples on both sides of the middle; the first half of them
// keeps the leaf's index. Sides of less than 1/64 px of the picture, or 1/4096 of another axis, are
// not cut, nor are equal numbers.
bool Tree::cut(size_t l) {
    std::array<size_t, most_axes> axes{};
    const auto side = [&](size_t d) { return leaves_[l].hi[d] - leaves_[l].lo[d]; };
    for (size_t d = 0; d < dimensions(); ++d) {
        size_t k = d;
        for (; k > 0 && side(d) >= side(axes[k - 1]); --k) axes[k] = axes[k - 1];
        axes[k] = d;
    }
    const size_t n = leaves_[l].samples.size();
    std::array<std::uint32_t, most_samples> memory;
    const std::span<std::uint32_t> sorted = std::span(memory).first(n);
    for (size_t k = 0; k < dimensions(); ++k) {
        const size_t d = axes[k];
        const float least = d < 2 ? 1.0f / 64 : settings_.extent[d] / 4096;
        if (side(d) < 2 * least) continue;
        std::copy_n(leaves_[l].samples.begin(), n, sorted.begin());
        std::sort(sorted.begin(), sorted.end(), [&](std::uint32_t a, std::uint32_t b) {
            return at(d, a) != at(d, b) ? at(d, a) < at(d, b) : a < b;
        });
        std::array<float, most_samples> along;
        for (size_t i = 0; i < n; ++i) along[i] = at(d, sorted[i]);
        const size_t left = n / 2;
        const float plane = plane_between(std::span(along).first(n));
        if (!(plane > along[left - 1]) || plane - leaves_[l].lo[d] < least ||
            leaves_[l].hi[d] - plane < least)
            continue;
        Leaf other;
        other.lo = leaves_[l].lo, other.hi = leaves_[l].hi;
        leaves_[l].hi[d] = other.lo[d] = plane;
        leaves_[l].samples.assign(sorted.begin(), sorted.begin() + std::ptrdiff_t(left));
        other.samples.assign(sorted.begin() + std::ptrdiff_t(left), sorted.end());
        other.key = mix(leaves_[l].key ^ 2);
        leaves_[l].key = mix(leaves_[l].key ^ 1);
        leaves_.push_back(std::move(other));
        errors_.push_back(0);
        rests_.push_back(false);
        if (!neighbours_.empty())
            neighbours_.cut<Leaf>(std::uint32_t(l), std::uint32_t(leaves_.size() - 1), leaves_,
                                  dimensions());
        measure(l);
        measure(leaves_.size() - 1);
        return true;
    }
    return false;
}

void Tree::measure(size_t l) {
    const Leaf& leaf = leaves_[l];
    std::array<float, 3 * most_samples> rgb;
    size_t n = 0;
    for (const std::uint32_t s : leaf.samples)
        for (size_t c = 0; c < 3; ++c) rgb[n++] = rgb_[3 * size_t(s) + c];
    errors_[l] = leaf_error(std::span(rgb).first(n), volume(leaf), settings_.contrast);
}

}  // namespace weft::adaptive
