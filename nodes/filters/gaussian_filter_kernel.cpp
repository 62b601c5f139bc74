#include "filters/gaussian_filter_kernel.h"

#include <algorithm>

#include "filters/simd.h"

namespace weft::kernel::WEFT_ISA {
namespace {

// to[i] = sum of taps[k] at(k)[i] for i below n, rounded up to `at_once` vectors.
template <class At>
HWY_INLINE void weighted_sums(std::span<const float> taps, size_t n, const At& at, float* to) {
    for (size_t i = 0; i < n; i += at_once * lanes) {
        VF sums[at_once];
        for (VF& sum : sums) sum = hn::Zero(f);
        for (size_t k = 0; k < taps.size(); ++k) {
            const VF tap = hn::Set(f, taps[k]);
            const float* from = at(k) + i;
            for (size_t v = 0; v < at_once; ++v)
                sums[v] = hn::MulAdd(tap, hn::LoadU(f, from + v * lanes), sums[v]);
        }
        for (size_t v = 0; v < at_once; ++v) hn::StoreU(sums[v], f, to + i + v * lanes);
    }
}

}  // namespace

void gaussian_rows(const Planes& in, int count, std::span<const float> taps, int begin, int end,
                   Planes& out) {
    const int radius = int(taps.size()) / 2;
    const auto width = size_t(in.width), spare = at_once * lanes;
    std::vector<float> line(width + taps.size() + 2 * spare), sums(width + spare), total(width);
    for (int y = begin; y < end; ++y) {
        const int above = std::min(radius, y), below = std::min(radius, in.height - 1 - y);
        const auto down = taps.subspan(size_t(radius - above), size_t(above + below + 1));
        // The weights' plane first: the others are divided by it.
        for (int plane = count; plane >= 0; --plane) {
            float* middle = line.data() + radius;
            weighted_sums(
                down, width, [&](size_t k) { return in.row(plane, y - above + int(k)); }, middle);
            std::fill(middle + width, middle + width + size_t(radius) + spare, 0.0f);
            weighted_sums(
                taps, width, [&](size_t k) { return line.data() + k; }, sums.data());
            float* to = out.row(plane, y);
            if (plane == count) std::copy_n(sums.data(), width, total.data());
            for (size_t x = 0; x < width; ++x)
                to[x] = plane == count ? total[x] : total[x] > 0 ? sums[x] / total[x] : 0.0f;
        }
    }
}

}  // namespace weft::kernel::WEFT_ISA
