// A lens cut into columns, each a rectangle: what makes integrals over any outline, round or with
// blades, sums of products of one over u and one over v.
//   columns  of equal width over u in [-1, 1]; each from the mean of the outline's lower ends there
//            to that of its upper ends, so that areas are kept
#pragma once
#include <array>

#include "adaptive/sheared_weights.h"
#include "samples/samples.h"

namespace weft::adaptive {

inline constexpr size_t lens_columns = 16;

// The lens as uv has it: the unit disc or a polygon in it, before aspect.
struct LensPieces {
    explicit LensPieces(const Lens& lens);
    std::array<Interval, lens_columns> v;  // empty where no part of the lens is
    static constexpr float width = 2.0f / lens_columns;
    static Interval column(size_t k) { return {float(k) * width - 1, float(k + 1) * width - 1}; }
    // work(k, mass) for the columns that an interval of u meets, with what lies of it in each.
    template <class Work>
    static void each_column(Interval u, const GaussianMass& mass, const Work& work) {
        const auto of = [](float at) {
            return size_t(std::clamp((at + 1) / width, 0.0f, float(lens_columns - 1)));
        };
        const size_t last = of(u.b);
        float before = mass(u.a);
        for (size_t k = of(u.a); k <= last; ++k) {
            const float here = mass(k < last ? column(k).b : u.b);
            work(k, here - before);
            before = here;
        }
    }
};

}  // namespace weft::adaptive
