#include "samples/take_samples.h"

#include <algorithm>
#include <memory>

#include "runtime/large_array.h"

namespace weft {
namespace {

template <class T>
Array<T> take(std::span<const T> from, size_t components, std::span<const std::uint32_t> which,
              Context& ctx) {
    const auto to = std::make_shared<LargeArray<T>>(which.size() * components);
    ctx.parallel_for(
        which.size(),
        [&](size_t i) {
            std::copy_n(from.data() + size_t(which[i]) * components, components,
                        to->data() + i * components);
        },
        8192);
    return {std::span<const T>(*to), to};
}

}  // namespace

Channel take_samples(const Channel& from, std::span<const std::uint32_t> which, Context& ctx) {
    Channel to{from.name, from.components, from.role, {}, {}};
    const auto components = size_t(from.components);
    if (from.whole())
        to.ids = take(from.ids.view(), components, which, ctx);
    else
        to.values = take(from.values.view(), components, which, ctx);
    return to;
}

}  // namespace weft
