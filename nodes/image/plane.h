// Plane: one value a pixel, and separable filters over it. Beyond the edge the edge's pixel
// repeats.
#pragma once
#include <algorithm>
#include <vector>

#include "runtime/context.h"

namespace weft {

template <class T>
struct PlaneOf {
    int width = 0, height = 0;
    std::vector<T> values;
    PlaneOf() = default;
    PlaneOf(int w, int h) : width(w), height(h), values(size_t(w) * size_t(h)) {}
    T* row(int y) { return values.data() + size_t(y) * size_t(width); }
    const T* row(int y) const { return values.data() + size_t(y) * size_t(width); }
};
using Plane = PlaneOf<float>;

// Weights of -radius ... radius.
template <class T>
using TapsOf = std::vector<T>;
using Taps = TapsOf<float>;

// sum of along_x[i] along_y[j] in(x + i, y + j)
template <class T>
PlaneOf<T> filtered(const PlaneOf<T>& in, const TapsOf<T>& along_x, const TapsOf<T>& along_y,
                    Context& ctx) {
    PlaneOf<T> wide(in.width, in.height), out(in.width, in.height);
    const int rx = int(along_x.size()) / 2, ry = int(along_y.size()) / 2;
    ctx.parallel_rows(in.height, [&](Rows rows) {
        std::vector<T> line(size_t(in.width + 2 * rx));
        for (int y = rows.begin; y < rows.end; ++y) {
            const T* from = in.row(y);
            for (int x = -rx; x < in.width + rx; ++x)
                line[size_t(x + rx)] = from[std::clamp(x, 0, in.width - 1)];
            T* to = wide.row(y);
            for (size_t i = 0; i < along_x.size(); ++i)
                for (int x = 0; x < in.width; ++x) to[x] += along_x[i] * line[size_t(x) + i];
        }
    });
    ctx.parallel_rows(in.height, [&](Rows rows) {
        for (int y = rows.begin; y < rows.end; ++y) {
            T* to = out.row(y);
            for (int j = -ry; j <= ry; ++j) {
                const T* from = wide.row(std::clamp(y + j, 0, in.height - 1));
                const T weight = along_y[size_t(j + ry)];
                for (int x = 0; x < in.width; ++x) to[x] += weight * from[x];
            }
        }
    });
    return out;
}

}  // namespace weft
