#include "light-field/sample_order.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>

namespace weft::light_field {

// Buckets by the leading bits, then each bucket by itself. Samples come pixel by pixel and keys
// follow the picture, so that neighbours go to the same few buckets: the scatter stays in the
// cache, as the passes of a plain radix sort would not.
LargeArray<std::uint32_t> sorted(LargeArray<std::uint64_t> keys, Context& ctx) {
    const size_t n = keys.size();
    if (n == 0) return {};
    const auto [least, most] = std::minmax_element(keys.begin(), keys.end());
    const std::uint64_t base = *least;
    const int bits = std::bit_width(*most - base);
    // About two samples for each bucket that there may be: most of them are empty.
    const int leading = std::min(bits, std::max({16, int(std::bit_width(n)) - 2, bits - 32}));
    const int rest = bits - leading;
    const auto bucket_of = [&](size_t i) { return size_t((keys[i] - base) >> rest); };
    const size_t buckets = size_t(1) << leading;
    constexpr size_t grain = 65536;

    LargeArray<std::uint32_t> end(buckets, 0);
    const auto next = [&](size_t bucket) {
        return std::atomic_ref(end[bucket]).fetch_add(1, std::memory_order_relaxed);
    };
    ctx.parallel_for(
        n, [&](size_t i) { next(bucket_of(i)); }, grain);
    std::uint32_t sum = 0;
    for (std::uint32_t& count : end) sum += std::exchange(count, sum);
    LargeArray<std::uint32_t> order(n);
    ctx.parallel_for(
        n, [&](size_t i) { order[next(bucket_of(i))] = std::uint32_t(i); }, grain);

    // Within a bucket the threads left them as they came; key and index together say where each
    // belongs.
    ctx.parallel(buckets, std::max<size_t>(buckets / 256, 1024), [&](size_t first, size_t last) {
        std::vector<std::uint64_t> here;
        for (size_t b = first; b < last; ++b) {
            const size_t from = b == 0 ? 0 : end[b - 1], count = end[b] - from;
            if (count < 2) continue;
            here.resize(count);
            for (size_t k = 0; k < count; ++k) {
                const std::uint32_t i = order[from + k];
                here[k] = (keys[i] - base) << 32 | i;  // what is cut off is common to the bucket
            }
            std::sort(here.begin(), here.end());
            for (size_t k = 0; k < count; ++k) order[from + k] = std::uint32_t(here[k]);
        }
    });
    return order;
}

}  // namespace weft::light_field
