// Pictures on disk: one way in and one way out, whatever the format. EXR and PNG are read and
// written here (OpenEXR, libpng), PFM too; every other format by the OpenImageIO module, which is
// loaded when the first such picture is met. Formats are told apart by content on reading, by
// extension on writing.
//   colour   Image::color_space from the file's own words ("oiio:ColorSpace", chromaticities, PNG's
//            colour chunks); scene-linear Rec.709 for EXR, sRGB for the rest where it says nothing
//   alpha    premultiplied in memory, as EXR has it; PNG's is not and is converted
// Errors are weft::Error and name the file. Writing is atomic (runtime/atomic_file.h), makes
// missing folders, and gives the same bytes for the same picture and options.
#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "graph/json.h"
#include "image/image.h"
#include "runtime/node.h"

namespace weft {

enum class Depth { automatic, half, single, u8, u16 };  // automatic: what the extension suggests
enum class Compression { automatic, none, rle, zips, zip, piz, pxr24, b44, b44a, dwaa, dwab };

struct PictureOptions {
    Depth depth = Depth::automatic;  // EXR float; PNG, JPEG 8; others what they can hold
    Compression compression = Compression::automatic;  // EXR: zip
    int level = 0;          // of zip, dwa and PNG; 0: the format's default
    int quality = 92;       // of JPEG, WebP ...
    Provenance provenance;  // written where not empty
};

// `warnings` gets what could not be held ("channels Z not written"), one sentence each.
void write_picture(const std::string& path, const Image& image, const PictureOptions& options,
                   std::vector<std::string>& warnings);

struct ReadPicture {
    std::string part;         // of a multi-part EXR: its name; empty: the first
    std::string color_space;  // instead of what the file says
};
Image read_picture(const std::string& path, const ReadPicture& options = {});
// From memory (a texture inside another file); `file` is what messages call it.
Image decode_picture(std::string_view bytes, const std::string& file,
                     const ReadPicture& options = {});

// What a file holds, without its pixels where the format allows it (`weft show`).
struct PictureInfo {
    std::string format;  // "EXR", "PNG", "tiff" ...
    int width = 0, height = 0;
    std::vector<std::string> channels;
    std::string depth, compression;  // "half", "float", "8 bit", "mixed"; "zip"
    std::vector<std::string> parts;  // names, of a multi-part file
    std::string color_space, display, view;
    std::map<std::string, std::string> attributes;  // "weft:graph" and the like among them
};

PictureInfo picture_info(const std::string& path);
// Its size in memory by the header of an EXR or PNG; zeros where it cannot be told at once.
Shape picture_shape(const std::string& path);
// As lines of text, the graph of its provenance last; as JSON with every attribute.
std::string to_text(const PictureInfo& info, const std::string& file);
Json to_json(const PictureInfo& info, const std::string& file);

// Whether a file's first bytes are those of an EXR or PNG picture (which may carry provenance).
bool is_exr_or_png(std::string_view bytes);

// Extensions that can be written, for messages: "exr, png, pfm, tif ...".
std::string writable_extensions();

// The file's bytes; Error naming it where it cannot be read.
std::string read_whole_file(const std::string& path);

}  // namespace weft
