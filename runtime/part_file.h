// Part files: what a shard made, for the merge. A part that is there under its name is whole: it is written
// under a temporary name and renamed. Layout, little-endian:
//
//   "WEFTPRT1"   records, one a tile and sink or a piece   directory, one Entry a record   header, JSON
//   Trailer: where the directory starts, how many entries, bytes of the header, XXH3 of both, "WEFTEND1"
//
// The header says what the part is of: shard, key, tile size, instruction set, program version, the flattened
// graph and its inputs, and of each divided task its name, extent, number of items and sinks.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "runtime/atomic_file.h"
#include "runtime/bytes.h"
#include "runtime/context.h"
#include "runtime/node.h"

namespace weft {

// One of `count` shards, counted from 1. It does the items (tiles, pieces) i with i % count == index - 1.
struct Shard {
    int index = 1, count = 1;
    bool has(size_t item) const { return item % size_t(count) == size_t(index - 1); }
    std::string text() const;  // "2/5"
    bool operator==(const Shard&) const = default;
};
Shard parse_shard(const std::string& text);  // "2/5"; throws UsageError

struct DividedTask {
    std::string node, name;          // its first node; as the plan calls it
    Extent extent;                   // of a segment
    std::uint64_t items = 0;         // tiles or pieces, of all shards
    std::vector<std::string> sinks;  // of a segment: in the order of their records; empty: pieces
    std::uint64_t records_of(std::uint64_t item_count) const { return item_count * std::max<size_t>(sinks.size(), 1); }
    bool operator==(const DividedTask& other) const;
};

struct PartHeader {
    Shard shard;
    std::string key;                          // of what all shards make together
    int tile = 32;
    std::string isa;
    Provenance provenance;
    std::string graph_name;                   // for messages
    std::map<std::string, std::string> files; // graph parameters that names of written files are made of, as they were set
    std::map<std::string, Shape> shapes;      // of outputs, for the merge's plan
    std::vector<DividedTask> tasks;
};

struct PartEntry {
    std::uint32_t task = 0, sink = 0;
    std::uint64_t item = 0, offset = 0, size = 0, hash = 0;
};

class PartWriter {
  public:
    explicit PartWriter(const std::string& path);
    ~PartWriter();
    // Threads: may be called by several at once.
    void add(std::uint32_t task, std::uint32_t sink, std::uint64_t item, std::span<const std::byte> bytes);
    void finish(const PartHeader& header);

  private:
    void write(const void* from, size_t size);
    AtomicFile file_;
    int out_ = -1;
    std::mutex mutex_;
    std::uint64_t at_ = 0;
    std::vector<PartEntry> entries_;
};

class PartFile {
  public:
    // Reads header and directory. Throws Error naming the file and what is wrong with it.
    explicit PartFile(const std::string& path);
    ~PartFile();
    PartFile(const PartFile&) = delete;
    PartFile& operator=(const PartFile&) = delete;

    const std::string& path() const { return path_; }
    const PartHeader& header() const { return header_; }
    // Throws Error if it is not there or damaged. Threads: any.
    ByteReader read(std::uint32_t task, std::uint32_t sink, std::uint64_t item) const;
    bool has(std::uint32_t task, std::uint32_t sink, std::uint64_t item) const;
    const std::vector<PartEntry>& entries() const { return entries_; }

  private:
    [[noreturn]] void damaged(const std::string& what) const;
    std::vector<std::byte> bytes(std::uint64_t offset, std::uint64_t size) const;
    const PartEntry* find(std::uint32_t task, std::uint32_t sink, std::uint64_t item) const;
    std::string path_;
    int in_ = -1;
    std::uint64_t size_ = 0;
    PartHeader header_;
    std::vector<PartEntry> entries_;  // sorted by task, sink, item
};

// All parts of one run: one of each shard, of the same key, graph, tiles, instruction set and program.
class Parts {
  public:
    // Throws Error naming the part that is missing, double, foreign or damaged.
    explicit Parts(const std::vector<std::string>& paths);
    const PartHeader& header() const { return files_.front()->header(); }  // of the first shard
    ByteReader read(std::uint32_t task, std::uint32_t sink, std::uint64_t item) const;
    const std::string& path_of(std::uint64_t item) const { return files_[item % files_.size()]->path(); }

  private:
    std::vector<std::unique_ptr<PartFile>> files_;  // by shard
};

}  // namespace weft
