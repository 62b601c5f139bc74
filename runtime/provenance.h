// Provenance: what a written file says of the run that made it.
#pragma once
#include "graph/graph.h"
#include "runtime/context.h"

namespace weft {

extern const char* const program_version;  // "0.1.0"

// The flattened graph; path, size and content hash of every file it reads. A file that is not there
// is left to the node that reads it. "analytic:..." and other names that are no files are listed as they are.
Provenance make_provenance(const Graph& graph);

// XXH3 of a file's content, 16 hex digits. Of a zip (.npz) its directory is hashed: the names, sizes and
// checksums of the members. Throws Error.
std::string content_hash(const std::string& path);

}  // namespace weft
