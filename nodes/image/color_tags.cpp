#include "image/color_tags.h"

#include <algorithm>
#include <cmath>

namespace weft {
namespace {

constexpr Primaries rec709{0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
constexpr Primaries p3_d65{0.680f, 0.320f, 0.265f, 0.690f, 0.150f, 0.060f, 0.3127f, 0.3290f};
constexpr Primaries rec2020{0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f};
constexpr Primaries ap0{0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f, -0.077f, 0.32168f, 0.33767f};
constexpr Primaries ap1{0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f};

struct Named {
    std::string_view name;
    const Primaries* primaries;
};
// The first name of each is the one given on reading.
constexpr Named linear_spaces[] = {{"lin_rec709", &rec709}, {"Linear Rec.709 (sRGB)", &rec709},
                                   {"lin_srgb", &rec709},   {"ACEScg", &ap1},
                                   {"lin_ap1", &ap1},       {"ACES2065-1", &ap0},
                                   {"aces2065_1", &ap0},    {"lin_ap0", &ap0},
                                   {"lin_p3d65", &p3_d65},  {"lin_rec2020", &rec2020}};

struct NamedDisplay {
    std::string_view name;
    DisplayTag tag;
};
constexpr DisplayTag srgb{1, 13, rec709, 1 / 2.2, true};
constexpr DisplayTag rec1886{1, 1, rec709, 1 / 2.4, false};
constexpr DisplayTag display_p3{12, 13, p3_d65, 1 / 2.2, false};
constexpr DisplayTag rec2100_pq{9, 16, rec2020, 1 / 2.2, false};
constexpr NamedDisplay displays[] = {{"sRGB - Display", srgb},
                                     {"sRGB", srgb},
                                     {"sRGB - Texture", srgb},
                                     {"srgb_tx", srgb},
                                     {"Rec.1886 Rec.709 - Display", rec1886},
                                     {"Rec.709", rec1886},
                                     {"Display P3 - Display", display_p3},
                                     {"Display P3", display_p3},
                                     {"Rec.2100-PQ - Display", rec2100_pq},
                                     {"Rec.2100-PQ", rec2100_pq}};

}  // namespace

const Primaries* primaries_of(std::string_view color_space) {
    for (const Named& space : linear_spaces)
        if (space.name == color_space) return space.primaries;
    return nullptr;
}

std::string space_of_primaries(const Primaries& p) {
    for (const Named& space : linear_spaces) {
        const Primaries& q = *space.primaries;
        const float furthest =
            std::max({std::abs(p.rx - q.rx), std::abs(p.ry - q.ry), std::abs(p.gx - q.gx),
                      std::abs(p.gy - q.gy), std::abs(p.bx - q.bx), std::abs(p.by - q.by),
                      std::abs(p.wx - q.wx), std::abs(p.wy - q.wy)});
        if (furthest < 1e-3f) return std::string(space.name);
    }
    return {};
}

const DisplayTag* display_tag(std::string_view color_space) {
    for (const NamedDisplay& display : displays)
        if (display.name == color_space) return &display.tag;
    return nullptr;
}

std::string display_of_cicp(int primaries, int transfer) {
    for (const NamedDisplay& display : displays)
        if (display.tag.primaries == primaries && display.tag.transfer == transfer)
            return std::string(display.name);
    return {};
}

std::map<std::string, std::string> text_to_write(const Image& image, const Provenance& provenance) {
    std::map<std::string, std::string> text = image.attributes;
    const auto put = [&](const char* name, const std::string& value) {
        text.erase(name);
        if (!value.empty()) text.emplace(name, value);
    };
    put("weft:graph", provenance.graph);
    put("weft:inputs", provenance.inputs);
    put("weft:version", provenance.version);
    put("weft:display", image.display);
    put("weft:view", image.view);
    text.erase("oiio:ColorSpace");
    text.erase("weft:color-space");
    return text;
}

}  // namespace weft
