#include "runtime/isa.h"

#include <fmt/format.h>

#include "graph/error.h"

namespace weft {
namespace {
Isa active = best_isa();
}

// By what a level adds and not by its name, which clang 14 does not know. No processor has these
// and lacks the rest of its level (f16c, lzcnt, movbe).
Isa best_isa() {
    const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                    __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
    const bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                    __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                    __builtin_cpu_supports("avx512vl");
    return v4 ? Isa::v4 : v3 ? Isa::v3 : Isa::v2;
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
