// How much light a GGX surface reflects in all, by Schlick's split: F0 * scale + bias, where F0 is
// the colour at normal incidence. Tabulated once, 16 x 32, from 64 x 64 midpoints each; within
// 2e-3. Source: Karis 2013 (the split), Kelemen and Szirmay-Kalos 2001 (what it is used for).
#pragma once

namespace weft::render {

struct GgxAlbedo {
    float scale, bias;
    float of(float normal_incidence) const { return normal_incidence * scale + bias; }
};
GgxAlbedo ggx_albedo(float cosine, float alpha);
// Over all directions, weighted by the cosine.
GgxAlbedo ggx_mean_albedo(float alpha);

}  // namespace weft::render
