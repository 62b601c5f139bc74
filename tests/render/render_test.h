// Small scenes in code, and one call that renders them.
#pragma once
#include <gtest/gtest.h>

#include <cmath>

#include "render/affine.h"
#include "render/sample_buffer.h"

namespace weft::render {

inline Material diffuse(float albedo) {
    Material m;
    m.kind = Material::Kind::diffuse;
    m.base_color = {albedo, albedo, albedo};
    return m;
}

// A square of half width `size` in the x-z plane, looking up.
inline Mesh floor_mesh(float size, int material = 0) {
    Mesh mesh;
    mesh.positions = {{-size, 0, -size}, {-size, 0, size}, {size, 0, size}, {size, 0, -size}};
    mesh.uv = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.material = material;
    return mesh;
}

// A ball of unit radius, of `rings` x 2 rings quads, with smooth normals where asked for.
inline Mesh ball_mesh(int rings, bool smooth, int material = 0) {
    Mesh mesh;
    const int around = 2 * rings;
    for (int i = 0; i <= rings; ++i)
        for (int j = 0; j <= around; ++j) {
            const float theta = pi * float(i) / float(rings),
                        phi = 2 * pi * float(j) / float(around);
            mesh.positions.push_back({std::sin(theta) * std::cos(phi), std::cos(theta),
                                      std::sin(theta) * std::sin(phi)});
        }
    if (smooth) mesh.normals = mesh.positions;
    const auto at = [&](int i, int j) { return std::uint32_t(i * (around + 1) + j); };
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < around; ++j) {
            if (i > 0) mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            if (i + 1 < rings)
                mesh.triangles.push_back({at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)});
        }
    mesh.material = material;
    for (Vec3& n : mesh.normals) n = unit(n);
    return mesh;
}

inline Instance placed(int mesh, std::vector<Affine> keys = {Affine{}}, std::uint32_t id = 1) {
    Instance instance;
    instance.mesh = mesh;
    instance.to_world = std::move(keys);
    instance.id = id;
    return instance;
}

inline SceneCamera camera_at(Vec3 eye, Vec3 target, float fov_degrees, Vec3 up = {0, 1, 0}) {
    SceneCamera camera;
    camera.to_world = {look_at(eye, target, up)};
    camera.vertical_fov = radians(fov_degrees);
    camera.focus = length(target - eye);
    return camera;
}

inline Samples render_scene(const Scene& scene, RenderOptions options, int spp,
                            std::vector<std::string> channels, Context* given = nullptr,
                            float* deviation = nullptr) {
    PlainContext plain;
    Context& ctx = given ? *given : plain;
    options.channels = channel_set(channels, scene.camera.lens_radius > 0, true);
    const PathTracer tracer(scene, options, ctx);
    const SamplePlan plan(options.width, options.height, spp);
    RenderWorkers workers(tracer);
    ChannelArrays arrays;
    arrays.resize(options.channels, plan.samples());
    render_rows(tracer, plan, 0, plan.height(), 0, workers, arrays, ctx);
    Samples samples = empty_samples(tracer, plan);
    give_channels(options.channels, std::move(arrays), samples);
    if (deviation) *deviation = tracer.largest_deviation();
    return samples;
}

// Mean of a channel's first component and its standard error, over all samples.
struct Estimate {
    double mean = 0, error = 0;
};
inline Estimate estimate(std::span<const float> values, size_t components = 1) {
    double sum = 0, squares = 0;
    const double n = double(values.size() / components);
    for (size_t i = 0; i < values.size(); i += components) {
        sum += double(values[i]);
        squares += double(values[i]) * double(values[i]);
    }
    const double mean = sum / n;
    return {mean, std::sqrt(std::max(squares / n - mean * mean, 0.0) / n)};
}

}  // namespace weft::render
