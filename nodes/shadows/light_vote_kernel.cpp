#include "shadows/light_vote_kernel.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "light-field/grid_reach.h"
#include "light-field/local_radius.h"
#include "light-field/projected_entries.h"
#include "shadows/plane_vectors.h"

namespace weft::shadows::WEFT_ISA {
namespace {
using namespace light_field::WEFT_ISA;

// Writes 1 into n bytes: few, as a rule.
HWY_INLINE void mark(std::uint8_t* to, size_t n) {
    constexpr std::uint32_t four = 0x01010101;
    if (n < 4 || n > 8) {
        std::fill_n(to, n, std::uint8_t(1));
        return;
    }
    std::memcpy(to, &four, 4);
    std::memcpy(to + n - 4, &four, 4);
}

class Voting {
  public:
    Voting(const Hierarchy& hits, const Hierarchy& passes, const LightView& view,
           const Locations& at, const ShadowQueries& queries, float bias,
           LightVoteScratch& scratch, LightShares& out)
        : hits_(hits),
          passes_(passes),
          at_(at),
          queries_(queries),
          planes_(view, at.u[0], at.v[0], bias),
          s_(scratch),
          out_(out) {
        lx_ = at.u[0], ly_ = at.v[0];
        lens_x_ = hits.lens.c0 * hits.lens.aspect, lens_y_ = hits.lens.c0;
        angle_ = 1 / float(view.k);
        level_ = 1 / std::max({std::abs(lens_x_), std::abs(lens_y_), 1e-30f});
    }

    // As RayVoting does: by hits; and of those whose light they stop, or near whom there are none,
    // by passes.
    void vote() {
        const size_t n = at_.size();
        out_.share.assign(n, 1);
        out_.votes.assign(n, 0);
        std::vector<std::uint32_t>& open = s_.open;
        open.clear();
        for (size_t l = 0; l < n; ++l)
            if (queries_.inverse_depth[l] > 0) open.push_back(std::uint32_t(l));
        if (open.empty()) return;
        lay_out();
        project(hits_, s_.hits);
        work_out_hits();
        s_.first_stop.assign(1, 0);
        size_t left = 0;
        for (const std::uint32_t l : open) {
            find_stops(l);
            if (out_.share[l] > 0 && out_.votes[l] > 0) continue;
            open[left++] = l;
            s_.first_stop.push_back(std::uint32_t(stops_));
        }
        open.resize(left);
        if (open.empty() || passes_.size() == 0) return;
        project(passes_, s_.passes);
        work_out_passes();
        for (size_t k = 0; k < left; ++k) ask_passes(k);
    }

  private:
    // The grid that both kinds are put into, and where in it each location looks.
    void lay_out() {
        const size_t n = at_.size();
        double sum = 0;
        for (const std::uint32_t l : s_.open) sum += at_.ratio.empty() ? 1.0 : double(at_.ratio[l]);
        reach_ = light_field::largest_radius(hits_, at_);
        // Cells as wide as most searches want them, but no more of them than there is to do.
        cell_ = hits_.radius * float(sum / double(s_.open.size()));
        const auto cells = [&](float side) {
            return (float(at_.x1 - at_.x0) + 2 * reach_ + 2 * side) *
                   (float(at_.y1 - at_.y0) + 2 * reach_ + 2 * side) / (0.5f * side * side);
        };
        constexpr float most_cells = 8192;
        while (cells(cell_) > most_cells) cell_ *= 1.5f;
        lay_grid(s_.hits.projection), lay_grid(s_.passes.projection);
        for (auto* values : {&s_.first, &s_.across, &s_.rows}) values->resize(n + lanes);
        find_reach(s_.hits.projection, at_.x.data(), at_.y.data(), n, hits_.radius,
                   {s_.first.data(), s_.across.data(), s_.rows.data()},
                   at_.ratio.empty() ? nullptr : at_.ratio.data());
        pitch_ = size_t(s_.hits.projection.columns) + 1;
    }
    void lay_grid(Projection& p) const {
        light_field::lay_grid(hits_, at_.x0, at_.y0, at_.x1, at_.y1, reach_, cell_, p);
    }

    // Carries the samples to the batch's point and time that open locations look at.
    void project(const Hierarchy& h, LightVoteGrid& grid) {
        Projection& p = grid.projection;
        s_.wanted.cells.assign(pitch_ * size_t(p.rows) + 8, 0);
        for (const std::uint32_t l : s_.open) {
            std::uint8_t* row = s_.wanted.cells.data() + s_.first[l];
            for (size_t r = 0; r < s_.rows[l]; ++r, row += pitch_) mark(row, s_.across[l]);
        }
        collect(h, reach_ + 2 * cell_, grid.block);
        p.hierarchy = &h;
        light_field::WEFT_ISA::project_depths(h, grid.block, s_.wanted, lx_, ly_, at_.t[0], p);
    }

    // The groups that may be seen around the batch. Other slices of the same pixels look at about
    // the same place of the film from elsewhere, so what served those before is kept, too, unless
    // that is much.
    void collect(const Hierarchy& h, float reach, light_field::Block& block) const {
        const int far = int(std::ceil(reach));
        int x0 = at_.x0 - far, y0 = at_.y0 - far, x1 = at_.x1 + far, y1 = at_.y1 + far;
        const double most = 2.5 * double(x1 - x0) * double(y1 - y0);
        if (block.hierarchy == &h) {
            const int left = std::min(x0, block.x0), top = std::min(y0, block.y0),
                      right = std::max(x1, block.x1), bottom = std::max(y1, block.y1);
            if (double(right - left) * double(bottom - top) < most) {
                if (left == block.x0 && top == block.y0 && right == block.x1 && bottom == block.y1)
                    return;
                x0 = left, y0 = top, x1 = right, y1 = bottom;
            }
        }
        const int more_x = (x1 - x0) / 16, more_y = (y1 - y0) / 16;
        light_field::collect(h, x0 - more_x, y0 - more_y, x1 + more_x, y1 + more_y, 0, block);
    }

    // A location's receiver, as the light's point sees it.
    Seen receiver(size_t l) const {
        return planes_.seen(queries_.inverse_depth[l], {queries_.slope_x[l], queries_.slope_y[l]});
    }

    // work(first entry, dx, dy, 1/w, which) for vectors with some that are nearer to the light than
    // a location's plane, in the order of EntryVectors. Returns how many samples are near.
    template <class Work>
    HWY_INLINE size_t each_nearer(const Projection& p, size_t l, const Seen& r, Work&& work) {
        const float ratio = at_.ratio.empty() ? 1.0f : at_.ratio[l],
                    radius = hits_.radius * ratio;
        const VF limit = hn::Set(f, radius * radius), x = hn::Set(f, at_.x[l]),
                 y = hn::Set(f, at_.y[l]);
        const size_t across = s_.across[l];
        const std::uint32_t* row = p.start.data() + s_.first[l];
        const std::uint32_t* last = row + s_.rows[l] * pitch_;
        size_t near = 0;
        for (; row != last; row += pitch_) {
            const size_t end = row[across];
            for (size_t i = row[0]; i < end; i += lanes) {
                const EntryVectors entry(&p.entries[i]);
                const VF dx = hn::Sub(entry.x(), x), dy = hn::Sub(entry.y(), y);
                const auto in = hn::Lt(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), limit);
                near += hn::CountTrue(f, in);
                const VF depth = hn::BitCast(f, entry.traits());
                const auto nearer = hn::And(in, planes_.nearer(r, dx, dy, depth));
                if (hn::AllFalse(f, nearer)) continue;
                work(i, dx, dy, depth, nearer);
            }
        }
        return near;
    }

    // What stops a location's light, should no ray pass it: stops_ on.
    void find_stops(size_t l) {
        const Seen r = receiver(l);
        const bool planes = !hits_.plane_x.empty();
        const auto& traits = s_.hits.traits;
        auto& stops = s_.stops;
        const size_t first = stops_;
        out_.votes[l] = std::uint32_t(each_nearer(
            s_.hits.projection, l, r,
            [&](size_t i, VF dx, VF dy, VF inverse, auto nearer) HWY_ATTR {
                const auto before = stands_before(r, traits, planes, i, dx, dy, inverse, nearer);
                stops.grow(stops_ + 2 * lanes);
                const Pack pack(before.which);
                pack.store(dx, &stops.x[stops_]);
                pack.store(dy, &stops.y[stops_]);
                pack.store(before.beside, &stops.inverse[stops_]);
                stops_ += pack.count;
            }));
        if (stops_ > first) out_.share[l] = 0;
    }

    // Which of the entries from the i-th on, of those that are `nearer`, stand before a receiver.
    // Brings them in order.
    HWY_INLINE PlaneVectors::Before stands_before(const Seen& r, const LightVoteGrid::Traits& traits,
                                                  bool planes, size_t i, VF& dx, VF& dy,
                                                  VF& inverse, hn::Mask<F> nearer) const {
        dx = in_order(dx), dy = in_order(dy);
        // (What is not nearer is at no depth, before nothing.)
        inverse = in_order(hn::IfThenElseZero(nearer, inverse));
        VF beside = inverse;
        if (planes)
            beside = PlaneVectors::beside(dx, dy, inverse, hn::LoadU(f, &traits.rise_x[i]),
                                          hn::LoadU(f, &traits.rise_y[i]));
        auto before = planes_.before(r, dx, dy, inverse, beside);
        before.which = hn::And(before.which, hn::Gt(inverse, hn::Zero(f)));
        return before;
    }

    // What locations ask of entries again and again is worked out once for each. work(i, samples,
    // 1/w) for vectors of entries from the i-th on, row by row.
    template <class Work>
    void each_entry(LightVoteGrid& grid, Work&& work) const {
        const Projection& p = grid.projection;
        grid.traits.grow(p.start[pitch_ * size_t(p.rows)] + lanes);
        for (size_t row = 0; row < size_t(p.rows); ++row) {
            const std::uint32_t* start = p.start.data() + row * pitch_;
            const size_t end = start[p.columns];
            for (size_t i = start[0]; i < end; i += lanes) {
                const EntryVectors entry(&p.entries[i]);
                const VI sample = hn::BitCast(
                    sn, hn::IfThenElseZero(hn::FirstN(un, end - i), in_order(entry.sample())));
                work(i, sample, hn::BitCast(f, in_order(entry.traits())));
            }
        }
    }
    // How entries' planes rise.
    void put_rise(const Hierarchy& h, size_t i, VI sample, VF inverse,
                  LightVoteGrid::Traits& traits) const {
        const auto rise = planes_.own(inverse, hn::GatherIndex(f, h.plane_x.data(), sample),
                                      hn::GatherIndex(f, h.plane_y.data(), sample));
        hn::StoreU(rise.x, f, &traits.rise_x[i]), hn::StoreU(rise.y, f, &traits.rise_y[i]);
    }
    void work_out_hits() {
        if (hits_.plane_x.empty()) return;
        each_entry(s_.hits, [&](size_t i, VI sample, VF inverse) HWY_ATTR {
            put_rise(hits_, i, sample, inverse, s_.hits.traits);
        });
    }
    // Of passes also how deep they get; how far they move a unit of 1/w, as the light is looked at
    // from here and not from where their rays started; and how far what bends may come out beside
    // them.
    void work_out_passes() {
        auto& traits = s_.passes.traits;
        const bool planes = !passes_.plane_x.empty(), lens = !passes_.uv.empty();
        const auto* order = reinterpret_cast<const std::int32_t*>(passes_.order.data());
        each_entry(s_.passes, [&](size_t i, VI sample, VF inverse) HWY_ATTR {
            const VF end = hn::GatherIndex(f, passes_.end.data(), sample);
            hn::StoreU(hn::Div(hn::Set(f, 1.0f), end), f, &traits.end[i]);
            if (planes) put_rise(passes_, i, sample, inverse, traits);
            if (!lens) return;
            const VI from = hn::ShiftLeft<1>(hn::GatherIndex(sn, order, sample));
            const VF lx = hn::GatherIndex(f, passes_.uv.view().data(), from),
                     ly = hn::GatherIndex(f, passes_.uv.view().data() + 1, from);
            const VF x = hn::Mul(hn::Set(f, lens_x_), hn::Sub(hn::Set(f, lx_), lx)),
                     y = hn::Mul(hn::Set(f, lens_y_), hn::Sub(hn::Set(f, ly_), ly));
            hn::StoreU(x, f, &traits.way_x[i]), hn::StoreU(y, f, &traits.way_y[i]);
            // Squared, the angle between the rays.
            const VF part = hn::Mul(hn::Set(f, angle_), inverse);
            const VF bulge = hn::GatherIndex(f, passes_.bulge.data(), sample);
            hn::StoreU(hn::Mul(hn::Mul(bulge, hn::Mul(part, part)),
                               hn::Add(hn::Mul(x, x), hn::Mul(y, y))),
                       f, &traits.bulge[i]);
        });
    }

    void ask_passes(size_t k) {
        const size_t l = s_.open[k], first = s_.first_stop[k], last = s_.first_stop[k + 1];
        const Seen r = receiver(l);
        const bool planes = !passes_.plane_x.empty(), lens = !passes_.uv.empty();
        const auto& traits = s_.passes.traits;
        auto& passing = s_.passing;
        size_t count = 0;
        out_.votes[l] += std::uint32_t(each_nearer(
            s_.passes.projection, l, r,
            [&](size_t i, VF dx, VF dy, VF inverse, auto nearer) HWY_ATTR {
                if (first == last) return;
                const auto before = stands_before(r, traits, planes, i, dx, dy, inverse, nearer);
                const Pack pack(before.which);
                passing.grow(count + 2 * lanes);
                pack.store(dx, &passing.x[count]);
                pack.store(dy, &passing.y[count]);
                pack.store(inverse, &passing.inverse[count]);
                const auto keep = [&](const std::vector<float>& from, std::vector<float>& to)
                                      HWY_ATTR { pack.store(hn::LoadU(f, &from[i]), &to[count]); };
                keep(traits.end, passing.end);
                if (lens) {
                    keep(traits.way_x, passing.way_x), keep(traits.way_y, passing.way_y);
                    keep(traits.bulge, passing.bulge);
                }
                count += pack.count;
            }));
        if (count == 0) return;
        // Of the stops the nearest first: most often it decides.
        const size_t nearest = nearest_stop(first, last);
        if (!free_of(nearest, count)) return;
        for (size_t i = first; i < last; ++i)
            if (i != nearest && !free_of(i, count)) return;
        out_.share[l] = 1;
    }
    size_t nearest_stop(size_t first, size_t last) const {
        size_t nearest = first;
        float least = 1e38f;
        for (size_t i = first; i < last; i += lanes) {
            const VF x = hn::LoadU(f, &s_.stops.x[i]), y = hn::LoadU(f, &s_.stops.y[i]);
            const VF d2 = hn::IfThenElse(hn::FirstN(f, last - i),
                                         hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Set(f, 1e38f));
            const VF here = hn::MinOfLanes(f, d2);
            if (!(hn::GetLane(here) < least)) continue;
            least = hn::GetLane(here);
            nearest = i + size_t(__builtin_ctz(bits_of(f, hn::Eq(d2, here))));
        }
        return nearest;
    }

    // Whether one of the passes is free of the surface of a stop, and nearer than it.
    bool free_of(size_t stop, size_t count) const {
        const auto& passing = s_.passing;
        const float x = s_.stops.x[stop], y = s_.stops.y[stop];
        const VF inverse = hn::Set(f, s_.stops.inverse[stop]),
                 far = hn::Set(f, std::sqrt(x * x + y * y)), level = hn::Set(f, level_);
        for (size_t i = 0; i < count; i += lanes) {
            const VF move = hn::Sub(inverse, hn::LoadU(f, &passing.inverse[i])),
                     behind = hn::Sub(inverse, hn::LoadU(f, &passing.end[i]));
            // It goes on well behind the surface; or behind it and was seen to pass it.
            const auto free = hn::Or(hn::Gt(behind, level), hn::And(hn::Gt(behind, hn::Zero(f)),
                                                                    hn::Lt(hn::Abs(move), level)));
            VF px = hn::LoadU(f, &passing.x[i]), py = hn::LoadU(f, &passing.y[i]),
               bulge = hn::Zero(f);
            if (!passes_.uv.empty()) {
                px = hn::Add(px, hn::Mul(move, hn::LoadU(f, &passing.way_x[i])));
                py = hn::Add(py, hn::Mul(move, hn::LoadU(f, &passing.way_y[i])));
                bulge = hn::LoadU(f, &passing.bulge[i]);
            }
            const VF away = hn::Sqrt(hn::Add(hn::Mul(px, px), hn::Mul(py, py)));
            const auto nearer = hn::Lt(hn::Add(away, bulge), far);
            const auto found = hn::And(hn::And(free, nearer), hn::FirstN(f, count - i));
            if (!hn::AllFalse(f, found)) return true;
        }
        return false;
    }

    const Hierarchy &hits_, &passes_;
    const Locations& at_;
    const ShadowQueries& queries_;
    const PlaneVectors planes_;
    LightVoteScratch& s_;
    LightShares& out_;
    float lx_ = 0, ly_ = 0, lens_x_ = 0, lens_y_ = 0, level_ = 0, angle_ = 0;
    float reach_ = 0, cell_ = 0;  // px
    size_t pitch_ = 0;            // of the grid
    size_t stops_ = 0;            // places in `stops`
};

}  // namespace

void light_vote(const Hierarchy& hits, const Hierarchy& passes, const LightView& view,
                const Locations& locations, const ShadowQueries& queries, float bias,
                LightVoteScratch& scratch, LightShares& out) {
    Voting(hits, passes, view, locations, queries, bias, scratch, out).vote();
}

}  // namespace weft::shadows::WEFT_ISA
