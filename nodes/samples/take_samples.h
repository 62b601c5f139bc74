// Some samples of a buffer, in any order, channel by channel.
#pragma once
#include <cstdint>
#include <span>

#include "runtime/context.h"
#include "samples/samples.h"

namespace weft {

// The values of samples which[0], which[1] ... one after another; its name, components and role
// stay.
Channel take_samples(const Channel& from, std::span<const std::uint32_t> which, Context& ctx);

}  // namespace weft
