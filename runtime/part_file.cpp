#include "runtime/part_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <tuple>

#include "graph/json.h"
#include "runtime/part_header.h"

namespace weft {
namespace {

constexpr char magic[8] = {'W', 'E', 'F', 'T', 'P', 'R', 'T', '1'};
constexpr char end_magic[8] = {'W', 'E', 'F', 'T', 'E', 'N', 'D', '1'};

struct Trailer {
    std::uint64_t directory = 0, entries = 0, header = 0, hash = 0;
    char magic[8] = {};
};

std::uint64_t hash_of(const void* bytes, size_t size) {
    return XXH3_64bits(bytes, size);
}

auto place(const PartEntry& entry) {
    return std::tuple(entry.task, entry.sink, entry.item);
}

}  // namespace

PartWriter::PartWriter(const std::string& path) : file_(path) {
    out_ = ::open(file_.temporary().c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC);
    if (out_ < 0) throw Error(fmt::format("{}: cannot write it: {}", path, std::strerror(errno)));
    write(magic, sizeof magic);
}

PartWriter::~PartWriter() {
    if (out_ >= 0) ::close(out_);
}

void PartWriter::write(const void* from, size_t size) {
    const char* bytes = static_cast<const char*>(from);
    while (size > 0) {
        const ssize_t wrote = ::write(out_, bytes, size);
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote <= 0)
            throw Error(fmt::format("{}: cannot write it: {}", file_.path(), std::strerror(errno)));
        bytes += wrote;
        size -= size_t(wrote);
        at_ += std::uint64_t(wrote);
    }
}

void PartWriter::add(std::uint32_t task, std::uint32_t sink, std::uint64_t item,
                     std::span<const std::byte> bytes) {
    const std::uint64_t hash = hash_of(bytes.data(), bytes.size());
    const std::lock_guard lock(mutex_);
    entries_.push_back({task, sink, item, at_, bytes.size(), hash});
    write(bytes.data(), bytes.size());
}

void PartWriter::finish(const PartHeader& header) {
    const std::lock_guard lock(mutex_);
    std::sort(entries_.begin(), entries_.end(),
              [](const PartEntry& a, const PartEntry& b) { return place(a) < place(b); });
    Trailer trailer;
    trailer.directory = at_;
    trailer.entries = entries_.size();
    std::string tail(reinterpret_cast<const char*>(entries_.data()),
                     entries_.size() * sizeof(PartEntry));
    const std::string text = to_json(header).dump();
    trailer.header = text.size();
    tail += text;
    trailer.hash = hash_of(tail.data(), tail.size());
    std::memcpy(trailer.magic, end_magic, sizeof end_magic);
    write(tail.data(), tail.size());
    write(&trailer, sizeof trailer);
    if (::close(std::exchange(out_, -1)) != 0)
        throw Error(fmt::format("{}: cannot write it: {}", file_.path(), std::strerror(errno)));
    file_.commit();
}

PartFile::PartFile(const std::string& path) : path_(path) {
    in_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (in_ < 0)
        throw Error(fmt::format("{}: cannot open it to read: {}", path, std::strerror(errno)));
    try {
        struct stat info {};
        if (::fstat(in_, &info) != 0 || !S_ISREG(info.st_mode))
            throw Error(fmt::format("{}: is no file", path));
        size_ = std::uint64_t(info.st_size);
        if (size_ < sizeof magic ||
            std::memcmp(bytes(0, sizeof magic).data(), magic, sizeof magic) != 0)
            throw Error(fmt::format(
                "{}: is no part of a run; expected a file that 'weft run --shard' wrote", path));
        if (size_ < sizeof magic + sizeof(Trailer)) damaged("it is cut short");
        Trailer trailer;
        std::memcpy(&trailer, bytes(size_ - sizeof trailer, sizeof trailer).data(), sizeof trailer);
        if (std::memcmp(trailer.magic, end_magic, sizeof end_magic) != 0)
            damaged("it is cut short");
        const std::uint64_t tail = size_ - sizeof trailer - trailer.directory;
        if (trailer.directory < sizeof magic || trailer.directory > size_ - sizeof trailer ||
            trailer.header > tail || (tail - trailer.header) % sizeof(PartEntry) != 0 ||
            (tail - trailer.header) / sizeof(PartEntry) != trailer.entries)
            damaged("its directory does not fit");
        const std::vector<std::byte> read = bytes(trailer.directory, tail);
        if (hash_of(read.data(), read.size()) != trailer.hash)
            damaged("its directory has another checksum");
        entries_.resize(trailer.entries);
        if (!entries_.empty())
            std::memcpy(entries_.data(), read.data(), entries_.size() * sizeof(PartEntry));
        for (size_t i = 0; i < entries_.size(); ++i) {
            const PartEntry& e = entries_[i];
            if (e.offset > trailer.directory || e.size > trailer.directory - e.offset)
                damaged("a record lies outside the file");
            if (i > 0 && place(entries_[i - 1]) >= place(e))
                damaged("its directory is out of order");
        }
        const std::string_view text(
            reinterpret_cast<const char*>(read.data()) + entries_.size() * sizeof(PartEntry),
            trailer.header);
        header_ = part_header(text, path);
        for (const DividedTask& task : header_.tasks)
            if (task.items / std::uint64_t(header_.shard.count) > entries_.size())
                damaged("it holds less than its header says");
    } catch (...) {
        ::close(in_);
        throw;
    }
}

PartFile::~PartFile() {
    ::close(in_);
}

void PartFile::damaged(const std::string& what) const {
    throw Error(fmt::format("{}: is damaged: {}; make this part again", path_, what));
}

std::vector<std::byte> PartFile::bytes(std::uint64_t offset, std::uint64_t size) const {
    std::vector<std::byte> all(size);
    for (std::uint64_t done = 0; done < size;) {
        const ssize_t got = ::pread(in_, all.data() + done, size - done, off_t(offset + done));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0)
            throw Error(fmt::format("{}: cannot read it: {}", path_, std::strerror(errno)));
        if (got == 0) damaged("it is cut short");
        done += std::uint64_t(got);
    }
    return all;
}

const PartEntry* PartFile::find(std::uint32_t task, std::uint32_t sink, std::uint64_t item) const {
    PartEntry wanted;
    wanted.task = task;
    wanted.sink = sink;
    wanted.item = item;
    const auto found = std::lower_bound(
        entries_.begin(), entries_.end(), wanted,
        [](const PartEntry& a, const PartEntry& b) { return place(a) < place(b); });
    return found != entries_.end() && place(*found) == place(wanted) ? &*found : nullptr;
}

bool PartFile::has(std::uint32_t task, std::uint32_t sink, std::uint64_t item) const {
    return find(task, sink, item) != nullptr;
}

ByteReader PartFile::read(std::uint32_t task, std::uint32_t sink, std::uint64_t item) const {
    const PartEntry* entry = find(task, sink, item);
    if (!entry) damaged(fmt::format("tile or piece {} is not in it", item));
    std::vector<std::byte> data = bytes(entry->offset, entry->size);
    if (hash_of(data.data(), data.size()) != entry->hash)
        damaged(fmt::format("tile or piece {} has another checksum", item));
    return ByteReader(std::move(data));
}

}  // namespace weft
