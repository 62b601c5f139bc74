// SamplePlan: how many samples each pixel of a picture gets, and where a pixel's begin; and how a
// rectangle of pixels is cut into batches for the path tracer.
#pragma once
#include <functional>
#include <mutex>

#include "image/image.h"
#include "render/path_tracer.h"

namespace weft::render {

class SamplePlan {
  public:
    SamplePlan() = default;
    // The same in each pixel.
    SamplePlan(int width, int height, int spp) : width_(width), height_(height), spp_(spp) {}
    // By the first channel of a picture, rounded; Error where it is no such number.
    explicit SamplePlan(const Image& counts);

    int width() const { return width_; }
    int height() const { return height_; }
    int spp() const { return spp_; }  // 0: they vary
    int of(int x, int y) const {
        if (spp_ > 0) return spp_;
        const size_t pixel = size_t(y) * size_t(width_) + size_t(x);
        return int(first_[pixel + 1] - first_[pixel]);
    }
    std::uint64_t first(int x, int y) const {
        const size_t pixel = size_t(y) * size_t(width_) + size_t(x);
        return spp_ > 0 ? pixel * std::uint64_t(spp_) : first_[pixel];
    }
    std::uint64_t samples() const {
        if (spp_ == 0) return first_.empty() ? 0 : first_.back();
        return std::uint64_t(width_) * std::uint64_t(height_) * std::uint64_t(spp_);
    }
    const std::vector<std::uint64_t>& offsets() const { return first_; }  // empty where spp() > 0

  private:
    int width_ = 0, height_ = 0, spp_ = 0;
    std::vector<std::uint64_t> first_;
};

struct PixelBox {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

// Samples a batch holds at most, but for the rest of a packet.
inline constexpr size_t samples_in_batch = 1024;

// Goes through the samples of a box in batches, pixel by pixel in rows.
class BatchCursor {
  public:
    // Samples [first, first + count) of each pixel, of those it has.
    BatchCursor(const SamplePlan& plan, PixelBox box, std::uint32_t first = 0,
                std::uint32_t count = 0xffffffff)
        : plan_(&plan),
          box_(box),
          begin_(first),
          count_(count),
          x_(box.x0),
          y_(box.y0),
          at_(first) {}
    BatchCursor() = default;
    // Fills `runs` with the next batch; false where there is none.
    bool next(std::vector<PixelRun>& runs);

  private:
    const SamplePlan* plan_ = nullptr;
    PixelBox box_;
    std::uint32_t begin_ = 0, count_ = 0;
    int x_ = 0, y_ = 0;
    std::uint32_t at_ = 0;  // sample of pixel (x_, y_)
};

// Workers' memory, kept while a node runs.
struct RenderWorker {
    PathWorkspacePointer workspace;
    SampleBatch batch;
    std::vector<PixelRun> runs;
};
class RenderWorkers {
  public:
    explicit RenderWorkers(const PathTracer& tracer) : tracer_(tracer) {}
    // Runs work(worker) with a worker that nobody else has.
    void with(const std::function<void(RenderWorker&)>& work);
    RenderStatistics statistics() const;

  private:
    const PathTracer& tracer_;
    mutable std::mutex mutex_;
    std::vector<std::unique_ptr<RenderWorker>> idle_;
};

}  // namespace weft::render
