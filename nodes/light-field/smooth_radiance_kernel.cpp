#include <algorithm>
#include <cmath>
#include <vector>
#include <limits>

#include "light-field/simd.h"
#include "light-field/smooth_radiance_kernel.h"

namespace weft::light_field::WEFT_ISA {
namespace {

constexpr size_t widths = Smoothing::widths, treatments = Smoothing::treatments;

// A place on a surface, in every lane.
struct Place {
    float px, py;
    VF x, y, slope, vx, vy, depth;
    Place(const SampleField& s, size_t at)
        : px(s.x[at]), py(s.y[at]), x(hn::Set(f, s.x[at])), y(hn::Set(f, s.y[at])), slope(hn::Set(f, s.slope[at])),
          vx(hn::Set(f, s.velocity_x[at])), vy(hn::Set(f, s.velocity_y[at])), depth(hn::Set(f, s.log_depth[at])) {}
};

// The neighbours of samples within `reach` on their surfaces. Samples of one cell look through the same runs of
// samples, which are found once for all of them.
class Neighbours {
  public:
    Neighbours(const SampleField& field, const Smoothing& by, float reach)
        : s_(field), limit_(hn::Set(f, reach * reach)), slope_(hn::Set(f, by.slope)),
          velocity_(hn::Set(f, by.velocity)), depth_(hn::Set(f, by.depth)) {
        // How many cells to either side the disks around a cell's points reach into, so many rows away.
        for (int rows = 0;; ++rows) {
            const float away = std::max(0.0f, float(rows - 1) * field.cell - 1e-3f);
            if (away > reach) break;
            const float half = std::sqrt(reach * reach - away * away) + 1e-3f;
            columns_.push_back(int(std::ceil(half / field.cell)));
        }
    }

    // work(i, distance, mask) for vectors i ... of samples of which some may be neighbours of the place's, sample `at`.
    template <class Work>
    HWY_INLINE void each(size_t at, const Place& place, Work&& work) {
        look_up(at);
        for (size_t k = 0; k < count_; ++k) {
            const Vector v = vectors_[k];
            const size_t i = v.first;
            const VF dx = hn::Sub(hn::LoadU(f, &s_.x[i]), place.x), dy = hn::Sub(hn::LoadU(f, &s_.y[i]), place.y);
            const VF d2 = hn::MulAdd(dx, dx, hn::Mul(dy, dy));
            auto near = hn::And(hn::Lt(d2, limit_), hn::FirstN(f, v.count));
            near = hn::And(near, hn::Le(hn::AbsDiff(hn::LoadU(f, &s_.slope[i]), place.slope), slope_));
            near = hn::And(near, hn::Le(hn::AbsDiff(hn::LoadU(f, &s_.log_depth[i]), place.depth), depth_));
            if (s_.moving) {
                near = hn::And(near, hn::Le(hn::AbsDiff(hn::LoadU(f, &s_.velocity_x[i]), place.vx), velocity_));
                near = hn::And(near, hn::Le(hn::AbsDiff(hn::LoadU(f, &s_.velocity_y[i]), place.vy), velocity_));
            }
            work(i, hn::Sqrt(d2), near);
        }
    }

  private:
    struct Vector {
        std::uint32_t first, count;
    };

    void look_up(size_t at) {
        const int column = s_.column_of(s_.x[at]), row = s_.row_of(s_.y[at]);
        if (column == column_ && row == row_) return;
        column_ = column;
        row_ = row;
        // (The outermost cells hold whatever lies beyond them, too; that is no nearer to others than they are.)
        const int rows = int(columns_.size()) - 1;
        size_t n = 0;
        for (int r = std::max(row - rows, 0), bottom = std::min(row + rows, s_.rows - 1); r <= bottom; ++r) {
            const int across = columns_[size_t(std::abs(r - row))];
            const std::uint32_t* start = &s_.start[size_t(r) * size_t(s_.columns)];
            std::uint32_t i = start[std::max(column - across, 0)];
            const std::uint32_t end = start[std::min(column + across, s_.columns - 1) + 1];
            const size_t most = n + (end - i) / lanes + 1;
            if (vectors_.size() < most) vectors_.resize(2 * most);
            for (; i < end; i += lanes) vectors_[n++] = {i, std::min(end - i, std::uint32_t(lanes))};
        }
        count_ = n;
    }

    const SampleField& s_;
    const VF limit_, slope_, velocity_, depth_;
    int column_ = -1, row_ = -1;  // of the cell whose runs these are
    std::vector<Vector> vectors_;
    size_t count_ = 0;
    std::vector<int> columns_;
};

float sum(VF v) { return hn::GetLane(hn::SumOfLanes(f, v)); }

// Weighted sums of radiance.
struct Sums {
    VF w = hn::Zero(f), r = hn::Zero(f), g = hn::Zero(f), b = hn::Zero(f);
    HWY_INLINE void add(VF weight, VF red, VF green, VF blue) {
        w = hn::Add(w, weight);
        r = hn::MulAdd(weight, red, r);
        g = hn::MulAdd(weight, green, g);
        b = hn::MulAdd(weight, blue, b);
    }
};

// Least and greatest of radiances.
struct Range {
    VF most, least = most, greatest = hn::Neg(most);
    HWY_INLINE void add(hn::Mask<decltype(f)> which, VF value) {
        least = hn::IfThenElse(which, hn::Min(least, value), least);
        greatest = hn::IfThenElse(which, hn::Max(greatest, value), greatest);
    }
    // Past the ends by a quarter of the least: the same at both, so that what is too dark and what is too bright cancel.
    float limit(float value) const {
        const float low = hn::GetLane(hn::MinOfLanes(f, least)), past = 0.25f * std::abs(low);
        return std::clamp(value, low - past, hn::GetLane(hn::MaxOfLanes(f, greatest)) + past);
    }
};

// 1 - distance / width.
HWY_INLINE VF tent(VF distance, VF per_width) { return hn::NegMulAdd(distance, per_width, hn::Set(f, 1.0f)); }

}  // namespace

void filter_samples(const SampleField& s, const Smoothing& by, size_t begin, size_t end, Filtered& out) {
    const VF per_width = hn::Set(f, 1.0f / by.width[0]);
    Neighbours narrow(s, by, by.width[0]);
    for (size_t at = begin; at < end; ++at) {
        Sums sums;
        narrow.each(at, Place(s, at), [&](size_t i, VF distance, auto near) HWY_ATTR {
            const VF part = tent(distance, per_width), weight = hn::IfThenElseZero(near, hn::Mul(part, part));
            sums.add(weight, hn::LoadU(f, &s.r[i]), hn::LoadU(f, &s.g[i]), hn::LoadU(f, &s.b[i]));
        });
        const float weight = sum(sums.w);  // 1 at least, the sample's own
        out.weight[at] = weight;
        out.r[at] = sum(sums.r) / weight;
        out.g[at] = sum(sums.g) / weight;
        out.b[at] = sum(sums.b) / weight;
    }
}

void find_errors(const SampleField& s, const Filtered& filtered, const Smoothing& by, size_t begin, size_t end,
                 Changes& out) {
    const VF zero = hn::Zero(f);
    VF per_width[widths];
    for (size_t k = 0; k < widths; ++k) per_width[k] = hn::Set(f, 1.0f / by.width[k]);
    Neighbours wide_ones(s, by, by.width[widths - 1]), narrow(s, by, by.width[0]);
    for (size_t at = begin; at < end; ++at) {
        const Place place(s, at);
        Sums wide[widths];
        wide_ones.each(at, place, [&](size_t i, VF distance, auto near) HWY_ATTR {
            const VF r = hn::LoadU(f, &s.r[i]), g = hn::LoadU(f, &s.g[i]), b = hn::LoadU(f, &s.b[i]);
            for (size_t k = 1; k < widths; ++k)
                wide[k].add(hn::IfThenElseZero(near, hn::Max(zero, tent(distance, per_width[k]))), r, g, b);
        });
        Sums sharp;
        VF overlap = zero;
        narrow.each(at, place, [&](size_t i, VF distance, auto near) HWY_ATTR {
            const VF part = tent(distance, per_width[0]), weight = hn::IfThenElseZero(near, hn::Mul(part, part));
            const auto doubled = [&](std::span<const float> y, std::span<const float> mean) HWY_ATTR {
                const VF value = hn::LoadU(f, &y[i]);
                return hn::Sub(hn::Add(value, value), hn::LoadU(f, &mean[i]));
            };
            sharp.add(weight, doubled(s.r, filtered.r), doubled(s.g, filtered.g), doubled(s.b, filtered.b));
            overlap = hn::Add(overlap, hn::IfThenElseZero(near, hn::Div(hn::Mul(weight, weight), hn::LoadU(f, &filtered.weight[i]))));
        });
        const float own[3] = {s.r[at], s.g[at], s.b[at]};
        // Predictions with the sample itself among them, and its share in each: leaving it out multiplies the
        // difference from it by 1 / (1 - share).
        float guess[treatments][3], share[treatments];
        const auto put = [&](size_t k, float r, float g, float b, float part) {
            guess[k][0] = r, guess[k][1] = g, guess[k][2] = b, share[k] = part;
        };
        put(0, filtered.r[at], filtered.g[at], filtered.b[at], 1 / filtered.weight[at]);
        for (size_t k = 1; k < widths; ++k) {
            const float weight = sum(wide[k].w);
            put(k, sum(wide[k].r) / weight, sum(wide[k].g) / weight, sum(wide[k].b) / weight, 1 / weight);
        }
        // Of H + H (1 - H), with H_ij = w_ij / W_i.
        const float weight = filtered.weight[at];
        put(widths, sum(sharp.r) / weight, sum(sharp.g) / weight, sum(sharp.b) / weight, (2 - sum(overlap)) / weight);
        const float* mean = guess[widths - 1];
        const auto off = [&](size_t k, size_t c) {
            // A sample all alone is predicted by the widest mean, which is itself.
            return share[k] < 0.999f ? (own[c] - guess[k][c]) / (1 - share[k]) : own[c] - mean[c];
        };
        float as_is[3], per_level[3];
        for (size_t c = 0; c < 3; ++c) {
            as_is[c] = off(0, c);
            per_level[c] = 1 / (mean[c] * mean[c] + by.epsilon * by.epsilon);
        }
        for (size_t k = 1; k < treatments; ++k) {
            float gain = 0, way = 0;
            for (size_t c = 0; c < 3; ++c) {
                const float error = off(k, c), apart = error - as_is[c];
                gain += (error * error - as_is[c] * as_is[c]) * per_level[c];
                way += apart * apart * per_level[c];
            }
            out.gain[out.at(k, at)] = gain;
            out.way[out.at(k, at)] = way;
        }
    }
}

void choose(const SampleField& s, const Changes& changes, const Smoothing& by, size_t begin, size_t end,
            std::vector<Treatment>& best) {
    const VF zero = hn::Zero(f), per_window = hn::Set(f, 1.0f / by.window);
    // Averages change little from one sample to the next on a surface: the last few choices are taken again.
    constexpr size_t kept = 4;
    size_t last[kept], known = 0;
    const float near2 = 0.5f * by.width[0] * by.width[0];
    Neighbours around(s, by, by.window);
    for (size_t at = begin; at < end; ++at) {
        const auto alike = [&](size_t other) {
            const float dx = s.x[at] - s.x[other], dy = s.y[at] - s.y[other];
            return dx * dx + dy * dy <= near2 && std::abs(s.slope[at] - s.slope[other]) <= by.slope &&
                   std::abs(s.log_depth[at] - s.log_depth[other]) <= by.depth &&
                   std::abs(s.velocity_x[at] - s.velocity_x[other]) <= by.velocity &&
                   std::abs(s.velocity_y[at] - s.velocity_y[other]) <= by.velocity;
        };
        const size_t* of = std::find_if(last, last + std::min(known, kept), alike);
        if (of != last + std::min(known, kept)) {
            best[at] = best[*of];
            continue;
        }
        last[known++ % kept] = at;
        VF gains[treatments], spread[treatments], ways[treatments];
        for (size_t k = 1; k < treatments; ++k) gains[k] = spread[k] = ways[k] = zero;
        around.each(at, Place(s, at), [&](size_t i, VF distance, auto near) HWY_ATTR {
            const VF weight = hn::IfThenElseZero(near, tent(distance, per_window));
            for (size_t k = 1; k < treatments; ++k) {
                const VF gain = hn::Mul(weight, hn::LoadU(f, &changes.gain[changes.at(k, i)]));
                gains[k] = hn::Add(gains[k], gain);
                spread[k] = hn::MulAdd(gain, gain, spread[k]);
                ways[k] = hn::MulAdd(weight, hn::LoadU(f, &changes.way[changes.at(k, i)]), ways[k]);
            }
        });
        float least = 0;
        best[at] = {};
        for (size_t k = 1; k < treatments; ++k) {
            const float caution = k == widths ? by.sharp_caution : by.caution;
            const float gain = sum(gains[k]) + caution * std::sqrt(sum(spread[k])), way = sum(ways[k]);
            if (!(gain < way)) continue;
            // Part a of the way from the sample as it is changes the error by a (gain - way) + a^2 way.
            const float part = std::min(1.0f, 0.5f * (way - gain) / way), score = part * (gain - way + part * way);
            if (score < least) {
                least = score;
                best[at] = {std::uint8_t(k), part};
            }
        }
    }
}

void treat(const SampleField& s, const Filtered& filtered, const std::vector<Treatment>& best, const Smoothing& by,
           size_t begin, size_t end, std::span<float> rgb) {
    static_assert(widths == 4);
    Neighbours by_width[widths] = {{s, by, by.width[0]}, {s, by, by.width[1]}, {s, by, by.width[2]}, {s, by, by.width[3]}};
    Neighbours& narrow = by_width[0];
    for (size_t at = begin; at < end; ++at) {
        const auto [k, part] = best[at];
        if (k == 0) continue;
        const float own[3] = {s.r[at], s.g[at], s.b[at]};
        float* to = &rgb[3 * size_t(s.order[at])];
        const auto put = [&](float r, float g, float b) {
            const float treated[3] = {r, g, b};
            for (size_t c = 0; c < 3; ++c) to[c] = own[c] + part * (treated[c] - own[c]);
        };
        if (k == widths) {
            // Within what its neighbours are, or else one bright sample leaves dark ones around it and grows itself.
            const VF most = hn::Set(f, std::numeric_limits<float>::max());
            Range red{most}, green{most}, blue{most};
            narrow.each(at, Place(s, at), [&](size_t i, VF, auto near) HWY_ATTR {
                red.add(near, hn::LoadU(f, &s.r[i]));
                green.add(near, hn::LoadU(f, &s.g[i]));
                blue.add(near, hn::LoadU(f, &s.b[i]));
            });
            put(red.limit(2 * own[0] - filtered.r[at]), green.limit(2 * own[1] - filtered.g[at]),
                blue.limit(2 * own[2] - filtered.b[at]));
            continue;
        }
        Sums sums;
        const VF per_width = hn::Set(f, 1.0f / by.width[k]);
        by_width[k].each(at, Place(s, at), [&](size_t i, VF distance, auto near) HWY_ATTR {
            const VF weight = hn::IfThenElseZero(near, tent(distance, per_width));
            sums.add(weight, hn::LoadU(f, &s.r[i]), hn::LoadU(f, &s.g[i]), hn::LoadU(f, &s.b[i]));
        });
        const float weight = sum(sums.w);  // 1 at least, the sample's own
        put(sum(sums.r) / weight, sum(sums.g) / weight, sum(sums.b) / weight);
    }
}

}  // namespace weft::light_field::WEFT_ISA
