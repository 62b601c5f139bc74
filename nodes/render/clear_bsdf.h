// The border of a body that bends nothing (index 1): light goes on, coloured by `tint`.
#pragma once
#include "render/bsdf_sample.h"

namespace weft::render {

struct ClearBsdf {
    Vec3 tint;

    BsdfValue eval(Vec3, Vec3) const { return {}; }
    BsdfSample sample(Vec3 out, float, float, float) const {
        return {-out, {{}, tint, 1}, true, true, true};
    }
    Vec3 transmittance(Vec3) const { return tint; }
};

}  // namespace weft::render
