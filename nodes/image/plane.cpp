#include "image/plane.h"

#include <algorithm>

namespace weft {

Plane filtered(const Plane& in, const Taps& along_x, const Taps& along_y, Context& ctx) {
    Plane wide(in.width, in.height), out(in.width, in.height);
    const int rx = int(along_x.size()) / 2, ry = int(along_y.size()) / 2;
    ctx.parallel_rows(in.height, [&](Rows rows) {
        std::vector<float> line(size_t(in.width + 2 * rx));
        for (int y = rows.begin; y < rows.end; ++y) {
            const float* from = in.row(y);
            for (int x = -rx; x < in.width + rx; ++x)
                line[size_t(x + rx)] = from[std::clamp(x, 0, in.width - 1)];
            float* to = wide.row(y);
            std::fill_n(to, in.width, 0.0f);
            for (size_t i = 0; i < along_x.size(); ++i)
                for (int x = 0; x < in.width; ++x) to[x] += along_x[i] * line[size_t(x) + i];
        }
    });
    ctx.parallel_rows(in.height, [&](Rows rows) {
        for (int y = rows.begin; y < rows.end; ++y) {
            float* to = out.row(y);
            std::fill_n(to, in.width, 0.0f);
            for (int j = -ry; j <= ry; ++j) {
                const float* from = wide.row(std::clamp(y + j, 0, in.height - 1));
                const float weight = along_y[size_t(j + ry)];
                for (int x = 0; x < in.width; ++x) to[x] += weight * from[x];
            }
        }
    });
    return out;
}

}  // namespace weft
