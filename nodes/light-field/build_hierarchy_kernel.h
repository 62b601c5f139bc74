// Building a Hierarchy: samples are carried to lens centre and half time, sorted, put in place and
// bounded. Source: Lehtinen et al. 2011, Sec. 3.2 and Appendix A (see hierarchy.h). Cost: linear in
// samples.  Memory: 64 bytes a sample where things move, 36 where not, all of them the result's; 12
// while keys are sorted; pages of a mapped sample file go as they are done with (pages_done.h).
// Threads: through the context.
#pragma once
#include <span>

#include "light-field/hierarchy.h"
#include "runtime/context.h"
#include "runtime/isa.h"

namespace weft::light_field {

// Homogeneous depth that stands for infinity: far enough that its slope is C1 to the last bit.
inline constexpr float far_depth = 0x1p+40f;

// Radius of the largest empty disk that a good sampling pattern of this density leaves, px.
// Source: 2.2 / sqrt(spp + 0.2) is within 10 % of what the authors of the method measured, from 1
// to 256 samples a pixel.
float dispersion_radius(double samples_per_pixel);

// The channels that say where samples are; null where a buffer has none, t and motion together.
struct Places {
    const float *xy = nullptr, *z = nullptr, *uv = nullptr, *t = nullptr, *motion = nullptr;
    Places from(size_t i) const {
        return {xy + 2 * i, z + i, uv ? uv + 2 * i : nullptr, t ? t + i : nullptr,
                motion ? motion + 3 * i : nullptr};
    }
};
Places places_of(const Samples& samples);

// A sample at lens centre and half time.
struct Recentred {
    float X, Y, W, VX, VY, VW;
};
// One at infinity becomes a point far_depth away.
Recentred recentred(const Places& places, const Lens& lens, size_t i);

// The places of a few samples, fetched from where they lie to be side by side.
struct Fetched {
    static constexpr size_t most = 256;
    std::array<float, 2 * most> xy, uv;
    std::array<float, most> z, t;
    std::array<float, 3 * most> motion;

    void fetch(const Places& from, std::span<const std::uint32_t> samples) {
        for (size_t k = 0; k < samples.size(); ++k) {
            const size_t j = samples[k];
            z[k] = from.z[j];
            copy<2>(from.xy, j, &xy[2 * k]);
            if (from.uv) copy<2>(from.uv, j, &uv[2 * k]);
            if (!from.motion) continue;
            t[k] = from.t[j];
            copy<3>(from.motion, j, &motion[3 * k]);
        }
    }
    template <size_t n>
    static void copy(const float* from, size_t record, float* to) {
        for (size_t c = 0; c < n; ++c) to[c] = from[n * record + c];
    }
    // As places, of the channels that `of` has.
    Places places(const Places& of) const {
        return {xy.data(), z.data(), of.uv ? uv.data() : nullptr, of.motion ? t.data() : nullptr,
                of.motion ? motion.data() : nullptr};
    }
};

// Where samples go at lens centre; VX null where nothing moves.
struct Paths {
    float *X = nullptr, *Y = nullptr, *W = nullptr, *VX = nullptr, *VY = nullptr, *VW = nullptr;
};

// How samples are put in order (Arrangement), in cells that are `cell` px wide and start `border`
// px outside.
struct KeyGrid {
    bool layers = true;
    double border = 0, cell = 1, columns = 1, rows = 32767;  // the last column and row
    double middle_x = 0, middle_y = 0;  // where samples go that are behind the camera
    double c0 = 0, c1 = 0;              // of the lens
};

#define WEFT_RECENTRING_KERNELS(isa)                                                        \
    namespace isa {                                                                         \
    void recentre(const Places& from, const Lens& lens, size_t n, const Paths& to);         \
    void sort_keys(const Paths& paths, const KeyGrid& grid, size_t n, std::uint64_t* keys); \
    }
WEFT_RECENTRING_KERNELS(v2)
WEFT_RECENTRING_KERNELS(v3)
WEFT_RECENTRING_KERNELS(v4)

// Whether the sample is in front of the camera during the whole shutter.
inline bool always_there(float W, float VW) {
    const float half = 0.5f * (VW < 0 ? -VW : VW);
    return W - half > 1e-6f * half && W > 0;
}

enum class Arrangement {
    layers,  // blocks of about 48 samples along a Morton curve, each sorted by slope and velocity
    cells,   // uniform square cells of about 16 samples, row by row, depth left out of account
};

// Everything: `samples` with xy, z and rgb at least.
Hierarchy build_hierarchy(const Samples& samples, Arrangement arrangement, double radius_scale,
                          Context& ctx);

}  // namespace weft::light_field
