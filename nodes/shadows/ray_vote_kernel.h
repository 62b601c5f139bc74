// How much of the light a receiver sees: by the rays that came near.
#pragma once
#include <span>
#include <vector>

#include "light-field/streams.h"
#include "shadows/planes.h"
#include "shadows/streams.h"

namespace weft::shadows {

struct RayVote {
    DepthTest test = DepthTest::both_planes;
    float bias = 1e-5f;  // relative; linear: world units
};

struct RayVoteScratch {
    // A ray that passed something before the receiver, as seen from the light's point.
    struct Pass {
        float x, y, inverse;  // px from the receiver, and 1/w there
        float way_x, way_y;   // px it moves a unit of 1/w
        float end;            // 1/w where it ends
        float bulge;          // px that the surface beside it may come out
    };
    std::vector<Pass> passes;
};

// A receiver does not see the light's point if a ray was stopped on its way that comes nearer to it
// there than all rays that are free of what stopped it: that go by where that surface is, and on.
// Of a surface that bends, what one point of the light sees beside its outline may be hidden from
// another: rays that were sent from elsewhere count as farther by that.
// So rims lie in the middle between the last ray that was stopped and the first that went past;
// over many points of the light this is the share of rays that a surface lets through.
// Source: own, in place of the coverage of Lehtinen et al. 2011, Sec. 3.4 and 4.
class RayVoting {
  public:
    // Of light samples, and of where their rays pass surfaces (passing_rays_kernel.h).
    RayVoting(const Hierarchy& hits, const Hierarchy& passes, const LightView& view,
              const RayVote& set);

    // As if no ray passed anything: a location sees the light where no candidate stands before it.
    // `open`: those of which passes may say something else, as they are stopped, or nobody is near.
    void by_hits(const Candidates& hits, const ShadowQueries& queries, LightShares& out,
                 std::vector<std::uint32_t>& open) const;
    // What passes say of these: location k of `passes` is location open[k] of `hits`. Where there
    // are no candidates of either kind, the share is 1 and nobody has voted.
    void by_passes(const Candidates& hits, const Candidates& passes,
                   std::span<const std::uint32_t> open, const ShadowQueries& queries,
                   RayVoteScratch& scratch, LightShares& out) const;

    const Hierarchy& hits() const { return hits_.hierarchy(); }
    const Hierarchy& passes() const { return passes_.hierarchy(); }

  private:
    struct Receiver;
    Receiver receiver(const Candidates& hits, const ShadowQueries& queries, size_t l) const;
    bool before(const Receiver& receiver, const Planes& planes, const Candidates& of,
                std::uint32_t i) const;
    bool free_of(const Receiver& receiver, const Candidates& hits, std::uint32_t hit,
                 std::span<const RayVoteScratch::Pass> passes) const;

    const Planes hits_, passes_;
    const RayVote set_;
    float lens_x_, lens_y_, level_, angle_;
};

}  // namespace weft::shadows
