#include "samples/drop_samples.h"

#include <algorithm>

namespace weft {
namespace {

template <class T>
Array<T> without(const Array<T>& values, size_t components, std::span<const size_t> dropped) {
    std::vector<T> kept;
    kept.reserve(values.size() - dropped.size() * components);
    const T* from = values.view().data();
    size_t begin = 0;
    for (const size_t sample : dropped) {
        kept.insert(kept.end(), from + begin * components, from + sample * components);
        begin = sample + 1;
    }
    kept.insert(kept.end(), from + begin * components, from + values.size());
    return kept;
}

}  // namespace

size_t pixel_of(const Samples& samples, size_t sample) {
    if (samples.spp > 0) return sample / size_t(samples.spp);
    const auto first = samples.first.view();
    const auto after = std::upper_bound(first.begin(), first.end(), std::uint64_t(sample));
    return size_t(after - first.begin()) - 1;
}

void drop_samples(Samples& samples, std::span<const size_t> dropped) {
    if (dropped.empty()) return;
    if (samples.domain != "light") {
        std::vector<std::uint64_t> first(samples.pixels() + 1);
        size_t gone = 0;
        for (size_t pixel = 0; pixel < samples.pixels(); ++pixel) {
            const Samples::Range range = samples.of_pixel(pixel);
            first[pixel] = range.begin - gone;
            while (gone < dropped.size() && dropped[gone] < range.end) ++gone;
        }
        first.back() = samples.size() - dropped.size();
        samples.first = std::move(first);
    }
    samples.spp = 0;
    for (Channel& c : samples.channels) {
        if (c.whole())
            c.ids = without(c.ids, size_t(c.components), dropped);
        else
            c.values = without(c.values, size_t(c.components), dropped);
    }
    samples.set_size(samples.size() - dropped.size());
}

}  // namespace weft
