// Which cells of a projection's grid hold the samples near a location. For kernels (weft_kernels).
#pragma once
#include <algorithm>

#include "light-field/kernels.h"
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {

// The cells that disks about n locations reach into; of a radius that is `radius` times each one's
// ratio, where there are ratios. `to` has room for whole vectors.
inline void find_reach(const Projection& p, const float* x, const float* y, size_t n, float radius,
                       Reach to, const float* ratio = nullptr) {
    const VF per_width = hn::Set(f, 1 / p.cell_width), per_height = hn::Set(f, 1 / p.cell_height);
    const VI pitch = hn::Set(sn, p.columns + 1), one = hn::Set(sn, 1);
    const auto cell = [](VF at, VF per_cell, int first, int count) HWY_ATTR {
        const VI i =
            hn::Sub(hn::ConvertTo(sn, hn::Floor(hn::Mul(at, per_cell))), hn::Set(sn, first));
        return hn::Min(hn::Max(i, hn::Zero(sn)), hn::Set(sn, count - 1));
    };
    for (size_t i = 0; i < n; i += lanes) {
        const auto load = [&](const float* from) HWY_ATTR {
            if (i + lanes <= n) return hn::LoadU(f, from + i);
            alignas(64) float rest[lanes] =
                {};  // (MaskedLoad reads whole vectors where masks are emulated.)
            std::copy(from + i, from + n, rest);
            return hn::Load(f, rest);
        };
        const VF px = load(x), py = load(y);
        const VF own = ratio ? hn::Mul(hn::Set(f, radius), load(ratio)) : hn::Set(f, radius);
        // Cells are chosen by rounded numbers.
        const VF far = hn::MulAdd(own, hn::Set(f, 1.00001f), hn::Set(f, 1e-5f));
        const VI left = cell(hn::Sub(px, far), per_width, p.column0, p.columns),
                 right = cell(hn::Add(px, far), per_width, p.column0, p.columns),
                 top = cell(hn::Sub(py, far), per_height, p.row0, p.rows),
                 bottom = cell(hn::Add(py, far), per_height, p.row0, p.rows);
        const auto put = [i](VI value, std::uint32_t* at)
                             HWY_ATTR { hn::StoreU(hn::BitCast(un, value), un, at + i); };
        put(hn::Add(hn::Mul(top, pitch), left), to.first);
        put(hn::Add(hn::Sub(right, left), one), to.across);
        put(hn::Add(hn::Sub(bottom, top), one), to.rows);
    }
}

}  // namespace weft::light_field::WEFT_ISA
