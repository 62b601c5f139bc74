// OtherFormats: the pictures that OpenImageIO reads and writes for us. It lives in a module of its
// own, weft_oiio.so, because loading OpenImageIO takes a third of a second: longer than most
// graphs.
#pragma once
#include "image/picture_file.h"

namespace weft {

class OtherFormats {
  public:
    virtual ~OtherFormats() = default;
    // `file` is what messages call it; bytes are told apart by content, then by the file's
    // extension.
    virtual Image decode(std::string_view bytes, const std::string& file) const = 0;
    virtual PictureInfo info(std::string_view bytes, const std::string& file) const = 0;
    // The file's bytes in the format of `extension`.
    virtual std::string encode(const std::string& extension, const Image& image,
                               const PictureOptions& options,
                               std::vector<std::string>& warnings) const = 0;
};

// Loads the module once. It is looked for in $WEFT_MODULES, beside Weft's libraries, and in the
// folder weft/ there. Error naming these places where it is not found; `what` is the picture that
// needs it.
const OtherFormats& other_formats(const std::string& what);
// Another entry of the module, by its name.
void* oiio_entry(const std::string& what, const char* name);

// What the module writes, known without loading it.
const std::vector<std::string>& other_extensions();

}  // namespace weft

// The module's one entry.
extern "C" const weft::OtherFormats* weft_other_formats();
