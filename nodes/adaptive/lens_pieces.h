// A lens cut into columns, each a rectangle: what makes integrals over any outline, round or with
// blades, sums of products of one over u and one over v.
//   columns  of equal width over u; each from the mean of the outline's lower ends there to that of
//            its upper ends. All are shifted and stretched a little, along u and along v, so that
//            means and variances are the lens's own: what few columns do to a picture is of the
//            fourth order in their width, then
#pragma once
#include <array>

#include "adaptive/sheared_weights.h"
#include "samples/samples.h"

namespace weft::adaptive {

inline constexpr size_t lens_columns = 16;  // at most

// The lens as uv has it: the unit disc or a polygon in it, before aspect.
struct LensPieces {
    LensPieces(const Lens& lens, size_t columns);
    size_t columns;
    std::array<Interval, lens_columns> v;
    float first = -1, width = 0, per_unit = 0;  // over u
    Interval column(size_t k) const {
        return {first + float(k) * width, first + float(k + 1) * width};
    }
    Interval across() const { return {first, first + float(columns) * width}; }
    // work(k, mass) for the columns that an interval of u meets, with what lies of it in each.
    template <class Work>
    void each_column(Interval u, const GaussianMass& mass, const Work& work) const {
        u = u.in(across());
        if (u.empty()) return;
        const auto of = [this](float at) {
            return std::clamp(int((at - first) * per_unit), 0, int(columns) - 1);
        };
        const int last = of(u.b);
        float before = mass(u.a);
        for (int k = of(u.a); k <= last; ++k) {
            const float here = mass(k < last ? column(size_t(k)).b : u.b);
            work(size_t(k), here - before);
            before = here;
        }
    }
};

// What on the film is as good as one place: px.
inline constexpr float narrow_on_film = 0.67f;

// Of a lens, the pieces that a circle of confusion asks for: columns that are narrow on the film,
// as far as there are.
class LensCuts {
  public:
    explicit LensCuts(const Lens& lens)
        : of_{{{lens, 1}, {lens, 3}, {lens, 8}, {lens, lens_columns}}} {}
    const LensPieces& operator()(float coc) const {
        for (const LensPieces& pieces : of_)
            if (std::abs(coc) * pieces.width < narrow_on_film) return pieces;
        return of_.back();
    }

  private:
    std::array<LensPieces, 4> of_;
};

}  // namespace weft::adaptive
