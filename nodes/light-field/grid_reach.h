// Which cells of a projection's grid hold the samples near a location. For kernels (weft_kernels).
#pragma once
#include <algorithm>

#include "light-field/kernels.h"
#include "light-field/simd.h"

namespace weft::light_field::WEFT_ISA {

// Cells that a disk reaches into: rows [top, bottom], columns [left, right].
struct Reach {
    static constexpr size_t at_once = 64;
    alignas(64) std::int32_t left[at_once], right[at_once], top[at_once], bottom[at_once];

    void find(const Projection& p, const float* x, const float* y, size_t n, float radius) {
        const VF far =
            hn::Set(f, radius * 1.00001f + 1e-5f);  // cells are chosen by rounded numbers
        const VF per_width = hn::Set(f, 1 / p.cell_width),
                 per_height = hn::Set(f, 1 / p.cell_height);
        const auto cell = [](VF at, VF per_cell, int first, int count) {
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
            hn::Store(cell(hn::Sub(px, far), per_width, p.column0, p.columns), sn, left + i);
            hn::Store(cell(hn::Add(px, far), per_width, p.column0, p.columns), sn, right + i);
            hn::Store(cell(hn::Sub(py, far), per_height, p.row0, p.rows), sn, top + i);
            hn::Store(cell(hn::Add(py, far), per_height, p.row0, p.rows), sn, bottom + i);
        }
    }
};

}  // namespace weft::light_field::WEFT_ISA
