// What a worker keeps while it traces a batch: paths by sample, rays by path still alive.
#pragma once
#include "render/path_tracer.h"

namespace weft::render {

// Light on its way to a surface, if nothing lies between.
struct Arriving {
    std::uint32_t sample = 0;
    std::uint8_t bounces = 0;  // once it is there; more than two are not told apart
    bool indirect = false;     // it has been scattered before
    Vec3 diffuse, specular;    // by the first hit's lobe
    std::uint64_t key = 0;
};
struct ShadowQueue {
    Rays rays;
    std::vector<Arriving> light;
    size_t size = 0;
    std::vector<float> random;
    std::vector<Vec3> part;  // that passes the sheet before it
    ShadingScratch shading;
    void resize(size_t n);
};

struct PathWorkspace {
    // Of each sample of the batch.
    std::vector<SampleSequence> sequence;
    std::vector<std::uint32_t> index;  // in its pixel
    std::vector<float> time, light_choice;
    std::vector<Vec3> radiance, diffuse, specular, direct;
    // Of each path alive, by place in `sample`; next_* of those that go on.
    std::vector<std::uint32_t> sample, next_sample;
    std::vector<Vec3> throughput, next_throughput;
    std::vector<Vec3> lobe, next_lobe;         // part of it that left the first hit diffusely
    std::vector<float> density, next_density;  // of the last direction; 0: a delta
    std::vector<std::uint8_t> flags, next_flags;
    std::vector<int> bounces, next_bounces;
    std::vector<float> width, next_width, spread,
        next_spread;                    // footprint: at the ray's start, a unit of distance
    std::vector<Vec3> from, next_from;  // the surface point that the ray left
    Rays rays, next_rays;
    std::vector<float> footprint, random;
    std::vector<std::uint64_t> key;
    std::vector<LightSample> light;
    std::vector<BsdfValue> light_value;
    ShadowQueue shadows;
    Rays probe;  // single rays: shadow_hit
    ShadingScratch shading;
    RenderStatistics statistics;
    float deviation = 0;

    void resize(size_t n);
};

}  // namespace weft::render
