// Taps: looking at any value, or at the records of a stream in some pixels, while a graph runs.
#pragma once
#include <mutex>
#include <string>
#include <vector>

#include "graph/json.h"
#include "runtime/plan.h"

namespace weft {

// "node.port=file", "node=file" (one output), "node.port@x,y=file", "node.port@x0,y0,x1,y1=file".
// Throws UsageError with what is wrong and what there is.
Tap parse_tap(const std::string& text, const Graph& graph);

// Writes a value as its type's saver says, or its arrays as JSON.
void write_tap(const Tap& tap, const TypeInfo& type, const void* value, Context& ctx);

// Gathers a stream's records for the pixels of a tap; safe to call from several workers. The file
// lists them by pixel, then in the order of the stream, whatever the threads and tiles were.
class StreamTap {
  public:
    StreamTap(Tap tap, int width) : tap_(std::move(tap)), width_(width) {}
    const Tap& tap() const { return tap_; }
    void take(const TypeInfo& type, const void* object, const Batch& batch, size_t serial);
    void write();  // JSON: {"tap", "records": [{"x", "y", fields ..., children: {...}}]}

  private:
    struct Record {
        std::uint32_t pixel;
        size_t serial, index;
        Json fields;
    };
    Tap tap_;
    int width_;
    std::mutex mutex_;
    std::vector<Record> records_;
};

}  // namespace weft
