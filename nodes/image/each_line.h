// Loops over the rows, or the columns, of a picture that takes long: each is a piece of its own,
// cancellation is asked about before it, and progress told of after it.
#pragma once
#include <algorithm>
#include <atomic>
#include <string_view>

#include "runtime/context.h"

namespace weft {

// work(line) for each of [0, count), `unit` what they are.
template <class Work>
void each_line(Context& ctx, int count, std::string_view unit, Work&& work) {
    std::atomic<int> done = 0;
    ctx.parallel_for(size_t(std::max(count, 0)), [&](size_t line) {
        ctx.check_cancelled();
        work(int(line));
        ctx.progress(++done, count, unit);
    });
}

}  // namespace weft
