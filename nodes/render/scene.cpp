#include "render/scene.h"

namespace weft {

size_t Scene::triangles() const {
    size_t sum = 0;
    for (const Mesh& mesh : meshes) sum += mesh.triangles.size();
    return sum;
}

size_t Scene::placed_triangles() const {
    size_t sum = 0;
    for (const Instance& instance : instances)
        sum += meshes[size_t(instance.mesh)].triangles.size();
    return sum;
}

size_t Scene::bytes() const {
    size_t sum = environment.map ? environment.map->bytes() : 0;
    for (const Mesh& mesh : meshes)
        sum += (mesh.positions.size() + mesh.normals.size()) * sizeof(Vec3) +
               (mesh.uv.size() + mesh.uv2.size()) * sizeof(Vec2) +
               mesh.triangles.size() * sizeof(mesh.triangles[0]);
    for (const Instance& instance : instances)
        sum += sizeof(instance) + instance.to_world.size() * sizeof(Affine);
    for (const TextureFile& file : textures) sum += file.bytes ? file.bytes->size() : 0;
    return sum;
}

void Scene::count(Items& items) const {
    items.add("triangles", triangles());
    items.add("instances", instances.size());
}

}  // namespace weft
