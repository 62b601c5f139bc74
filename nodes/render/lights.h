// Lights: everything that shines in a scene, and one point of it drawn at a time.
//   order     scene.lights as they stand, then instances of emitting materials, then the
//   environment:
//             a light's place in it is the `light_index` of samples
//   choice    by power (area times radiance); where there are lights at a distance and lights
//             infinitely far, half of the samples go to either
//   densities with respect to solid angle, the choice of the light included
// A point of a quad is l = 2 (a, b) - 1 of its half extents, of a disc by the concentric map, of a
// sphere uniform in the cone that is seen; of a mesh a triangle by its emission, uniform in it.
#pragma once
#include <span>
#include <vector>

#include "render/environment.h"
#include "render/ray_scene.h"
#include "render/textures.h"

namespace weft::render {

struct LightSample {
    Vec3 direction;
    float distance = 0;  // +inf: from infinitely far
    Vec3 radiance;       // that arrives, before what stands between; of a mesh: its factor alone
    float density = 0;   // 0: nothing
    bool delta = false;  // cannot be hit by chance
    std::uint32_t light = 0;
    // Of an emitting mesh: where, for its emission map.
    std::uint32_t object = no_object, primitive = 0;
    float u = 0, v = 0;
};

class Lights {
  public:
    // `textures` may be null: maps then count as white.
    Lights(const RayScene& rays, const Textures* textures);

    bool empty() const { return chosen_.empty(); }
    size_t size() const { return lights_.size(); }
    const EnvironmentLight& environment() const { return environment_; }
    std::uint32_t environment_index() const { return std::uint32_t(lights_.size() - 1); }

    LightSample sample(Vec3 from, float time, float choice, float a, float b) const;
    // Density with which sample() draws this point of a light's object, seen from `from`.
    float density(Vec3 from, float time, std::uint32_t object, std::uint32_t primitive, float u,
                  float v) const;
    float environment_density(Vec3 direction) const;
    // What leaves a visible light's object at its bright side.
    Vec3 radiance(std::uint32_t object) const { return lights_[light_of_[object]].radiance; }
    bool is_light(std::uint32_t object) const { return light_of_[object] != no_object; }
    // Of a light that is an emitting mesh: its object, and what part of its light the triangles up
    // to each send out (one more than there are triangles, from 0 to 1). no_object: not a mesh.
    std::uint32_t mesh_object(size_t light) const { return lights_[light].object; }
    std::span<const float> triangle_sums(size_t light) const { return lights_[light].sums; }

  private:
    enum class Kind { quad, disc, sphere, point, spot, directional, mesh, environment, off };
    struct One {
        Kind kind = Kind::off;
        Vec3 radiance;
        Placement placement;
        float inner = 1, outer = 1;        // spot: cosines
        std::uint32_t object = no_object;  // mesh
        std::vector<float> sums;           // mesh: triangles + 1, ends at 1
        float probability = 0, power = 0;
        bool unseen = false;  // has no surface that a ray could hit
        bool two_sided = false;
    };
    void add_mesh(const RayScene& rays, std::uint32_t object, const Textures* textures);
    void choose();

    const RayScene& rays_;
    std::vector<One> lights_;
    std::vector<std::uint32_t> light_of_;  // of objects
    std::vector<std::uint32_t> chosen_;    // lights that can be chosen
    std::vector<float> sums_;              // of their probabilities, ends at 1
    EnvironmentLight environment_;
};

}  // namespace weft::render
