#include "samples/exr_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace weft {
namespace {

struct Known {
    std::string_view exr, channel;
    int part;
};
constexpr std::array known = {
    Known{"R", "rgb", 0},   Known{"G", "rgb", 1}, Known{"B", "rgb", 2},
    Known{"A", "alpha", 0}, Known{"Z", "z", 0},   Known{"x", "xy", 0},
    Known{"y", "xy", 1},    Known{"u", "uv", 0},  Known{"v", "uv", 1},
};

constexpr std::string_view colors = "RGBA", axes = "xyzw", small_colors = "rgba";

bool is_color(const Channel& channel) {
    return channel.role == Role::radiance || channel.name.starts_with("albedo");
}

}  // namespace

std::string exr_name(const Channel& channel, int part) {
    for (const Known& k : known)
        if (k.channel == channel.name && k.part == part) return std::string(k.exr);
    if (channel.components == 1) return channel.name;
    if (channel.components == 3 && is_color(channel))
        return fmt::format("{}.{}", channel.name, colors[size_t(part)]);
    if (channel.components <= 4) return fmt::format("{}.{}", channel.name, axes[size_t(part)]);
    return fmt::format("{}.{}", channel.name, part);
}

ExrPart exr_part(std::string_view name) {
    for (const Known& k : known)
        if (k.exr == name) return {std::string(k.channel), k.part};
    const size_t dot = name.rfind('.');
    if (dot == name.npos || dot == 0) return {std::string(name), 0};
    const std::string_view part = name.substr(dot + 1);
    if (part.size() == 1)
        for (const std::string_view letters : {colors, axes, small_colors})
            if (const size_t at = letters.find(part[0]); at != letters.npos)
                return {std::string(name.substr(0, dot)), int(at)};
    int number = 0;
    const auto [end, status] = std::from_chars(part.data(), part.data() + part.size(), number);
    if (status == std::errc() && end == part.data() + part.size() && number >= 0)
        return {std::string(name.substr(0, dot)), number};
    return {std::string(name), 0};
}

}  // namespace weft
