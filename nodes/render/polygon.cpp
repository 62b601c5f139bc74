#include "render/polygon.h"

namespace weft {

std::vector<std::array<int, 3>> triangulated(std::span<const Vec3> points) {
    std::vector<std::array<int, 3>> all;
    const int n = int(points.size());
    if (n < 3) return all;
    if (n == 3) return {{0, 1, 2}};
    Vec3 normal{};  // Newell's: twice the area's vector, whatever the polygon's bends
    for (int i = 0; i < n; ++i)
        normal += cross(points[size_t(i)] - points[0], points[size_t((i + 1) % n)] - points[0]);
    const auto turn = [&](int a, int b, int c) {
        const Vec3 p = points[size_t(a)];
        return dot(normal, cross(points[size_t(b)] - p, points[size_t(c)] - p));
    };
    std::vector<int> left(size_t(n), 0);
    for (int i = 0; i < n; ++i) left[size_t(i)] = i;
    size_t at = 0, tried = 0;
    while (left.size() > 3 && tried < left.size()) {
        const size_t m = left.size();
        const int a = left[(at + m - 1) % m], b = left[at % m], c = left[(at + 1) % m];
        bool ear = turn(a, b, c) > 0;
        for (size_t i = 0; i < m && ear; ++i) {
            const int p = left[i];
            if (p == a || p == b || p == c) continue;
            ear = !(turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0);
        }
        if (!ear) {
            at = (at + 1) % m;
            ++tried;
            continue;
        }
        all.push_back({a, b, c});
        left.erase(left.begin() + std::ptrdiff_t(at % m));
        at %= left.size();
        tried = 0;
    }
    for (size_t i = 1; i + 1 < left.size(); ++i) all.push_back({left[0], left[i], left[i + 1]});
    return all;
}

}  // namespace weft
