// Provenance: what a written file says of the run that made it; and what the files are that a plan reads.
#pragma once
#include <map>
#include <string>

#include "runtime/context.h"
#include "runtime/plan.h"

namespace weft {

extern const char* const program_version;  // "0.1.0"

// XXH3 of a file's content, 16 hex digits. Of a zip (.npz) its directory is hashed: the names, sizes and
// checksums of the members. Throws Error.
std::string content_hash(const std::string& path);

// Every file that the graph reads, hashed once: those its parameters name and those its nodes name
// (reads()). A file that is not there is left to the node that reads it; "analytic:..." and other names
// that are no files are listed as they are, without a hash.
struct FileContent {
    std::uint64_t size = 0;
    std::string hash;  // "": no such file
};
using FilesRead = std::map<std::string, FileContent>;
FilesRead files_read(const Plan& plan);
// Those that one node reads.
std::vector<std::string> files_of(const Plan& plan, int node);

// The flattened graph; path, size and content hash of every file it reads.
Provenance make_provenance(const Plan& plan, const FilesRead& files);
inline Provenance make_provenance(const Plan& plan) { return make_provenance(plan, files_read(plan)); }

}  // namespace weft
