#include "shadows/light_vote_kernel.h"

#include <algorithm>
#include <cmath>

#include "light-field/grid_reach.h"
#include "light-field/local_radius.h"
#include "light-field/projected_entries.h"
#include "shadows/planes.h"

namespace weft::shadows::WEFT_ISA {
namespace {
using namespace light_field::WEFT_ISA;

class Voting {
  public:
    Voting(const Hierarchy& h, const LightView& view, const Locations& at,
           const ShadowQueries& queries, float bias, LightVoteScratch& scratch, LightShares& out)
        : h_(h),
          at_(at),
          queries_(queries),
          bias_(bias),
          s_(scratch),
          p_(scratch.projection),
          out_(out) {
        lx_ = at.u[0], ly_ = at.v[0];
        c0x_ = float(view.c0x()), c0y_ = float(view.c0y());
        steepest_ = Planes::steepest / float(view.k);
        px_ = 1 / float(view.k);
        lens_x_ = h.lens.c0 * h.lens.aspect, lens_y_ = h.lens.c0;
        level_ = 1 / std::max({std::abs(lens_x_), std::abs(lens_y_), 1e-30f});
    }

    void vote() {
        const size_t n = at_.size();
        out_.share.assign(n, 1);
        out_.votes.assign(n, 0);
        if (!project()) return;
        for (size_t l = 0; l < n; ++l)
            if (queries_.inverse_depth[l] > 0) vote(l);
    }

  private:
    // Carries the samples that are looked at; false if nothing is asked.
    bool project() {
        const size_t n = at_.size();
        double sum = 0, asked = 0;
        for (size_t l = 0; l < n; ++l) {
            if (!(queries_.inverse_depth[l] > 0)) continue;
            sum += at_.ratio.empty() ? 1.0 : double(at_.ratio[l]);
            ++asked;
        }
        if (asked == 0) return false;
        const float reach = light_field::largest_radius(h_, at_);
        // Cells as wide as most searches want them, but no more of them than there is to do.
        float cell = h_.radius * float(sum / asked);
        const auto cells = [&](float side) {
            return (float(at_.x1 - at_.x0) + 2 * reach + 2 * side) *
                   (float(at_.y1 - at_.y0) + 2 * reach + 2 * side) / (0.5f * side * side);
        };
        constexpr float most_cells = 8192;
        while (cells(cell) > most_cells) cell *= 1.5f;
        light_field::lay_grid(h_, at_.x0, at_.y0, at_.x1, at_.y1, reach, cell, p_);
        const size_t pitch = size_t(p_.columns) + 1;
        for (auto* values : {&s_.first, &s_.across, &s_.rows}) values->resize(n + lanes);
        find_reach(p_, at_.x.data(), at_.y.data(), n, h_.radius,
                   {s_.first.data(), s_.across.data(), s_.rows.data()},
                   at_.ratio.empty() ? nullptr : at_.ratio.data());
        s_.wanted.assign(pitch * size_t(p_.rows) + 4, 0);
        for (size_t l = 0; l < n; ++l) {
            if (!(queries_.inverse_depth[l] > 0)) continue;
            std::uint8_t* row = s_.wanted.data() + s_.first[l];
            for (size_t r = 0; r < s_.rows[l]; ++r, row += pitch)
                std::fill_n(row, s_.across[l], std::uint8_t(1));
        }
        collect(reach + 2 * cell);
        light_field::WEFT_ISA::project_depths(h_, s_.block, s_.wanted.data(), lx_, ly_, at_.t[0],
                                              p_);
        return true;
    }

    // The groups that may be seen around the batch. Other slices of the same pixels look at much
    // the same of the film, so some more than needed serves these, too.
    void collect(float reach) {
        light_field::Block& block = s_.block;
        const int far = int(std::ceil(reach));
        const int x0 = at_.x0 - far, y0 = at_.y0 - far, x1 = at_.x1 + far, y1 = at_.y1 + far;
        if (block.hierarchy == &h_ && block.x0 <= x0 && block.y0 <= y0 && block.x1 >= x1 &&
            block.y1 >= y1 &&
            double(block.x1 - block.x0) * double(block.y1 - block.y0) <
                2.0 * double(x1 - x0) * double(y1 - y0))
            return;
        const int more_x = (x1 - x0) / 16, more_y = (y1 - y0) / 16;
        light_field::collect(h_, x0 - more_x, y0 - more_y, x1 + more_x, y1 + more_y, 0, block);
    }

    void vote(size_t l) {
        const float ratio = at_.ratio.empty() ? 1.0f : at_.ratio[l], radius = h_.radius * ratio;
        const float inverse = queries_.inverse_depth[l];
        const Slope slope = seen_slope(queries_.slope_x[l], queries_.slope_y[l]);
        const VF limit = hn::Set(f, radius * radius), x = hn::Set(f, at_.x[l]),
                 y = hn::Set(f, at_.y[l]);
        const VF plane = hn::Set(f, inverse + bias_ * inverse), rise_x = hn::Set(f, slope.x),
                 rise_y = hn::Set(f, slope.y);
        const size_t pitch = size_t(p_.columns) + 1, across = s_.across[l];
        const std::uint32_t* row = p_.start.data() + s_.first[l];
        const std::uint32_t* last = row + s_.rows[l] * pitch;
        size_t votes = 0;
        n_ = 0;
        for (; row != last; row += pitch) {
            const size_t end = row[across];
            for (size_t i = row[0]; i < end; i += lanes) {
                const EntryVectors entry(&p_.entries[i]);
                const VF dx = hn::Sub(entry.x(), x), dy = hn::Sub(entry.y(), y);
                const auto in = hn::Lt(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), limit);
                votes += hn::CountTrue(f, in);
                const VF depth = hn::BitCast(f, entry.traits());
                const VF here = hn::Add(plane, hn::Add(hn::Mul(rise_x, dx), hn::Mul(rise_y, dy)));
                const auto nearer = hn::And(in, hn::Lt(here, depth));
                if (hn::AllFalse(f, nearer)) continue;
                s_.nearer.grow(n_ + 2 * lanes);
                const Pack pack(nearer);
                pack.store(dx, &s_.nearer.x[n_]);
                pack.store(dy, &s_.nearer.y[n_]);
                pack.store(depth, &s_.nearer.inverse[n_]);
                pack.store(entry.sample(), &s_.nearer.sample[n_]);
                n_ += pack.count;
            }
        }
        out_.votes[l] = std::uint32_t(votes);
        if (n_ > 0 && stopped(inverse, slope)) out_.share[l] = 0;
    }

    // The receiver's own slope as it is from the light's point.
    Slope seen_slope(float hx, float hy) const {
        const float divisor = 1 + c0x_ * hx * lx_ + c0y_ * hy * ly_;
        if (!(std::abs(divisor) >= 0.1f)) return {};
        return {hx / divisor, hy / divisor};
    }

    // Whether one of those that are nearer than the receiver's plane stops its light.
    bool stopped(float receiver, const Slope& slope) {
        auto &hits = s_.hits, &passes = s_.passes;
        hits.grow(n_ + 2 * lanes);
        passes.grow(n_ + 2 * lanes);
        size_t n_hits = 0, n_passes = 0;
        const bool planes = !h_.plane_x.empty(), ends = !h_.end.empty();
        const VF one = hn::Set(f, 1.0f), zero = hn::Zero(f), rise_x = hn::Set(f, slope.x),
                 rise_y = hn::Set(f, slope.y);
        for (size_t i = 0; i < n_; i += lanes) {
            const auto valid = hn::FirstN(f, n_ - i);
            const VF dx = hn::LoadU(f, &s_.nearer.x[i]), dy = hn::LoadU(f, &s_.nearer.y[i]),
                     inverse = hn::LoadU(f, &s_.nearer.inverse[i]);
            const VU sample =
                hn::IfThenElseZero(hn::RebindMask(un, valid), hn::LoadU(un, &s_.nearer.sample[i]));
            const VI at = hn::BitCast(sn, sample);
            VF beside = inverse;
            if (planes) {
                // Planes::own.
                const VF hx = hn::GatherIndex(f, h_.plane_x.data(), at),
                         hy = hn::GatherIndex(f, h_.plane_y.data(), at);
                const VF turn =
                    hn::Add(hn::Add(one, hn::Mul(hn::Mul(hn::Set(f, c0x_), hx), hn::Set(f, lx_))),
                            hn::Mul(hn::Mul(hn::Set(f, c0y_), hy), hn::Set(f, ly_)));
                const VF divisor = hn::Max(turn, hn::Set(f, 1e-6f));
                const VF steep =
                    hn::Div(hn::Sqrt(hn::Add(hn::Mul(hx, hx), hn::Mul(hy, hy))), divisor);
                const VF most = hn::Mul(hn::Set(f, steepest_), inverse);
                const VF scale = hn::Div(
                    hn::IfThenElse(hn::Gt(steep, most), hn::Div(most, steep), one), divisor);
                beside = hn::Sub(inverse, hn::Add(hn::Mul(hn::Mul(hx, scale), dx),
                                                  hn::Mul(hn::Mul(hy, scale), dy)));
            }
            // Planes::before.
            const VF bend = hn::Mul(hn::Set(f, px_),
                                    hn::Sqrt(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)))),
                     limit = hn::Add(hn::Set(f, receiver), hn::Mul(hn::Add(hn::Set(f, bias_), bend),
                                                                   hn::Set(f, receiver)));
            const VF here = hn::Add(limit, hn::Add(hn::Mul(rise_x, dx), hn::Mul(rise_y, dy)));
            const auto before =
                hn::And(valid, hn::And(hn::Lt(here, inverse), hn::Lt(limit, beside)));
            const VF end = ends ? hn::GatherIndex(f, h_.end.data(), at) : zero;
            const auto pass = hn::Gt(end, zero);
            const Pack stop(hn::AndNot(pass, before)), by(hn::And(pass, before));
            stop.store(dx, &hits.x[n_hits]);
            stop.store(dy, &hits.y[n_hits]);
            stop.store(beside, &hits.inverse[n_hits]);
            n_hits += stop.count;
            by.store(dx, &passes.x[n_passes]);
            by.store(dy, &passes.y[n_passes]);
            by.store(inverse, &passes.inverse[n_passes]);
            by.store(hn::Div(one, end), &passes.end[n_passes]);
            by.store(sample, &passes.sample[n_passes]);
            n_passes += by.count;
        }
        if (n_hits == 0) return false;
        if (n_passes == 0) return true;
        find_ways(n_passes);
        // Of the hits the nearest first: most often it decides.
        size_t first = 0;
        float least = 1e38f;
        for (size_t i = 0; i < n_hits; ++i)
            if (const float d2 = hits.x[i] * hits.x[i] + hits.y[i] * hits.y[i]; d2 < least)
                least = d2, first = i;
        if (!free_of(first, n_passes)) return true;
        for (size_t i = 0; i < n_hits; ++i)
            if (i != first && !free_of(i, n_passes)) return true;
        return false;
    }

    // How far passes move a unit of 1/w, as the light is looked at from here and not from where
    // their rays started.
    void find_ways(size_t n_passes) {
        if (h_.uv.empty()) return;
        auto& passes = s_.passes;
        const auto* order = reinterpret_cast<const std::int32_t*>(h_.order.data());
        for (size_t i = 0; i < n_passes; i += lanes) {
            const VU sample =
                hn::IfThenElseZero(hn::FirstN(un, n_passes - i), hn::LoadU(un, &passes.sample[i]));
            const VI from = hn::ShiftLeft<1>(hn::GatherIndex(sn, order, hn::BitCast(sn, sample)));
            const VF lx = hn::GatherIndex(f, h_.uv.view().data(), from),
                     ly = hn::GatherIndex(f, h_.uv.view().data() + 1, from);
            hn::StoreU(hn::Mul(hn::Set(f, lens_x_), hn::Sub(hn::Set(f, lx_), lx)), f,
                       &passes.way_x[i]);
            hn::StoreU(hn::Mul(hn::Set(f, lens_y_), hn::Sub(hn::Set(f, ly_), ly)), f,
                       &passes.way_y[i]);
        }
    }

    // Whether one of the passes is free of the surface of a hit, and nearer than it.
    bool free_of(size_t hit, size_t n_passes) const {
        const auto& passes = s_.passes;
        const float x = s_.hits.x[hit], y = s_.hits.y[hit];
        const VF inverse = hn::Set(f, s_.hits.inverse[hit]), far = hn::Set(f, x * x + y * y),
                 level = hn::Set(f, level_);
        for (size_t i = 0; i < n_passes; i += lanes) {
            const VF move = hn::Sub(inverse, hn::LoadU(f, &passes.inverse[i])),
                     behind = hn::Sub(inverse, hn::LoadU(f, &passes.end[i]));
            // It goes on well behind the surface; or behind it and was seen to pass it.
            const auto free = hn::Or(hn::Gt(behind, level), hn::And(hn::Gt(behind, hn::Zero(f)),
                                                                    hn::Lt(hn::Abs(move), level)));
            VF px = hn::LoadU(f, &passes.x[i]), py = hn::LoadU(f, &passes.y[i]);
            if (!h_.uv.empty()) {
                px = hn::Add(px, hn::Mul(move, hn::LoadU(f, &passes.way_x[i])));
                py = hn::Add(py, hn::Mul(move, hn::LoadU(f, &passes.way_y[i])));
            }
            const auto nearer = hn::Lt(hn::Add(hn::Mul(px, px), hn::Mul(py, py)), far);
            const auto found = hn::And(hn::And(free, nearer), hn::FirstN(f, n_passes - i));
            if (!hn::AllFalse(f, found)) return true;
        }
        return false;
    }

    const Hierarchy& h_;
    const Locations& at_;
    const ShadowQueries& queries_;
    const float bias_;
    LightVoteScratch& s_;
    Projection& p_;
    LightShares& out_;
    float lx_ = 0, ly_ = 0, c0x_ = 0, c0y_ = 0, steepest_ = 0, px_ = 0, lens_x_ = 0, lens_y_ = 0,
          level_ = 0;
    size_t n_ = 0;  // samples nearer than its plane
};

}  // namespace

void light_vote(const Hierarchy& lights, const LightView& view, const Locations& at,
                const ShadowQueries& queries, float bias, LightVoteScratch& scratch,
                LightShares& out) {
    Voting(lights, view, at, queries, bias, scratch, out).vote();
}

}  // namespace weft::shadows::WEFT_ISA
