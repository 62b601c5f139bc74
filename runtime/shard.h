// A shard of a run, and the merge of all: what a part says, and a plan made again from it.
#pragma once
#include <string>
#include <vector>

#include "runtime/part_file.h"
#include "runtime/plan.h"
#include "runtime/provenance.h"

namespace weft {

// What the part of a shard says, but for the sizes of the divided tasks, which are known after the
// run. `plan` is one for a shard. The key is that of all that the divided tasks make.
PartHeader shard_header(const Plan& plan, const FilesRead& files, const Shard& shard, int tile);

// Options of the merge's plan, for the graph in the parts' header.
PlanOptions merge_options(const PartHeader& header);

// Throws Error if a file that the merge itself reads is not what it was for the shards.
void expect_same_files(const Plan& merge, const PartHeader& header);

}  // namespace weft
