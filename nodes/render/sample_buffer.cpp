#include "render/sample_buffer.h"

#include <fmt/format.h>

#include <algorithm>

#include "render/surface.h"

namespace weft::render {
namespace {

Json numbers(Vec3 v) {
    return Json::list({double(v.x), double(v.y), double(v.z)});
}

constexpr size_t most_triangles = 4096;

Json corners_of(const Object& object, float time) {
    Json list = Json::list();
    for (std::uint32_t t = 0; t < object.mesh->triangles.size(); ++t) {
        Json one = Json::list();
        for (const Vec2 at : {Vec2{0, 0}, Vec2{1, 0}, Vec2{0, 1}}) {
            const Vec3 p = position_at(object, t, at.x, at.y, time);
            for (const float c : {p.x, p.y, p.z}) one.items.emplace_back(double(c));
        }
        list.items.push_back(std::move(one));
    }
    return list;
}

Json mesh_meta(const PathTracer& tracer, size_t light) {
    const Scene& scene = tracer.scene();
    const Object& object = tracer.rays().objects()[tracer.lights().mesh_object(light)];
    const Material& material = scene.materials[size_t(object.material)];
    const std::string& own = scene.instances[size_t(object.instance)].name;
    Json one = Json::object();
    one.set("name", own.empty() ? object.mesh->name : own);
    one.set("shape", "mesh");
    one.set("radiance", numbers(material.emission));
    one.set("two_sided", material.two_sided);
    if (object.mesh->triangles.size() > most_triangles) return one;
    one.set("triangles", corners_of(object, 0));
    if (object.moving()) one.set("triangles_end", corners_of(object, 1));
    const auto sums = tracer.lights().triangle_sums(light);
    Json chances = Json::list();
    for (size_t t = 0; t + 1 < sums.size(); ++t)
        chances.items.emplace_back(double(sums[t + 1]) - double(sums[t]));
    one.set("chances", std::move(chances));
    return one;
}

}  // namespace

Json lights_meta(const PathTracer& tracer) {
    const Scene& scene = tracer.scene();
    constexpr const char* shapes[] = {"quad", "disc", "sphere", "point", "spot", "directional"};
    Json list = Json::list();
    for (const Light& light : scene.lights) {
        const Affine& m = light.to_world.front();
        const float a = length(m.x), b = length(m.y);
        Json one = Json::object();
        one.set("name", light.name);
        one.set("shape", shapes[size_t(light.shape)]);
        one.set("origin", numbers(m.origin));
        one.set("ex", numbers(a > 0 ? m.x * (1 / a) : m.x));
        one.set("ey", numbers(b > 0 ? m.y * (1 / b) : m.y));
        if (light.to_world.size() > 1) {
            const Affine& end = light.to_world.back();
            one.set("origin_end", numbers(end.origin));
            one.set("ex_end", numbers(a > 0 ? end.x * (1 / a) : end.x));
            one.set("ey_end", numbers(b > 0 ? end.y * (1 / b) : end.y));
        }
        one.set("half_extents",
                light.area() ? Json::list({double(a), double(b)}) : Json::list({0.0, 0.0}));
        one.set("radiance", numbers(light.radiance));
        list.items.push_back(std::move(one));
    }
    for (size_t i = 0; i < tracer.lights().size(); ++i)
        if (tracer.lights().mesh_object(i) != no_object)
            list.items.push_back(mesh_meta(tracer, i));
    return list;
}

Samples empty_samples(const PathTracer& tracer, const SamplePlan& plan) {
    const Scene& scene = tracer.scene();
    const SceneCamera& camera = scene.camera;
    Samples samples;
    samples.width = plan.width();
    samples.height = plan.height();
    samples.spp = plan.spp();
    if (samples.spp == 0) samples.first = std::vector<std::uint64_t>(plan.offsets());
    samples.set_size(plan.samples());
    samples.color_space = scene.color_space;
    if (!tracer.camera().pinhole()) samples.lens = tracer.camera().lens();
    samples.meta = Json::object();
    samples.meta.set("shutter",
                     Json::list({double(camera.shutter_open), double(camera.shutter_close)}));
    Json curve;
    if (!tracer.camera().shutter().constant()) {
        curve = Json::list();
        for (const float open : camera.shutter_curve) curve.items.emplace_back(double(open));
    }
    samples.meta.set("shutter_curve", std::move(curve));
    samples.meta.set("source", scene.source.empty() ? scene.name : scene.source);
    samples.meta.set("lights", lights_meta(tracer));
    samples.meta.set("camera", tracer.camera().meta());
    return samples;
}

void ChannelArrays::resize(const ChannelSet& channels, size_t samples) {
    for (const ChannelId c : channels.list()) {
        if (info_of(c).whole)
            ids[size_t(c)].resize(samples);
        else
            values[size_t(c)].resize(samples * size_t(info_of(c).components));
    }
}

void render_rows(const PathTracer& tracer, const SamplePlan& plan, int begin, int end,
                 std::uint64_t offset, RenderWorkers& workers, ChannelArrays& to, Context& ctx) {
    const std::vector<ChannelId> channels = tracer.options().channels.list();
    const int across = (plan.width() + pixels_in_piece - 1) / pixels_in_piece;
    const size_t pieces = size_t(across) * size_t(end - begin);
    std::atomic<size_t> done = 0;
    ctx.parallel_for(pieces, [&](size_t piece) {
        const int y = begin + int(piece / size_t(across)),
                  x = int(piece % size_t(across)) * pixels_in_piece;
        workers.with([&](RenderWorker& worker) {
            BatchCursor cursor(plan, {x, y, std::min(x + pixels_in_piece, plan.width()), y + 1});
            // Pixels of a row follow one another in the buffer.
            std::uint64_t at = plan.first(x, y) - offset;
            while (cursor.next(worker.runs)) {
                ctx.check_cancelled();
                tracer.render(worker.runs, *worker.workspace, worker.batch);
                for (const ChannelId c : channels) {
                    const size_t k = size_t(info_of(c).components);
                    if (info_of(c).whole)
                        std::copy_n(worker.batch.ids[size_t(c)].data(), worker.batch.size,
                                    &to.ids[size_t(c)][at]);
                    else
                        std::copy_n(worker.batch.values[size_t(c)].data(), worker.batch.size * k,
                                    &to.values[size_t(c)][at * k]);
                }
                at += worker.batch.size;
            }
        });
        ctx.progress(double(++done), double(pieces), "rows");
    });
}

void give_channels(const ChannelSet& channels, ChannelArrays arrays, Samples& to) {
    for (const ChannelId c : channels.list()) {
        const std::string name(info_of(c).name);
        if (info_of(c).whole)
            to.add_ids(name, std::move(arrays.ids[size_t(c)]));
        else
            to.add(name, info_of(c).components, std::move(arrays.values[size_t(c)]));
    }
    to.meta = to.meta_object();
}

}  // namespace weft::render
