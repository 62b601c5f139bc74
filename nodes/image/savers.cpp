// How pictures and tables are written when a port is tapped (--tap node.port=file).
#include "image/picture_file.h"
#include "image/table.h"
#include "runtime/atomic_file.h"
#include "runtime/registry.h"

namespace weft {
namespace {

void save_image(const void* value, const std::string& path, Context& ctx) {
    std::vector<std::string> warnings;
    PictureOptions options;
    options.provenance = ctx.provenance();
    write_picture(path, *static_cast<const Image*>(value), options, warnings);
    for (const std::string& warning : warnings) ctx.warn(path + ": " + warning);
}

void save_table(const void* value, const std::string& path, Context&) {
    write_file(path, table_as(*static_cast<const Table*>(value), path));
}

[[maybe_unused]] const bool registered =
    register_saver("Image", save_image) && register_saver("Table", save_table);

}  // namespace
}  // namespace weft
