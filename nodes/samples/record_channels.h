// Channels of samples from and to the columns of records (TLFR, ILFR).
#pragma once
#include <initializer_list>
#include <string>

#include "samples/record_file.h"
#include "samples/sample_file.h"

namespace weft {

class Context;

// Depth that stands for +inf; the motion beside it is 0.
constexpr float record_infinity = 1e10f;

// What a header says, and as many samples; no channels yet.
Samples samples_of_header(const RecordHeader& header);

// Columns [first, first + components) of records of `width` floats.
Array<float> columns(const Array<float>& records, size_t width, size_t first, size_t components,
                     Context& ctx);

// Depths of 1e10 and more become +inf.
void restore_infinite_depth(std::vector<float>& z);

// Takes out what says nothing: uv that are all 0 of a pinhole, t and motion that are all 0, a
// z_gradient that is all 0.
void drop_idle_channels(Samples& samples);

// Throws Error if there are no pixels or their samples vary; warns of what is not among `held`:
// other channels, a lens that is not round, another colour space.
void check_record_writable(const Samples& samples, const std::string& path, SampleFormat format,
                           std::initializer_list<std::string_view> held, Context& ctx);

}  // namespace weft
