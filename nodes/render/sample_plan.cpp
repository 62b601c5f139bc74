#include "render/sample_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/error.h"

namespace weft::render {

SamplePlan::SamplePlan(const Image& counts) : width_(counts.width()), height_(counts.height()) {
    first_.reserve(size_t(width_) * size_t(height_) + 1);
    first_.push_back(0);
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
            const float value = counts.at(x, y)[0];
            if (!(value >= 0 && value <= float(1 << 20)))
                throw Error(
                    fmt::format("'counts' asks for {} samples in pixel ({}, {}); expected 0 to {}",
                                value, x, y, 1 << 20));
            first_.push_back(first_.back() + std::uint64_t(std::lround(value)));
        }
}

bool BatchCursor::next(std::vector<PixelRun>& runs) {
    runs.clear();
    size_t samples = 0;
    while (plan_ && y_ < box_.y1 && x_ < box_.x1) {
        const auto spp = std::uint32_t(plan_->of(x_, y_));
        const std::uint32_t end = count_ < spp - std::min(begin_, spp) ? begin_ + count_ : spp;
        while (at_ < end) {
            if (samples >= samples_in_batch) return true;
            // Up to the end of a packet beyond what the batch still holds.
            const std::uint32_t room = std::uint32_t(samples_in_batch - samples);
            std::uint32_t to =
                (at_ + room + samples_in_packet - 1) / samples_in_packet * samples_in_packet;
            to = std::min(to, end);
            runs.push_back({x_, y_, at_, to - at_, int(spp)});
            samples += to - at_;
            at_ = to;
        }
        at_ = begin_;
        if (++x_ == box_.x1) x_ = box_.x0, ++y_;
    }
    return !runs.empty();
}

void RenderWorkers::with(const std::function<void(RenderWorker&)>& work) {
    std::unique_ptr<RenderWorker> worker;
    {
        const std::lock_guard lock(mutex_);
        if (!idle_.empty()) {
            worker = std::move(idle_.back());
            idle_.pop_back();
        }
    }
    if (!worker) {
        worker = std::make_unique<RenderWorker>();
        worker->workspace = tracer_.workspace();
    }
    work(*worker);
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(worker));
}

RenderStatistics RenderWorkers::statistics() const {
    const std::lock_guard lock(mutex_);
    RenderStatistics sum;
    for (const auto& worker : idle_) sum.add(PathTracer::statistics(*worker->workspace));
    return sum;
}

}  // namespace weft::render
