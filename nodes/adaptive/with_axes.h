// A number of axes as a constant, for loops over them to be unrolled.
#pragma once
#include <cstddef>
#include <type_traits>

#include "adaptive/adaptive_tree.h"

namespace weft::adaptive {

// work(std::integral_constant<int, axes>), for 2 to most_axes of them.
template <class Work>
auto with_axes(size_t axes, Work&& work) {
    static_assert(most_axes == 8);
    switch (axes) {
        case 2:
            return work(std::integral_constant<int, 2>{});
        case 3:
            return work(std::integral_constant<int, 3>{});
        case 4:
            return work(std::integral_constant<int, 4>{});
        case 5:
            return work(std::integral_constant<int, 5>{});
        case 6:
            return work(std::integral_constant<int, 6>{});
        case 7:
            return work(std::integral_constant<int, 7>{});
        default:
            return work(std::integral_constant<int, 8>{});
    }
}

}  // namespace weft::adaptive
