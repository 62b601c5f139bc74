// How the module weft_oiio opens pictures: from memory where OpenImageIO can, and what it says in
// our words. Only files of that module include this.
#pragma once
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "graph/error.h"

namespace weft {

// What OpenImageIO 2.4 calls a space, in our names.
inline std::string from_oiio(std::string_view space, bool whole_numbers) {
    if (space == "sRGB") return "sRGB - Texture";
    if (space == "Linear" || space == "linear" || space == "scene_linear") return "lin_rec709";
    if (space == "Rec709") return "Rec.709";
    if (!space.empty()) return std::string(space);
    return whole_numbers ? "sRGB - Texture" : "lin_rec709";
}

// OpenImageIO's own words on one line; it sometimes has none.
inline std::string told(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == '.')) text.pop_back();
    for (char& letter : text)
        if (letter == '\n') letter = ' ';
    return text.empty() ? "the file is damaged or ends too early" : text;
}

struct Opened {
    std::unique_ptr<OIIO::ImageInput> input;
    std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;
    ~Opened() { input.reset(); }  // before the memory it reads
};

// `unassociated`: colour as it was before it was multiplied by alpha, where the file has it so.
inline void open(std::string_view bytes, const std::string& file, Opened& opened,
                 bool unassociated = false) {
    OIIO::ImageSpec wishes;
    if (unassociated) wishes.attribute("oiio:UnassociatedAlpha", 1);
    // From memory where the format can, else from the file itself if that is what we were given.
    opened.memory = std::make_unique<OIIO::Filesystem::IOMemReader>(const_cast<char*>(bytes.data()),
                                                                    bytes.size());
    OIIO::Filesystem::IOProxy* memory = opened.memory.get();
    OIIO::ImageSpec from_memory = wishes;
    from_memory.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &memory);
    opened.input = OIIO::ImageInput::open(file, &from_memory, memory);
    if (opened.input) return;
    const std::string reason = OIIO::geterror();
    opened.memory.reset();
    if (std::filesystem::exists(file)) opened.input = OIIO::ImageInput::open(file, &wishes);
    if (opened.input) return;
    const std::string second = OIIO::geterror();
    throw Error(fmt::format("{}: not a picture that can be read: {}", file,
                            told(second.empty() ? reason : second)));
}

}  // namespace weft
