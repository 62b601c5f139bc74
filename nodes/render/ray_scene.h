// RayScene: a Scene made ready for rays, in Embree 3.
//   objects   what a ray can hit: placed meshes, and visible area lights (quad, disc, sphere), seen
//             from their bright side only
//   motion    a placement's straight steps and a mesh's vertex keys by Embree's time steps; time in
//             [0, 1]
//   build     meshes in parallel through the context, each by one thread: the same tree, hence the
//             same bits, whatever the number of threads
// A mesh that stands still and is placed once is built in world space, without an instance.
// Throws Error for what Embree would pass over or die of (check_scene).
#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "render/placement.h"
#include "render/scene.h"
#include "runtime/context.h"

namespace weft::render {

struct Object {
    enum class Kind : std::uint8_t { mesh, quad, disc, sphere } kind = Kind::mesh;
    const Mesh* mesh = nullptr;
    int instance = -1, light = -1;  // of the scene: one of the two
    int material = -1;
    bool masked = false;  // its material is not there in places
    bool clear = false;   // its material may let light straight through (may_be_clear)
    bool sheer() const { return masked || clear; }
    std::uint32_t id = 0;
    Placement placement;
    bool moving() const { return placement.moving() || (mesh && mesh->steps > 1); }
};

// What Embree holds of an object: all of it, or one of its placement's pieces.
struct ObjectPiece {
    std::uint32_t object;
    std::uint16_t piece;
    Object::Kind kind;  // the object's, where each hit needs it
};

inline constexpr std::uint32_t no_object = 0xffffffff;
inline constexpr float infinity = std::numeric_limits<float>::infinity();

// Which things a ray meets. sheer: what some light goes straight through.
enum RayMask : std::uint32_t { solid_mask = 1, sheer_mask = 2, light_mask = 4, every_mask = 7 };

// Rays and what they hit, a struct of arrays of `capacity`; kept from batch to batch.
struct Rays {
    std::vector<float> ox, oy, oz, dx, dy, dz, near, far, time;
    std::vector<std::uint32_t> mask;
    // Hits. A mesh: (u, v) weigh the triangle's second and third vertex. A quad: where in [0, 1]^2,
    // a disc: in the square around it. A sphere: x and y of the normal in its own space, and
    // primitive 1 where z is negative.
    std::vector<std::uint32_t> object, primitive;  // object no_object: nothing was hit
    std::vector<float> u, v, distance;

    void resize(size_t n);
    size_t capacity() const { return ox.size(); }
    Vec3 origin(size_t i) const { return {ox[i], oy[i], oz[i]}; }
    Vec3 direction(size_t i) const { return {dx[i], dy[i], dz[i]}; }
    void set(size_t i, Vec3 from, Vec3 to, float from_distance, float to_distance, float at,
             std::uint32_t what) {
        ox[i] = from.x, oy[i] = from.y, oz[i] = from.z;
        dx[i] = to.x, dy[i] = to.y, dz[i] = to.z;
        near[i] = from_distance, far[i] = to_distance, time[i] = at, mask[i] = what;
    }
};

class RayScene {
  public:
    // `scene` must outlive this.
    RayScene(const Scene& scene, Context& ctx);
    ~RayScene();
    RayScene(const RayScene&) = delete;
    RayScene& operator=(const RayScene&) = delete;

    const Scene& scene() const { return scene_; }
    const std::vector<Object>& objects() const { return objects_; }
    bool has_cutouts() const { return has_cutouts_; }
    bool has_clear() const { return has_clear_; }
    bool has_motion() const { return has_motion_; }
    Vec3 center() const { return center_; }  // of all that can be hit, over the whole shutter
    float radius() const { return radius_; }
    // Things of the scene that were left out, and why: for warnings.
    const std::vector<std::string>& left_out() const { return left_out_; }

    // The nearest hit of rays [begin, end), one by one.
    void intersect(Rays& rays, size_t begin, size_t end) const;
    // The same in packets as wide as the processor's vectors: for rays that run side by side. A
    // packet starts at `begin`, so the caller decides what is traced together.
    void intersect_packet(Rays& rays, size_t begin, size_t end) const;
    int packet_width() const { return packet_width_; }
    // Sets object[i] to 0 where something lies between near and far, to no_object where not.
    void occluded(Rays& rays, size_t begin, size_t end) const;

    // Embree's own answer to where an object stands, for tests.
    Affine embree_transform(size_t object, float time) const;
    // The scene's handle (RTCScene), for benchmarks of the bare library.
    void* embree_scene() const;

  private:
    struct Embree;
    void add_objects();

    const Scene& scene_;
    std::vector<Object> objects_;
    std::vector<ObjectPiece> pieces_;  // by Embree's number for them
    std::vector<std::string> left_out_;
    std::unique_ptr<Embree> embree_;
    bool has_cutouts_ = false, has_clear_ = false, has_motion_ = false;
    int packet_width_ = 1;
    Vec3 center_;
    float radius_ = 1;
};

// Denormal numbers count as 0 while this lives, as Embree asks for; every thread that renders holds
// one, so that all give the same bits.
class FlushDenormals {
  public:
    FlushDenormals();
    ~FlushDenormals();
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;

  private:
    unsigned before_;
};

}  // namespace weft::render
