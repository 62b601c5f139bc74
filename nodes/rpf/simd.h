// Vectors of the instruction set this file is compiled for. To be included by kernels only
// (weft_kernels).
#pragma once
#include "filters/simd.h"

namespace weft::rpf::WEFT_ISA {
namespace hn = hwy::HWY_NAMESPACE;
using kernel::WEFT_ISA::exp_of_minus;
using kernel::WEFT_ISA::f;
using kernel::WEFT_ISA::F;
using kernel::WEFT_ISA::lanes;
using kernel::WEFT_ISA::VF;

HWY_INLINE float sum_of(VF v) {
    return hn::GetLane(hn::SumOfLanes(f, v));
}
}  // namespace weft::rpf::WEFT_ISA
