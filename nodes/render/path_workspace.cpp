#include "render/path_workspace.h"

namespace weft::render {

void ShadowQueue::resize(size_t n) {
    if (n <= light.size()) return;
    rays.resize(n), light.resize(n), random.resize(n), part.resize(n);
}

void PathWorkspace::resize(size_t n) {
    if (n <= sample.size()) return;
    sequence.resize(n), index.resize(n);
    for (auto* a : {&time, &light_choice, &density, &next_density, &width, &next_width, &spread,
                    &next_spread, &footprint, &random})
        a->resize(n);
    for (auto* a : {&radiance, &diffuse, &specular, &direct, &throughput, &next_throughput, &lobe,
                    &next_lobe, &from, &next_from})
        a->resize(n);
    sample.resize(n), next_sample.resize(n);
    flags.resize(n), next_flags.resize(n), bounces.resize(n), next_bounces.resize(n);
    key.resize(n), light.resize(n), light_value.resize(n);
    rays.resize(n), next_rays.resize(n), probe.resize(1);
    shadows.resize(n);
}

void PathWorkspaceDeleter::operator()(PathWorkspace* workspace) const {
    delete workspace;
}

void RenderStatistics::add(const RenderStatistics& o) {
    camera_rays += o.camera_rays, path_rays += o.path_rays, shadow_rays += o.shadow_rays;
    samples += o.samples, lookups += o.lookups;
    camera_ns += o.camera_ns, path_ns += o.path_ns, shadow_ns += o.shadow_ns;
    texture_ns += o.texture_ns, all_ns += o.all_ns;
}

}  // namespace weft::render
