#include "render/ray_scene.h"

#include <embree3/rtcore.h>
#include <fmt/format.h>
#include <tbb/task_arena.h>
#include <xmmintrin.h>

#include <algorithm>
#include <array>

#include "render/bsdf.h"
#include "render/check_scene.h"

namespace weft::render {
namespace {

static_assert(most_motion_keys == RTC_MAX_TIME_STEP_COUNT);

void embree_error(void*, RTCError code, const char* text) {
    // Called inside Embree, which must not be left by an exception; misuse is our mistake, and
    // memory is looked for after each build.
    if (code != RTC_ERROR_NONE && code != RTC_ERROR_OUT_OF_MEMORY)
        fmt::print(stderr, "embree: {}\n", text ? text : "error");
}

bool is_disc(const RTCFilterFunctionNArguments& args, unsigned i) {
    const float u = 2 * RTCHitN_u(args.hit, args.N, i) - 1,
                v = 2 * RTCHitN_v(args.hit, args.N, i) - 1;
    return u * u + v * v <= 1;
}

// Lights are seen from their bright side: flat ones shine along their own -z, spheres outwards.
void flat_light_filter(const RTCFilterFunctionNArguments* args) {
    const bool disc = args->geometryUserPtr != nullptr;
    for (unsigned i = 0; i < args->N; ++i)
        if (args->valid[i] == -1 &&
            (!(RTCRayN_dir_z(args->ray, args->N, i) > 0) || (disc && !is_disc(*args, i))))
            args->valid[i] = 0;
}
void sphere_light_filter(const RTCFilterFunctionNArguments* args) {
    for (unsigned i = 0; i < args->N; ++i) {
        const Vec3 d{RTCRayN_dir_x(args->ray, args->N, i), RTCRayN_dir_y(args->ray, args->N, i),
                     RTCRayN_dir_z(args->ray, args->N, i)};
        const Vec3 n{RTCHitN_Ng_x(args->hit, args->N, i), RTCHitN_Ng_y(args->hit, args->N, i),
                     RTCHitN_Ng_z(args->hit, args->N, i)};
        if (args->valid[i] == -1 && !(dot(d, n) < 0)) args->valid[i] = 0;
    }
}

template <class T>
T* buffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format, size_t count) {
    T* data =
        static_cast<T*>(rtcSetNewGeometryBuffer(geometry, type, slot, format, sizeof(T), count));
    if (!data) throw std::bad_alloc();
    return data;
}

RTCGeometry mesh_geometry(RTCDevice device, const Mesh& mesh, const Affine* baked) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryTimeStepCount(geometry, unsigned(mesh.steps));
    const size_t vertices = mesh.vertices();
    for (int step = 0; step < mesh.steps; ++step) {
        Vec3* to = buffer<Vec3>(geometry, RTC_BUFFER_TYPE_VERTEX, unsigned(step), RTC_FORMAT_FLOAT3,
                                vertices);
        const Vec3* from = mesh.positions.data() + size_t(step) * vertices;
        for (size_t i = 0; i < vertices; ++i) to[i] = baked ? baked->point(from[i]) : from[i];
    }
    auto* index = buffer<std::array<std::uint32_t, 3>>(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                                                       RTC_FORMAT_UINT3, mesh.triangles.size());
    std::copy(mesh.triangles.begin(), mesh.triangles.end(), index);
    return geometry;
}

RTCGeometry light_geometry(RTCDevice device, Object::Kind kind) {
    if (kind == Object::Kind::sphere) {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
        *buffer<std::array<float, 4>>(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 1) = {
            0, 0, 0, 1};
        rtcSetGeometryIntersectFilterFunction(geometry, sphere_light_filter);
        rtcSetGeometryOccludedFilterFunction(geometry, sphere_light_filter);
        return geometry;
    }
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
    Vec3* corner = buffer<Vec3>(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 4);
    corner[0] = {-1, -1, 0}, corner[1] = {1, -1, 0}, corner[2] = {1, 1, 0}, corner[3] = {-1, 1, 0};
    auto* index = buffer<std::array<std::uint32_t, 4>>(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                                                       RTC_FORMAT_UINT4, 1);
    *index = {0, 1, 2, 3};
    static char disc;
    rtcSetGeometryUserData(geometry, kind == Object::Kind::disc ? &disc : nullptr);
    rtcSetGeometryIntersectFilterFunction(geometry, flat_light_filter);
    rtcSetGeometryOccludedFilterFunction(geometry, flat_light_filter);
    return geometry;
}

// Embree's loops would otherwise run on all threads there are.
void commit(RTCScene scene) {
    tbb::task_arena alone(1);
    alone.execute([&] { rtcCommitScene(scene); });
}

RTCScene new_scene(RTCDevice device) {
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    return scene;
}

// One of the placement's pieces; the instance is there during its part of the shutter only.
void set_transforms(RTCGeometry instance, const Placement& placement, size_t piece) {
    const size_t steps = placement.steps_a_piece();
    const float length = 1 / float(placement.pieces());
    rtcSetGeometryTimeStepCount(instance, unsigned(steps + 1));
    if (placement.pieces() > 1)
        rtcSetGeometryTimeRange(instance, float(piece) * length, float(piece + 1) * length);
    for (size_t step = 0; step <= steps; ++step) {
        const Affine& m = placement.matrices()[piece * steps + step];
        const float columns[12] = {m.x.x, m.x.y, m.x.z, m.y.x,      m.y.y,      m.y.z,
                                   m.z.x, m.z.y, m.z.z, m.origin.x, m.origin.y, m.origin.z};
        rtcSetGeometryTransform(instance, unsigned(step), RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                                columns);
    }
}

bool masks(const Material& material) {
    return material.alpha != Material::Alpha::opaque &&
           (material.alpha_map.used() || material.opacity < 1);
}

}  // namespace

FlushDenormals::FlushDenormals() : before_(_mm_getcsr()) {
    _mm_setcsr(before_ | 0x8040);  // flush to zero, denormals are zero
}
FlushDenormals::~FlushDenormals() {
    _mm_setcsr(before_);
}

void Rays::resize(size_t n) {
    for (auto* a : {&ox, &oy, &oz, &dx, &dy, &dz, &near, &far, &time, &u, &v, &distance})
        a->resize(n);
    for (auto* a : {&mask, &object, &primitive}) a->resize(n);
}

struct RayScene::Embree {
    RTCDevice device = nullptr;
    RTCScene world = nullptr;
    std::vector<RTCScene> scenes;  // of instanced meshes and lights
    Embree() : device(rtcNewDevice(nullptr)) {
        if (!device) throw Error("Embree cannot start on this machine");
        rtcSetDeviceErrorFunction(device, embree_error, nullptr);
    }
    ~Embree() {
        if (world) rtcReleaseScene(world);
        for (RTCScene scene : scenes)
            if (scene) rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
};

void RayScene::add_objects() {
    const auto usable = [&](const std::vector<Affine>& keys, const char* kind,
                            const std::string& name) {
        if (std::all_of(keys.begin(), keys.end(), is_invertible)) return true;
        left_out_.push_back(
            fmt::format("{} '{}' is squashed flat (its transform has no inverse)", kind, name));
        return false;
    };
    for (size_t i = 0; i < scene_.instances.size(); ++i) {
        const Instance& instance = scene_.instances[i];
        if (!usable(instance.to_world, "instance", instance.name)) continue;
        const Mesh& mesh = scene_.meshes[size_t(instance.mesh)];
        if (mesh.triangles.empty()) continue;
        Object object;
        object.mesh = &mesh;
        object.instance = int(i);
        object.material = instance.material >= 0 ? instance.material : mesh.material;
        object.masked = masks(scene_.materials[size_t(object.material)]);
        object.clear = may_be_clear(scene_.materials[size_t(object.material)]);
        object.id = instance.id;
        object.placement = Placement(instance.to_world);
        objects_.push_back(std::move(object));
    }
    for (size_t i = 0; i < scene_.lights.size(); ++i) {
        const Light& light = scene_.lights[i];
        if (!light.area() || !light.visible || !usable(light.to_world, "light", light.name))
            continue;
        Object object;
        object.kind = light.shape == Light::Shape::quad   ? Object::Kind::quad
                      : light.shape == Light::Shape::disc ? Object::Kind::disc
                                                          : Object::Kind::sphere;
        object.light = int(i);
        object.placement = placement_of(light);
        objects_.push_back(std::move(object));
    }
    for (std::uint32_t i = 0; i < objects_.size(); ++i) {
        const Object& object = objects_[i];
        has_cutouts_ = has_cutouts_ || object.masked;
        has_clear_ = has_clear_ || object.clear;
        has_motion_ = has_motion_ || object.moving();
        for (size_t piece = 0; piece < object.placement.pieces(); ++piece)
            pieces_.push_back({i, std::uint16_t(piece), object.kind});
    }
}

RayScene::RayScene(const Scene& scene, Context& ctx) : scene_(scene) {
    check_scene(scene);
    add_objects();
    embree_ = std::make_unique<Embree>();
    RTCDevice device = embree_->device;

    std::vector<int> uses(scene.meshes.size(), 0);
    for (const Object& object : objects_)
        if (object.mesh) ++uses[size_t(scene.instances[size_t(object.instance)].mesh)];
    const auto baked = [&](const Object& object) {
        return object.mesh && !object.placement.moving() &&
               uses[size_t(scene.instances[size_t(object.instance)].mesh)] == 1;
    };

    // Scenes below the world: meshes that are placed more than once or move, then lights by shape.
    const size_t meshes = scene.meshes.size();
    embree_->scenes.assign(meshes + 3, nullptr);
    std::vector<char> needed(meshes + 3, 0);
    const auto below = [&](const Object& object) {
        return object.mesh ? size_t(scene.instances[size_t(object.instance)].mesh)
                           : meshes + size_t(object.kind) - 1;
    };
    for (const Object& object : objects_)
        if (!baked(object)) needed[below(object)] = 1;
    ctx.parallel_for(needed.size(), [&](size_t i) {
        if (!needed[i]) return;
        RTCScene scene_below = new_scene(device);
        embree_->scenes[i] = scene_below;
        RTCGeometry geometry = i < meshes ? mesh_geometry(device, scene.meshes[i], nullptr)
                                          : light_geometry(device, Object::Kind(i - meshes + 1));
        rtcSetGeometryMask(geometry, every_mask);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_below, geometry);
        rtcReleaseGeometry(geometry);
        commit(scene_below);
    });

    embree_->world = new_scene(device);
    ctx.parallel_for(
        pieces_.size(),
        [&](size_t i) {
            const Object& object = objects_[pieces_[i].object];
            RTCGeometry geometry;
            if (baked(object)) {
                const Affine& to_world = object.placement.matrices()[0];
                geometry =
                    mesh_geometry(device, *object.mesh, to_world == Affine{} ? nullptr : &to_world);
            } else {
                geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
                rtcSetGeometryInstancedScene(geometry, embree_->scenes[below(object)]);
                set_transforms(geometry, object.placement, pieces_[i].piece);
            }
            rtcSetGeometryMask(geometry, object.light >= 0 ? light_mask
                                         : object.sheer()  ? sheer_mask
                                                           : solid_mask);
            rtcCommitGeometry(geometry);
            rtcAttachGeometryByID(embree_->world, geometry, unsigned(i));
            rtcReleaseGeometry(geometry);
        },
        64);
    commit(embree_->world);
    if (rtcGetDeviceError(device) == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();

    RTCBounds bounds{};
    rtcGetSceneBounds(embree_->world, &bounds);
    if (bounds.lower_x <= bounds.upper_x) {
        const Vec3 low{bounds.lower_x, bounds.lower_y, bounds.lower_z},
            high{bounds.upper_x, bounds.upper_y, bounds.upper_z};
        center_ = lerp(low, high, 0.5f);
        radius_ = std::max(length(high - low) / 2, 1e-20f);
    }
    if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED))
        packet_width_ = 16;
    else if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED))
        packet_width_ = 8;
}

RayScene::~RayScene() = default;

void* RayScene::embree_scene() const {
    return embree_->world;
}

Affine RayScene::embree_transform(size_t object, float time) const {
    const size_t pieces = objects_[object].placement.pieces();
    const size_t piece = std::min(size_t(time * float(pieces)), pieces - 1);
    const auto first =
        std::lower_bound(pieces_.begin(), pieces_.end(), object,
                         [](const ObjectPiece& p, size_t of) { return p.object < of; });
    const auto id = unsigned(size_t(first - pieces_.begin()) + piece);
    float m[12];
    rtcGetGeometryTransform(rtcGetGeometry(embree_->world, id), time,
                            RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, m);
    return {{m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}, {m[9], m[10], m[11]}};
}

namespace {

// Says which object was hit; of a ball of light also where, from the normal.
void name_hit(Rays& rays, size_t i, const std::vector<ObjectPiece>& pieces, unsigned geometry,
              unsigned instance, Vec3 ng) {
    if (geometry == RTC_INVALID_GEOMETRY_ID) {
        rays.object[i] = no_object;
        return;
    }
    const ObjectPiece& hit = pieces[instance != RTC_INVALID_GEOMETRY_ID ? instance : geometry];
    rays.object[i] = hit.object;
    if (hit.kind != Object::Kind::sphere) return;
    const Vec3 n = unit(ng);
    rays.primitive[i] = n.z < 0;
    rays.u[i] = n.x, rays.v[i] = n.y;
}

// Up to `width` values from one array to another; a whole packet's in vector moves.
template <size_t width, class T>
void copy_lanes(const T* from, size_t n, T* to) {
    if (n == width)
        std::copy_n(from, width, to);
    else
        std::copy_n(from, n, to);
}

template <size_t width, class Packet, class Intersect>
void trace_packet(RTCScene world, const std::vector<ObjectPiece>& pieces, Rays& rays, size_t begin,
                  size_t end, Intersect intersect) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (size_t first = begin; first < end; first += width) {
        const size_t n = std::min(width, end - first);
        alignas(64) int valid[width];
        alignas(64) Packet p;
        if (n < width) p = {};  // what is not valid is read all the same
        const auto load = [&](const auto& from, auto* to) {
            copy_lanes<width>(&from[first], n, to);
        };
        load(rays.ox, p.ray.org_x), load(rays.oy, p.ray.org_y), load(rays.oz, p.ray.org_z);
        load(rays.dx, p.ray.dir_x), load(rays.dy, p.ray.dir_y), load(rays.dz, p.ray.dir_z);
        load(rays.near, p.ray.tnear), load(rays.far, p.ray.tfar);
        load(rays.time, p.ray.time), load(rays.mask, p.ray.mask);
        for (size_t k = 0; k < width; ++k) {
            valid[k] = k < n ? -1 : 0;
            p.ray.id[k] = 0, p.ray.flags[k] = 0;
            p.hit.geomID[k] = p.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
        }
        intersect(valid, world, &context, &p);
        const auto store = [&](const auto* from, auto& to) {
            copy_lanes<width>(from, n, &to[first]);
        };
        store(p.ray.tfar, rays.distance), store(p.hit.primID, rays.primitive);
        store(p.hit.u, rays.u), store(p.hit.v, rays.v);
        for (size_t k = 0; k < n; ++k)
            name_hit(rays, first + k, pieces, p.hit.geomID[k], p.hit.instID[0][k],
                     {p.hit.Ng_x[k], p.hit.Ng_y[k], p.hit.Ng_z[k]});
    }
}

}  // namespace

void RayScene::intersect(Rays& rays, size_t begin, size_t end) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    for (size_t i = begin; i < end; ++i) {
        RTCRayHit r;
        r.ray = {rays.ox[i], rays.oy[i],   rays.oz[i],  rays.near[i], rays.dx[i], rays.dy[i],
                 rays.dz[i], rays.time[i], rays.far[i], rays.mask[i], 0,          0};
        r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(embree_->world, &context, &r);
        rays.distance[i] = r.ray.tfar, rays.primitive[i] = r.hit.primID;
        rays.u[i] = r.hit.u, rays.v[i] = r.hit.v;
        name_hit(rays, i, pieces_, r.hit.geomID, r.hit.instID[0],
                 {r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z});
    }
}

void RayScene::intersect_packet(Rays& rays, size_t begin, size_t end) const {
    if (packet_width_ == 16)
        trace_packet<16, RTCRayHit16>(embree_->world, pieces_, rays, begin, end, rtcIntersect16);
    else if (packet_width_ == 8)
        trace_packet<8, RTCRayHit8>(embree_->world, pieces_, rays, begin, end, rtcIntersect8);
    else
        intersect(rays, begin, end);
}

void RayScene::occluded(Rays& rays, size_t begin, size_t end) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    for (size_t i = begin; i < end; ++i) {
        RTCRay r{rays.ox[i], rays.oy[i],   rays.oz[i],  rays.near[i], rays.dx[i], rays.dy[i],
                 rays.dz[i], rays.time[i], rays.far[i], rays.mask[i], 0,          0};
        rtcOccluded1(embree_->world, &context, &r);
        rays.object[i] = r.tfar < 0 ? 0 : no_object;
    }
}

}  // namespace weft::render
