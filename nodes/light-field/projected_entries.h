// The entries of a projection as vectors. For kernels (weft_kernels).
#pragma once
#include "light-field/record_vectors.h"
#include "light-field/streams.h"

namespace weft::light_field::WEFT_ISA {

// As many entries as there are lanes, in the order of RecordVectors.
class EntryVectors {
  public:
    HWY_INLINE explicit EntryVectors(const Projection::Entry* from) : of_(&from->x) {}
    HWY_INLINE VF x() const { return of_.first(); }
    HWY_INLINE VF y() const { return of_.second(); }
    HWY_INLINE VU sample() const { return hn::BitCast(un, of_.third()); }
    HWY_INLINE VU traits() const { return hn::BitCast(un, of_.fourth()); }

  private:
    RecordVectors of_;
};

}  // namespace weft::light_field::WEFT_ISA
