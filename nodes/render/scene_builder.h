// SceneBuilder: puts a scene together piece by piece; gives every instance its id.
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "render/affine.h"
#include "render/scene.h"
#include "samples/random.h"

namespace weft {

class SceneBuilder {
  public:
    Scene scene;

    int material(Material material) {
        scene.materials.push_back(std::move(material));
        return int(scene.materials.size()) - 1;
    }
    int mesh(Mesh mesh, int material, std::string name) {
        mesh.material = material;
        mesh.name = std::move(name);
        scene.meshes.push_back(std::move(mesh));
        return int(scene.meshes.size()) - 1;
    }
    Instance& place(int mesh, std::vector<Affine> to_world, int material = -1) {
        Instance instance;
        instance.name = scene.meshes[size_t(mesh)].name;
        instance.mesh = mesh, instance.material = material;
        instance.to_world = std::move(to_world);
        instance.id = std::uint32_t(scene.instances.size() + 1);
        scene.instances.push_back(std::move(instance));
        return scene.instances.back();
    }
    Instance& place(int mesh, const Affine& to_world, int material = -1) {
        return place(mesh, std::vector<Affine>{to_world}, material);
    }
    // A rectangle of half extents (a, b) at `at` that shines towards `target`.
    Light& quad_light(std::string name, Vec3 at, Vec3 target, float a, float b, Vec3 radiance) {
        Light light;
        light.name = std::move(name);
        light.radiance = radiance;
        light.to_world = {look_at(at, target) * scale({a, b, 1})};
        scene.lights.push_back(std::move(light));
        return scene.lights.back();
    }
    // A picture made of a function (u right, v down, in [0, 1]) to linear RGB; 8 bit sRGB.
    int texture(const std::string& name, int width, int height,
                const std::function<Vec3(float u, float v)>& color);
    // A sky by direction (unit, world).
    void sky(const std::function<Vec3(Vec3)>& radiance);
};

Material diffuse(std::string name, Vec3 color);
Material glossy(std::string name, Vec3 color, float roughness, float metallic = 0);
Material conductor(std::string name, Vec3 color, float roughness);
Material glass(std::string name, float ior = 1.5f);

// Random numbers of thing `i` of a kind, each by its own place: the order they are asked for does
// not matter.
class Dice {
  public:
    Dice(std::uint64_t seed, int kind, size_t i)
        : key_(mix(mix(seed) + (std::uint64_t(kind) << 40) + i)) {}
    float operator()(int place, float low = 0, float high = 1) const {
        return low + (high - low) * unit_float(mix(key_ + std::uint64_t(place)));
    }
    Vec3 operator()(int place, Vec3 low, Vec3 high) const {
        return {(*this)(place, low.x, high.x), (*this)(place + 1, low.y, high.y),
                (*this)(place + 2, low.z, high.z)};
    }
    Vec3 direction(int place) const;  // even over the sphere; two places
    size_t below(int place, size_t count) const {
        return std::min(size_t((*this)(place) * float(count)), count - 1);
    }

  private:
    std::uint64_t key_;
};

// Smooth noise in [0, 1], `octaves` of value noise on a lattice that repeats every `period` cells
// (0: never).
float noise(float x, float y, std::uint64_t seed, int octaves = 4, int period = 0);

}  // namespace weft
