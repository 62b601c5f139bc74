// Where paths begin: a point on the film and one on the lens, a time, and the camera's ray through
// them.
#include <cmath>

#include "render/path_numbers.h"
#include "render/path_pass.h"

namespace weft::render {

void PathTracer::Pass::start_paths() {
    const Camera& camera = tracer.camera_;
    const Lens lens = camera.lens();
    const float spread = camera.pixel_spread();
    size_t i = 0;
    for (const PixelRun& run : runs) {
        const SampleSequence sequence =
            run.numbers ? *run.numbers
                        : sample_sequence(options().sampler, options().seed, run.x, run.y, run.spp);
        const float last_x = std::nextafter(float(run.x + 1), 0.0f),
                    last_y = std::nextafter(float(run.y + 1), 0.0f);
        for (std::uint32_t s = 0; s < run.count; ++s, ++i) {
            const std::uint32_t index = run.first + s;
            const Disk film = sequence(index, film_pair), time = sequence(index, time_pair);
            float u = 0, v = 0;
            if (!camera.pinhole()) {
                const Disk on = sequence(index, lens_pair);
                const auto uv = on_lens(on.u, on.v, lens);
                u = uv[0], v = uv[1];
            }
            const float x = std::min(float(run.x) + film.u, last_x),
                        y = std::min(float(run.y) + film.v, last_y);
            const float t = camera.shutter().time(time.u);
            const Camera::Ray ray = camera.ray(x, y, u, v, t);
            w.rays.set(i, ray.origin, ray.direction, 0, infinity, t, every_mask);
            w.sequence[i] = sequence;
            w.index[i] = index;
            w.time[i] = t;
            w.light_choice[i] = time.v;
            w.radiance[i] = w.diffuse[i] = w.specular[i] = w.direct[i] = {};
            w.sample[i] = std::uint32_t(i);
            w.throughput[i] = white;
            w.lobe[i] = {};
            w.density[i] = 0;
            w.flags[i] = straight | was_delta;
            w.bounces[i] = 0;
            w.width[i] = 0;
            w.spread[i] = spread;
            w.from[i] = ray.origin;
            w.key[i] = mix(sequence.key + index);
            if (wants(ChannelId::xy))
                out.at(ChannelId::xy, i)[0] = x, out.at(ChannelId::xy, i)[1] = y;
            if (wants(ChannelId::uv))
                out.at(ChannelId::uv, i)[0] = u, out.at(ChannelId::uv, i)[1] = v;
            if (wants(ChannelId::t)) *out.at(ChannelId::t, i) = t;
        }
    }
    alive = n;
}

void PathTracer::Pass::trace_camera() {
    const Clock clock(w.statistics.camera_ns);
    w.statistics.camera_rays += n;
    size_t i = 0;
    for (const PixelRun& run : runs) {
        if (run.count >= samples_in_packet / 2)
            scene_rays().intersect_packet(w.rays, i, i + run.count);
        else
            scene_rays().intersect(w.rays, i, i + run.count);
        i += run.count;
    }
}

}  // namespace weft::render
