#include "adaptive/slopes.h"

#include <fmt/format.h>

#include "graph/error.h"

namespace weft::adaptive {

SlopeReader::SlopeReader(const Image& slopes, std::string_view who)
    : slopes_(slopes),
      count_(slopes.find("count")),
      lo_(slopes.find("n.x") >= 0 ? slopes.find("s-lo") : -1),
      lens_lo_(slopes.find("lens-lo")) {
    const auto follow = [&](int first, std::initializer_list<const char*> names) {
        for (const char* name : names)
            if (slopes.find(name) != first++) return false;
        return true;
    };
    const bool whole =
        count_ >= 0 && (lo_ >= 0 || lens_lo_ >= 0) &&
        (lo_ < 0 || follow(lo_, {"s-lo", "s-hi", "n.x", "n.y", "across-lo", "across-hi"})) &&
        (lens_lo_ < 0 || follow(lens_lo_, {"lens-lo", "lens-hi"}));
    if (!whole)
        throw Error(
            fmt::format("'{}' needs the slopes that slope-bounds makes; this picture has {}", who,
                        fmt::join(slopes.names(), " ")));
}

PixelSlopes SlopeReader::operator()(int x, int y) const {
    const float* p = slopes_.at(x, y);
    PixelSlopes out;
    out.motion = motion(), out.lens = lens();
    out.known = p[count_] > 0;
    if (!out.known) return out;
    if (motion()) {
        const float* s = p + lo_;
        out.lo = double(s[0]), out.hi = double(s[1]);
        out.nx = double(s[2]), out.ny = double(s[3]);
        out.across_lo = double(s[4]), out.across_hi = double(s[5]);
    }
    if (lens()) out.lens_lo = double(p[lens_lo_]), out.lens_hi = double(p[lens_lo_ + 1]);
    return out;
}

}  // namespace weft::adaptive
