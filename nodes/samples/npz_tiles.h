// NpzTiles: a native sample file (docs/formats.md) written in any order of its samples, so that a
// buffer need never be held whole. Once closed it is a file like any other.
#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "runtime/atomic_file.h"
#include "runtime/context.h"
#include "samples/samples.h"
#include "samples/zip_writer.h"

namespace weft {

class NpzTiles {
  public:
    struct Member {
        std::string name;
        int components = 1;
        bool whole = false;
    };
    // `head`: size, spp, lens, meta as the whole buffer has them, without channels. Where spp is 0
    // the counts of pixels are written by write_counts().
    NpzTiles(const std::string& path, const Samples& head, std::vector<Member> channels);

    bool adaptive() const { return head_.spp == 0; }
    // Values of channel `channel` from sample `first` on. Threads: any.
    void write(size_t channel, std::uint64_t first, std::span<const float> values);
    void write(size_t channel, std::uint64_t first, std::span<const std::uint32_t> values);
    void write_counts(std::uint64_t first_pixel, std::span<const std::uint32_t> counts);
    // Checksums, meta with the run's provenance, directory; then the file gets its name.
    void close(Context& ctx);

  private:
    Samples head_;
    std::vector<Member> channels_;
    AtomicFile file_;
    ZipWriter zip_;
    std::vector<ZipWriter::Reserved> members_;  // of channels, then of counts
};

}  // namespace weft
