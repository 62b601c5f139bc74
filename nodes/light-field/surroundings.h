// The samples around a block of samples, which are then looked at by each of the block, a lane a
// sample: sums over neighbours are lanes' own. For kernels (weft_kernels).
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "light-field/simd.h"
#include "light-field/smooth_radiance_kernel.h"

namespace weft::light_field::WEFT_ISA {

// Some samples of a block, a lane each.
struct Places {
    VF x, y, slope, depth, vx, vy;
    Places(const SampleField& s, size_t at)
        : x(hn::LoadU(f, &s.x[at])),
          y(hn::LoadU(f, &s.y[at])),
          slope(hn::LoadU(f, &s.slope[at])),
          depth(hn::LoadU(f, &s.log_depth[at])),
          vx(hn::LoadU(f, &s.velocity_x[at])),
          vy(hn::LoadU(f, &s.velocity_y[at])) {
        for (size_t c = 0; c < 3; ++c) {
            if (!s.normal[c].empty()) normal[c] = hn::LoadU(f, &s.normal[c][at]);
            if (!s.albedo[c].empty()) albedo[c] = hn::LoadU(f, &s.albedo[c][at]);
        }
    }
    VF normal[3], albedo[3];  // undefined where samples have none
};

// What the samples of a block are between in one quantity.
struct Between {
    float least, most;
    VF low, high;

    Between(const float* from, size_t n) {
        low = high = hn::Set(f, from[0]);
        for (size_t i = 0; i < n; i += lanes) {
            const auto in = hn::FirstN(f, n - i);
            const VF value = hn::LoadU(f, from + i);
            low = hn::IfThenElse(in, hn::Min(low, value), low);
            high = hn::IfThenElse(in, hn::Max(high, value), high);
        }
        low = hn::MinOfLanes(f, low);
        high = hn::MaxOfLanes(f, high);
        least = hn::GetLane(low);
        most = hn::GetLane(high);
    }
    HWY_INLINE VF outside(VF value) const {
        return hn::Max(hn::Zero(f), hn::Max(hn::Sub(low, value), hn::Sub(value, high)));
    }
};

// The samples that may be within the greatest of some radii of one of a block, on its surface, in
// rings: those of ring k are farther than radius k - 1 from all of the block.
template <size_t rings>
class Surroundings {
  public:
    Surroundings(const SampleField& field, const Smoothing& by, std::span<const float> radii)
        : s_(field),
          slope_(hn::Set(f, by.slope)),
          velocity_(hn::Set(f, by.velocity)),
          depth_(hn::Set(f, by.depth)),
          per_normal_(hn::Set(f, 1 / (by.normal * by.normal))),
          albedo_(hn::Set(f, by.albedo)) {
        for (size_t k = 0; k < rings; ++k) radius_[k] = radii[k] * 1.0001f + 1e-4f;  // rounding
    }

    void find(size_t begin, size_t end) {
        const size_t n = end - begin;
        const Between x(&s_.x[begin], n), y(&s_.y[begin], n), slope(&s_.slope[begin], n),
            depth(&s_.log_depth[begin], n), vx(&s_.velocity_x[begin], n),
            vy(&s_.velocity_y[begin], n);
        const float reach = radius_[rings - 1];
        for (auto& ring : ring_) ring.count = 0;
        auto unlike = hn::MaskFromVec(hn::Zero(f));  // for some of the block
        const int top = s_.row_of(y.least - reach), bottom = s_.row_of(y.most + reach);
        for (int row = top; row <= bottom; ++row) {
            const float away =
                std::max({0.0f, s_.top_of(row) - y.most, y.least - s_.top_of(row + 1)});
            const float half = std::sqrt(std::max(0.0f, reach * reach - away * away)) + 1e-3f;
            const std::uint32_t* start = &s_.start[size_t(row) * size_t(s_.columns)];
            size_t i = start[s_.column_of(x.least - half)] - s_.first;
            const size_t last = start[s_.column_of(x.most + half) + 1] - s_.first;
            for (auto& ring : ring_) ring.grow(ring.count + (last - i) + lanes);
            for (; i < last; i += lanes) {
                const VF dx = x.outside(hn::LoadU(f, &s_.x[i])),
                         dy = y.outside(hn::LoadU(f, &s_.y[i]));
                const VF d2 = hn::MulAdd(dx, dx, hn::Mul(dy, dy));
                auto in = hn::And(hn::FirstN(f, last - i), hn::Lt(d2, hn::Set(f, reach * reach)));
                auto far = hn::MaskFromVec(hn::Zero(f));
                const auto test = [&](std::span<const float> values, const Between& block,
                                      VF most) HWY_ATTR {
                    const VF value = hn::LoadU(f, &values[i]);
                    const VF below = hn::Sub(block.high, value), above = hn::Sub(value, block.low);
                    in = hn::And(in, hn::And(hn::Le(hn::Sub(block.low, value), most),
                                             hn::Le(hn::Sub(value, block.high), most)));
                    far = hn::Or(far, hn::Gt(hn::Max(below, above), most));
                };
                test(s_.slope, slope, slope_);
                test(s_.log_depth, depth, depth_);
                if (s_.moving) {
                    test(s_.velocity_x, vx, velocity_);
                    test(s_.velocity_y, vy, velocity_);
                }
                unlike = hn::Or(unlike, hn::And(in, far));
                const VU index = numbers_from(std::uint32_t(i));
                for (size_t k = 0; k < rings; ++k) {
                    const auto within = hn::Lt(d2, hn::Set(f, radius_[k] * radius_[k]));
                    ring_[k].add(index, hn::And(in, within));
                    in = hn::AndNot(within, in);
                }
            }
        }
        alike_ = hn::AllFalse(f, unlike);
    }

    // `sums` after work(sums, i, d2, on_surface) for the samples i of a ring: their squared
    // distance from each place; on_surface(value) is 0 where they are not of the place's surface.
    // (What is summed up is passed by value, to stay in registers.)
    template <class Of, class Work>
    HWY_INLINE Of each(size_t ring, const Places& places, Of sums, Work&& work) const {
        return alike_ ? each_of<true>(ring_[ring], places, sums, work)
                      : each_of<false>(ring_[ring], places, sums, work);
    }

    // The same where normals and albedo matter, too: on_surface(value) is 0 as well where albedo
    // differs, and less the more normals do.
    template <class Of, class Work>
    HWY_INLINE Of each_alike(size_t ring, const Places& places, Of sums, Work&& work) const {
        const bool normals = !s_.normal[0].empty(), albedo = !s_.albedo[0].empty();
        if (!normals && !albedo) return each(ring, places, sums, work);
        return each(ring, places, sums, [&](Of& of, size_t i, VF d2, auto on_surface) HWY_ATTR {
            VF alike = hn::Set(f, 1.0f);
            if (normals) {
                VF apart = hn::Zero(f);
                for (size_t c = 0; c < 3; ++c) {
                    const VF way = hn::Sub(hn::Set(f, s_.normal[c][i]), places.normal[c]);
                    apart = hn::MulAdd(way, way, apart);
                }
                alike = hn::Max(hn::Zero(f), hn::NegMulAdd(apart, per_normal_, alike));
            }
            for (size_t c = 0; albedo && c < 3; ++c)
                alike = hn::IfThenElseZero(
                    hn::Le(hn::AbsDiff(hn::Set(f, s_.albedo[c][i]), places.albedo[c]), albedo_),
                    alike);
            work(of, i, d2, [&](VF value) HWY_ATTR { return on_surface(hn::Mul(alike, value)); });
        });
    }

  private:
    struct Ring {
        std::vector<std::uint32_t> sample;
        size_t count = 0;
        void grow(size_t n) {
            if (sample.size() < n) sample.resize(2 * n);
        }
        template <class M>
        HWY_INLINE void add(VU index, M which) {
            const Pack pack(which);
            pack.store(index, &sample[count]);
            count += pack.count;
        }
    };

    template <bool alike, class Of, class Work>
    HWY_INLINE Of each_of(const Ring& ring, const Places& p, Of sums, Work&& work) const {
        const float *x = s_.x.data(), *y = s_.y.data();
        for (const std::uint32_t i : std::span(ring.sample).first(ring.count)) {
            const VF dx = hn::Sub(hn::Set(f, x[i]), p.x), dy = hn::Sub(hn::Set(f, y[i]), p.y);
            const VF d2 = hn::MulAdd(dx, dx, hn::Mul(dy, dy));
            if constexpr (alike) {
                work(sums, i, d2, [](VF value) HWY_ATTR { return value; });
            } else {
                const auto near = [](float a, VF b, VF most) HWY_ATTR {
                    return hn::Le(hn::AbsDiff(hn::Set(f, a), b), most);
                };
                auto in = hn::And(near(s_.slope[i], p.slope, slope_),
                                  near(s_.log_depth[i], p.depth, depth_));
                if (s_.moving)
                    in = hn::And(in, hn::And(near(s_.velocity_x[i], p.vx, velocity_),
                                             near(s_.velocity_y[i], p.vy, velocity_)));
                work(sums, i, d2,
                     [in](VF value) HWY_ATTR { return hn::IfThenElseZero(in, value); });
            }
        }
        return sums;
    }

    const SampleField& s_;
    const VF slope_, velocity_, depth_, per_normal_, albedo_;
    std::array<float, rings> radius_;
    std::array<Ring, rings> ring_;
    bool alike_ = false;  // no two of the block and the rings are of different surfaces
};

}  // namespace weft::light_field::WEFT_ISA
