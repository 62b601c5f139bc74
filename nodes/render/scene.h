// Scene: what a renderer needs to know: meshes, where they stand and move, materials, lights, a
// camera. World units are the scene's own (metres where the file says so); y is up; a camera looks
// along its own -z with x to the right and y up, as in glTF 2.0. Time runs over [0, 1], the open
// shutter: anything that moves holds keys at equal steps, the first at 0 and the last at 1. Colours
// are scene-linear in `color_space`.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "image/image.h"
#include "runtime/value.h"
#include "samples/vec3.h"

namespace weft {

struct Vec2 {
    float x = 0, y = 0;
    bool operator==(const Vec2&) const = default;
};

// Of a place, or of a mesh's vertices.
inline constexpr size_t most_motion_keys = 129;

// p -> x p.x + y p.y + z p.z + origin.
struct Affine {
    Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin{};
    Vec3 point(Vec3 p) const { return vector(p) + origin; }
    Vec3 vector(Vec3 v) const { return x * v.x + y * v.y + z * v.z; }
    friend Affine operator*(const Affine& a, const Affine& b) {
        return {a.vector(b.x), a.vector(b.y), a.vector(b.z), a.point(b.origin)};
    }
    bool operator==(const Affine&) const = default;
};

// A picture file that textures read; its pixels are loaded by the renderer as far as it needs them.
struct TextureFile {
    std::string path;  // what messages call it; the file, where `bytes` is null
    std::shared_ptr<const std::string> bytes;  // an encoded picture inside a scene file
    bool color = true;  // sRGB-encoded unless the file is float; false: numbers as they are
    float bump = 0;     // not 0: numbers that are heights, white `bump` texels above black; what is
                        // looked up is the normal map that they make
};

// A texture at a place of a material. Sampled at offset + rotate(scale * uv, rotation).
struct TextureMap {
    int file = -1;  // of Scene::textures; none: the factor beside it stands alone
    Vec2 offset{}, scale{1, 1};
    float rotation = 0;  // radians, as KHR_texture_transform
    int uv_set = 0;      // which of a mesh's texture coordinates: 0 `uv`, 1 `uv2`
    enum class Wrap { repeat, clamp, mirror } wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
    bool used() const { return file >= 0; }
};

// How a surface reflects. A factor is multiplied by its map where there is one.
struct Material {
    std::string name;
    // metallic_roughness: glTF 2.0's model (with transmission for thin surfaces of rough or clear
    // glass); conductor: GGX, `base_color` at normal incidence (Schlick), a mirror at roughness 0;
    // dielectric: GGX, reflects and refracts by `ior`, clear glass at roughness 0.
    enum class Kind {
        diffuse,
        conductor,
        dielectric,
        metallic_roughness
    } kind = Kind::metallic_roughness;
    Vec3 base_color{0.8f, 0.8f, 0.8f};
    TextureMap base_color_map;
    float metallic = 0, roughness = 1;  // roughness: perceptual, alpha = roughness^2
    TextureMap metallic_roughness_map;  // green: roughness, blue: metallic
    Vec3 emission{};                    // radiance
    TextureMap emission_map;
    float ior = 1.5f;
    float transmission = 0;
    TextureMap transmission_map;  // red
    enum class Alpha { opaque, mask, blend } alpha = Alpha::opaque;
    float opacity = 1, alpha_cutoff = 0.5f;
    TextureMap alpha_map;   // its alpha; of a picture without alpha, its first channel
    TextureMap normal_map;  // tangent space, +y up
    float normal_scale = 1;
    bool two_sided = true;
    std::array<TextureMap*, 6> maps() {
        return {&base_color_map, &metallic_roughness_map,
                &emission_map,   &transmission_map,
                &alpha_map,      &normal_map};
    }
    std::array<const TextureMap*, 6> maps() const {
        const auto all = const_cast<Material*>(this)->maps();
        return {all[0], all[1], all[2], all[3], all[4], all[5]};
    }
    bool emits() const { return emission.x > 0 || emission.y > 0 || emission.z > 0; }
};

// Triangles of one material. Vertices may move over the shutter.
struct Mesh {
    std::string name;
    int steps = 1;                // motion keys
    std::vector<Vec3> positions;  // steps x vertices
    std::vector<Vec3> normals;    // the same, unit; empty: flat
    std::vector<Vec2> uv, uv2;    // vertices, or empty; two sets: maps choose
    std::vector<std::array<std::uint32_t, 3>> triangles;
    int material = 0;
    size_t vertices() const { return positions.size() / size_t(steps); }
    const std::vector<Vec2>& uv_set(int set) const { return set == 0 ? uv : uv2; }
};

// A mesh, placed. Between keys a transform goes as rotation (slerp), and scale, skew and
// translation (linear): a wheel turns round instead of shrinking.
struct Instance {
    std::string name;
    int mesh = 0;
    int material = -1;                // instead of the mesh's own
    std::vector<Affine> to_world{1};  // motion keys, one or more
    std::uint32_t id = 0;             // the `id` channel of samples
};

// All shine along their own -z (sphere and point: to all sides). quad: x and y in [-1, 1], disc:
// x^2 + y^2 <= 1, sphere: the unit ball, under to_world (sphere: uniform scale); area lights have
// one bright side.
struct Light {
    std::string name;
    enum class Shape { quad, disc, sphere, point, spot, directional } shape = Shape::quad;
    Vec3 radiance{1, 1, 1};  // area: radiance; point and spot: intensity; directional: irradiance
    std::vector<Affine> to_world{1};               // motion keys
    float inner_cone = 0, outer_cone = 0.785398f;  // spot: radians from the axis
    bool visible = true;                           // to the camera and mirrors
    bool area() const {
        return shape == Shape::quad || shape == Shape::disc || shape == Shape::sphere;
    }
};

// Light from everywhere: radiance x the map, equirectangular with its middle at -z and +y up.
struct Environment {
    Vec3 radiance{};                   // 0: none
    std::shared_ptr<const Image> map;  // RGB in the scene's space; null: the same from all sides
    float rotation = 0;                // about +y, radians
    bool visible = true;
    bool present() const { return radiance.x > 0 || radiance.y > 0 || radiance.z > 0; }
};

struct SceneCamera {
    std::string name;
    std::vector<Affine> to_world{1};  // motion keys; rotation and translation only
    float vertical_fov = 0.785398f;   // radians
    float lens_radius = 0;            // world units; 0: a pinhole
    float focus = 1;                  // distance of the plane in focus, along the axis
    float lens_aspect = 1;     // anamorphic squeeze: aperture's height over width is 1 / aspect
    int blades = 0;            // 0: round
    float blade_rotation = 0;  // radians
    float shutter_open = 0, shutter_close = 1;  // in the scene's own time, for the record
    std::vector<float> shutter_curve;  // how far open at equal steps over [0, 1]; empty: fully
};

class Scene {
  public:
    std::string name, source;  // source: file, author, licence, for the record
    std::string color_space = "lin_rec709";
    std::vector<TextureFile> textures;
    std::vector<Material> materials;
    std::vector<Mesh> meshes;
    std::vector<Instance> instances;
    std::vector<Light> lights;
    Environment environment;
    SceneCamera camera;

    size_t triangles() const;         // of the meshes
    size_t placed_triangles() const;  // counted once an instance
    size_t bytes() const;
    void count(Items& items) const;
};

WEFT_VALUE_TYPE(Scene, "Scene", "meshes, materials, lights and a camera, to be rendered")

}  // namespace weft
