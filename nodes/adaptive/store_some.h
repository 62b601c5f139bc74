// Keeps some lanes of a vector. To be included by kernels only (weft_kernels).
#pragma once
#include "filters/simd.h"

namespace weft::adaptive::WEFT_ISA {

// Stores the lanes of `mask` one after another, at `to` and a whole vector on; how many they are.
// In two steps: the one instruction that does both takes some hundred cycles on Zen 4.
template <class D, class M>
HWY_INLINE size_t store_some(kernel::WEFT_ISA::hn::Vec<D> from, M mask, D d,
                             kernel::WEFT_ISA::hn::TFromD<D>* to) {
    namespace hn = hwy::HWY_NAMESPACE;
    hn::StoreU(hn::Compress(from, mask), d, to);
    return hn::CountTrue(d, mask);
}

}  // namespace weft::adaptive::WEFT_ISA
