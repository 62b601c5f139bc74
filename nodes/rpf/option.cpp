// Node types that come with WEFT_RPF: a build without it says so when a graph asks for one.
#include "runtime/registry.h"

namespace weft {
namespace {

[[maybe_unused]] const bool noted = Registry::instance().note_option(
    "WEFT_RPF", {"bilateral-filter", "bilateral-filter-pixels", "build-vectors", "clamp-outliers",
                 "collect-samples", "constant-weights", "dependency-estimate", "neighbourhoods",
                 "show-dependence"});

}  // namespace
}  // namespace weft
