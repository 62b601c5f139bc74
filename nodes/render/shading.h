// Shading: from hits to what a surface does with light there. Textures are looked up in batches,
// material by material, no finer than the ray's footprint.
#pragma once
#include "render/bsdf.h"
#include "render/lights.h"
#include "render/shading_frame.h"
#include "render/surface.h"
#include "render/textures.h"

namespace weft::render {

struct Shade {
    SurfacePoint point;
    Vec3 out;            // unit, back along the ray
    Vec3 normal;         // shading normal, maps included; see below
    ShadingFrame frame;  // about `normal`
    Bsdf bsdf;
    Vec3 emission;  // towards `out`
    Vec3 albedo;
    float roughness = 1, transmission = 0;
    bool light = false;  // a light's own surface: nothing is reflected
    // `point.geometric` and `normal` lie on the side of `out`, but for materials with an inside,
    // where they point outwards.
};

// A worker's memory for one batch of hits.
struct ShadingScratch {
    std::vector<Shade> shades;                // of hits, where they have one
    std::vector<std::uint32_t> order, count;  // hits by material
    std::vector<Vec2> uv;
    std::vector<float> width, random, rgba, footprint, opacity, error;
    std::uint64_t texture_ns = 0, lookups = 0;
};

// So many sheets of what may let light through a ray passes; then what is there counts as solid.
inline constexpr int most_layers = 1024;

// Where a ray that passed a surface at `distance` goes on; `error` of that surface's point.
inline float beyond(float distance, float error) {
    return distance + 2 * error + 1e-6f * distance;
}

class Shading {
  public:
    Shading(const RayScene& rays, const Lights& lights, const Textures* textures)
        : rays_(rays), lights_(lights), textures_(textures) {}

    // Fills scratch.shades[k] for the hits k of [0, n). `footprint` in world units at the hit,
    // `random` in [0, 1).
    void shade(const Rays& hits, size_t n, std::span<const float> footprint,
               std::span<const float> random, ShadingScratch& scratch) const;

    // Emission of a point of an emitting mesh drawn as a light, its map included. In place of
    // `radiance`: of the samples whose object is one with an emission map.
    void light_radiance(std::span<LightSample> lights, ShadingScratch& scratch) const;

    // Cutouts are looked up as fine as a camera ray as long as theirs would: `spread` is its
    // footprint a unit of distance. All rays of a picture take the same, or what one sees another
    // would look through.

    // Lets rays [0, n) pass where materials with cutouts are not there, tracing them on, until they
    // hit something that is, or nothing. `keys` choose where opacity is partial: one a ray, which
    // no other ray of the picture has.
    void pass_cutouts(Rays& rays, size_t n, float spread, std::span<const std::uint64_t> keys,
                      ShadingScratch& scratch) const;

    // What part of the light on its way along rays [0, n) goes straight on past what they hit
    // (sheer objects): 1 less opacity, and the transmittance of what is there. `random` in [0, 1).
    void transmittance(const Rays& hits, size_t n, float spread, std::span<const float> random,
                       std::span<Vec3> part, ShadingScratch& scratch) const;

  private:
    // Of hit k, by the map's set of texture coordinates; `first` by the mesh's first.
    UvFrame frame_of(const TextureMap& map, const UvFrame& first, const Rays& hits, size_t k) const;
    void look_up(const TextureMap& map, const Rays& hits, std::span<const std::uint32_t> group,
                 std::span<const float> footprint, std::span<const float> random,
                 ShadingScratch& scratch) const;
    void opacities(const Rays& rays, std::span<std::uint32_t> hits, float spread,
                   ShadingScratch& scratch) const;
    const Material& material(std::uint32_t object) const {
        return rays_.scene().materials[size_t(rays_.objects()[object].material)];
    }

    const RayScene& rays_;
    const Lights& lights_;
    const Textures* textures_;
};

}  // namespace weft::render
