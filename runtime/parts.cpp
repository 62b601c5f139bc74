// The parts of one run, held against each other.
#include <fmt/format.h>

#include <charconv>

#include "runtime/part_file.h"
#include "runtime/plan.h"
#include "runtime/provenance.h"

namespace weft {
namespace {

// Throws if the two cannot be of one run.
void expect_same_run(const PartFile& a, const PartFile& b) {
    const PartHeader &first = a.header(), &second = b.header();
    const auto fail = [&](const std::string& what) {
        throw Error(fmt::format("{}: is not of the same run as {}: {}", b.path(), a.path(), what));
    };
    if (first.provenance.version != second.provenance.version)
        fail(fmt::format("made by weft {}, the other by weft {}", second.provenance.version,
                         first.provenance.version));
    if (first.isa != second.isa)
        fail(
            fmt::format("made with instruction set {0}, the other with {1}: their last digits "
                        "differ; make it again with --isa {1}",
                        second.isa, first.isa));
    if (first.shard.count != second.shard.count)
        fail(fmt::format("shard {}, the other {}", second.shard.text(), first.shard.text()));
    if (first.tile != second.tile)
        fail(fmt::format("tiles of {0} pixels, the other of {1}; make it again with --tile {1}",
                         second.tile, first.tile));
    if (first.key != second.key)
        fail(first.provenance.graph != second.provenance.graph
                 ? "made of another graph, or with other parameters"
                 : "made of other input files");
    if (first.provenance.graph != second.provenance.graph) fail("made of another graph");
    if (first.tasks != second.tasks) fail("its tasks have another size");
}

void expect_all_items(const PartFile& part) {
    const PartHeader& header = part.header();
    for (size_t t = 0; t < header.tasks.size(); ++t) {
        const DividedTask& task = header.tasks[t];
        for (std::uint64_t item = std::uint64_t(header.shard.index - 1); item < task.items;
             item += std::uint64_t(header.shard.count))
            for (size_t sink = 0; sink < std::max<size_t>(task.sinks.size(), 1); ++sink)
                if (!part.has(std::uint32_t(t), std::uint32_t(sink), item))
                    throw Error(
                        fmt::format("{}: is damaged: tile or piece {} of '{}' is not in it; make "
                                    "this part again",
                                    part.path(), item, task.name));
    }
}

}  // namespace

std::string Shard::text() const {
    return fmt::format("{}/{}", index, count);
}

Shard parse_shard(const std::string& text) {
    Shard shard{0, 0};
    const char* end = text.data() + text.size();
    const auto first = std::from_chars(text.data(), end, shard.index);
    if (first.ec == std::errc() && first.ptr != end && *first.ptr == '/') {
        const auto second = std::from_chars(first.ptr + 1, end, shard.count);
        if (second.ec == std::errc() && second.ptr == end && shard.index >= 1 &&
            shard.index <= shard.count && shard.count <= 1 << 20)
            return shard;
    }
    throw UsageError(fmt::format("--shard {}: expected I/N with I from 1 to N, as in 2/5", text));
}

Parts::Parts(const std::vector<std::string>& paths) {
    if (paths.empty())
        throw UsageError("no parts named; name the files that 'weft run --shard' wrote");
    std::vector<std::unique_ptr<PartFile>> read;
    for (const std::string& path : paths) {
        read.push_back(std::make_unique<PartFile>(path));
        const PartHeader& header = read.back()->header();
        if (header.provenance.version != program_version)
            throw Error(fmt::format(
                "{}: made by weft {}, this is {}; make and merge parts with one version", path,
                header.provenance.version, program_version));
        expect_same_run(*read.front(), *read.back());
        expect_all_items(*read.back());
    }
    files_.resize(size_t(read.front()->header().shard.count));
    for (auto& part : read) {
        auto& place = files_[size_t(part->header().shard.index - 1)];
        if (place)
            throw Error(fmt::format("{} and {} are both shard {}; name one of each", place->path(),
                                    part->path(), part->header().shard.text()));
        place = std::move(part);
    }
    std::vector<std::string> missing;
    for (size_t i = 0; i < files_.size(); ++i)
        if (!files_[i]) missing.push_back(Shard{int(i + 1), int(files_.size())}.text());
    if (!missing.empty())
        throw Error(
            fmt::format("{} of {} parts are missing: shard {}; make them with 'weft run ... "
                        "--shard I/{}', or name them too",
                        missing.size(), files_.size(), fmt::join(missing, ", "), files_.size()));
}

ByteReader Parts::read(std::uint32_t task, std::uint32_t sink, std::uint64_t item) const {
    return files_[item % files_.size()]->read(task, sink, item);
}

}  // namespace weft
