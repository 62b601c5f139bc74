// A mirror: all light goes where it is reflected about the normal, times Schlick's Fresnel term.
#pragma once
#include "render/bsdf_sample.h"

namespace weft::render {

struct MirrorBsdf {
    Vec3 normal_incidence;

    BsdfValue eval(Vec3, Vec3) const { return {}; }
    BsdfSample sample(Vec3 out, float, float, float) const {
        if (out.z <= 0) return {};
        return {{-out.x, -out.y, out.z}, {{}, schlick(normal_incidence, out.z), 1}, true};
    }
};

}  // namespace weft::render
