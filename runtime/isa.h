// Which instruction set kernels run with. Kernels are built once a set, each build in a namespace of
// its own (cmake/Families.cmake, weft_kernels); WEFT_PICK chooses among them.
#pragma once
#include <optional>
#include <string_view>

namespace weft {

enum class Isa { v2 = 2, v3 = 3, v4 = 4 };  // x86-64 levels: SSE4.2; AVX2 and FMA; AVX-512

Isa best_isa();           // of this processor
Isa active_isa();         // best_isa() unless pinned
void pin_isa(Isa isa);    // before a run; throws Error if the processor lacks it
std::string_view name_of(Isa isa);                  // "v3"
std::optional<Isa> isa_named(std::string_view name);

}  // namespace weft

// WEFT_PICK(gather)(args...): calls v2::gather, v3::gather or v4::gather.
#define WEFT_PICK(function)                                   \
    (::weft::active_isa() == ::weft::Isa::v4   ? &v4::function \
     : ::weft::active_isa() == ::weft::Isa::v3 ? &v3::function \
                                               : &v2::function)
