// Gives back the pages of a mapped sample file while it is passed through once in some order: as what
// is made of it grows, it goes, and both together need no more memory than one and a half.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "samples/file_bytes.h"
#include "samples/samples.h"

namespace weft::light_field {

class PagesDone {
  public:
    explicit PagesDone(const Samples& samples)
        : samples_(samples), left_((samples.size() + stretch - 1) / stretch) {
        for (size_t k = 0; k < left_.size(); ++k)
            left_[k] = std::uint32_t(std::min(stretch, samples.size() - k * stretch));
    }

    // These samples, each of them once in all, are not looked at any more. Any thread may say so.
    void done(std::span<const std::uint32_t> samples) {
        for (size_t i = 0, end; i < samples.size(); i = end) {
            const size_t k = samples[i] / stretch;
            for (end = i + 1; end < samples.size() && samples[end] / stretch == k;) ++end;
            const auto count = std::uint32_t(end - i);
            if (left_[k].fetch_sub(count, std::memory_order_relaxed) == count) forget(k);
        }
    }

  private:
    static constexpr size_t stretch = 65536;  // samples that go together

    void forget(size_t k) const {
        const size_t begin = k * stretch, end = std::min(begin + stretch, samples_.size());
        for (const Channel& channel : samples_.channels) {
            if (channel.whole()) continue;
            const auto n = size_t(channel.components);
            forget_pages(channel.values.view().subspan(begin * n, (end - begin) * n));
        }
    }

    const Samples& samples_;
    std::vector<std::atomic<std::uint32_t>> left_;
};

}  // namespace weft::light_field
