#include <fmt/format.h>

#include "image/picture_file.h"

namespace weft {
namespace {

std::string line(std::string_view name, const std::string& value) {
    return value.empty() ? "" : fmt::format("  {:<12} {}\n", name, value);
}

}  // namespace

std::string to_text(const PictureInfo& info, const std::string& file) {
    std::string text = fmt::format("{}: {}, {} x {}\n", file, info.format, info.width, info.height);
    text += line("channels", fmt::format("{}", fmt::join(info.channels, " ")));
    text += line("depth", info.depth);
    text += line("compression", info.compression);
    text += line("parts", fmt::format("{}", fmt::join(info.parts, ", ")));
    text += line("colour space", info.color_space);
    text += line("display", info.display);
    text += line("view", info.view);
    for (const auto& [name, value] : info.attributes)
        if (!name.starts_with("weft:")) text += line(name, value);
    // Provenance last, the graph at the very end: it is long.
    for (const auto& [name, value] : info.attributes)
        if (name.starts_with("weft:") && name != "weft:graph") text += line(name, value);
    if (const auto graph = info.attributes.find("weft:graph"); graph != info.attributes.end()) {
        try {
            text += "  weft:graph\n" + parse_json_or_throw(graph->second, file).dump(true) + "\n";
        } catch (const std::exception&) {
            text += "  weft:graph\n" + graph->second + "\n";  // somebody changed it: shown as it is
        }
    }
    return text;
}

Json to_json(const PictureInfo& info, const std::string& file) {
    const auto list = [](const std::vector<std::string>& names) {
        Json items = Json::list();
        for (const std::string& name : names) items.items.emplace_back(name);
        return items;
    };
    Json json = Json::object();
    json.set("file", file);
    json.set("format", info.format);
    json.set("width", info.width);
    json.set("height", info.height);
    json.set("channels", list(info.channels));
    json.set("depth", info.depth);
    if (!info.compression.empty()) json.set("compression", info.compression);
    if (!info.parts.empty()) json.set("parts", list(info.parts));
    json.set("color_space", info.color_space);
    if (!info.display.empty()) json.set("display", info.display);
    if (!info.view.empty()) json.set("view", info.view);
    Json attributes = Json::object();
    for (const auto& [name, value] : info.attributes) attributes.set(name, value);
    json.set("attributes", std::move(attributes));
    return json;
}

}  // namespace weft
