#include "runtime/isa.h"

#include <fmt/format.h>

#include "graph/error.h"

namespace weft {
namespace {
Isa active = best_isa();
}

Isa best_isa() {
    if (__builtin_cpu_supports("x86-64-v4")) return Isa::v4;
    if (__builtin_cpu_supports("x86-64-v3")) return Isa::v3;
    return Isa::v2;
}

Isa active_isa() { return active; }

void pin_isa(Isa isa) {
    if (isa > best_isa())
        throw Error(fmt::format("this processor has no instruction set '{}'; its best is '{}'", name_of(isa),
                                name_of(best_isa())));
    active = isa;
}

std::string_view name_of(Isa isa) { return isa == Isa::v4 ? "v4" : isa == Isa::v3 ? "v3" : "v2"; }

std::optional<Isa> isa_named(std::string_view name) {
    for (Isa isa : {Isa::v2, Isa::v3, Isa::v4})
        if (name == name_of(isa)) return isa;
    return std::nullopt;
}

}  // namespace weft
