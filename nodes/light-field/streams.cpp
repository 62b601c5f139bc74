#include "light-field/streams.h"

namespace weft {
namespace {

template <class T>
std::span<const T> head(const std::vector<T>& values, size_t n) {
    return std::span<const T>(values).first(std::min(n, values.size()));
}

// What FieldVisitor has no kind of field for.
template <class T>
std::vector<std::uint32_t> whole_numbers(const std::vector<T>& values, size_t n) {
    std::vector<std::uint32_t> out;
    for (size_t i = 0; i < std::min(n, values.size()); ++i) out.push_back(std::uint32_t(values[i]));
    return out;
}

// One value a record, of values that may be shared.
std::vector<float> spread_out(const std::vector<float>& values, bool shared, size_t n) {
    if (!shared) return {values.begin(), values.begin() + std::ptrdiff_t(std::min(n, values.size()))};
    return std::vector<float>(n, values.empty() ? 0.0f : values[0]);
}

}  // namespace

void Locations::describe(FieldVisitor& see) const {
    const size_t n = size();
    see.field("x", head(x, n));
    see.field("y", head(y, n));
    see.field("u", spread_out(u, shared, n));
    see.field("v", spread_out(v, shared, n));
    see.field("t", spread_out(t, shared, n));
}

void Projection::describe(FieldVisitor& see) const {
    const size_t n = size();
    see.field("u", std::vector<float>(n, u));
    see.field("v", std::vector<float>(n, v));
    see.field("t", std::vector<float>(n, t));
    see.field("projected", std::vector<std::uint32_t>(n, std::uint32_t(samples)));
}

Trajectory Candidates::trajectory(size_t l, size_t k) const {
    const Hierarchy& h = *hierarchy;
    const size_t i = offset[l] + k, j = sample[i];
    const float d = t_of(l) - 0.5f;
    Trajectory out;
    const auto [VX, VY, VW] = h.velocity(j);
    out.depth = h.W[j] + d * VW;
    out.slope_y = h.lens.c0 / out.depth + h.lens.c1;
    out.slope_x = out.slope_y * h.lens.aspect;
    if (h.moving) {
        // d/dt of (X + d VX) / w + (C0 / w + C1) u with w = W + d VW, by what it is at the location.
        out.velocity_x = (VX - VW * (x[l] + dx[i] - h.lens.c1 * h.lens.aspect * u_of(l))) / out.depth;
        out.velocity_y = (VY - VW * (y[l] + dy[i] - h.lens.c1 * v_of(l))) / out.depth;
    }
    return out;
}

void Candidates::describe(FieldVisitor& see) const {
    const size_t n = size(), all = n ? offset[n] : 0;
    see.field("x", head(x, n));
    see.field("y", head(y, n));
    see.children("candidates", head(offset, n + 1));
    see.field("dx", head(dx, all));
    see.field("dy", head(dy, all));
    std::vector<std::uint32_t> index(all);
    std::vector<float> depth, slope, velocity;
    for (size_t l = 0; l < n; ++l)
        for (size_t k = 0; k < of(l); ++k) {
            const Trajectory path = trajectory(l, k);
            index[offset[l] + k] = hierarchy->order[sample[offset[l] + k]];
            depth.push_back(path.depth);
            slope.insert(slope.end(), {path.slope_x, path.slope_y});
            velocity.insert(velocity.end(), {path.velocity_x, path.velocity_y});
        }
    see.field("sample", index);
    see.field("depth", depth);
    see.field("slope", slope, 2);
    see.field("velocity", velocity, 2);
}

void Surfaces::describe(FieldVisitor& see) const {
    see.field("count", whole_numbers(count_of, size()));
}

void Visibility::describe(FieldVisitor& see) const {
    see.field("first", whole_numbers(first, size()));
    see.field("last", whole_numbers(last, size()));
    see.field("decision", whole_numbers(decision, size()));
}

void Colors::describe(FieldVisitor& see) const {
    see.field("rgba", head(rgba, 4 * size()), 4);
    see.field("valid", whole_numbers(valid, size()));
}

}  // namespace weft
