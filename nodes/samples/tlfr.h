// TLFR 1.3, the sample files of the code published with Lehtinen et al. 2011: records of 16 floats
//   x y z/w w  u v t  r g b a  mv_x mv_y mv_w  dwdx dwdy
// w is our z, mv our motion; z/w and a are not looked at (written as 0 and 1). A depth of 1e10 is
// +inf. uv, t and motion that are all 0 are no channels.
#pragma once
#include "samples/record_file.h"
#include "samples/sample_file.h"

namespace weft {

Samples read_tlfr(const RecordFiles& files, const RecordHeader& header, const ReadOptions& options,
                  Context& ctx);
void write_tlfr(const Samples& samples, const std::string& path, bool text, Context& ctx);

}  // namespace weft
