// What the fuzzer of part files and the replay of its corpus do with one input: it is read, or
// refused with a message, and so is what a node makes of each record in it.
#pragma once
#include <sys/mman.h>
#include <unistd.h>
#include <xxhash.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

#include "image/image_bytes.h"
#include "runtime/part_file.h"
#include "samples/sample_bytes.h"

namespace weft::test {

// Makes checksums right, which no fuzzer would guess.
inline std::string part_with_checksums(std::string bytes) {
    struct Trailer {
        std::uint64_t directory, entries, header, hash;
        char magic[8];
    } trailer;
    if (bytes.size() < sizeof trailer) return bytes;
    std::memcpy(&trailer, &bytes[bytes.size() - sizeof trailer], sizeof trailer);
    const std::uint64_t end = bytes.size() - sizeof trailer;
    if (trailer.directory > end || trailer.entries > (end - trailer.directory) / sizeof(PartEntry))
        return bytes;
    for (std::uint64_t i = 0; i < trailer.entries; ++i) {
        PartEntry entry;
        char* at = &bytes[trailer.directory + i * sizeof entry];
        std::memcpy(&entry, at, sizeof entry);
        if (entry.offset > end || entry.size > end - entry.offset) continue;
        entry.hash = XXH3_64bits(&bytes[entry.offset], entry.size);
        std::memcpy(at, &entry, sizeof entry);
    }
    trailer.hash = XXH3_64bits(&bytes[trailer.directory], end - trailer.directory);
    std::memcpy(&bytes[end], &trailer, sizeof trailer);
    return bytes;
}

template <class Read>
void part_read_or_refuse(Read&& read) {
    try {
        read();
    } catch (const Error& error) {
        if (error.what()[0] != '\0') return;
        std::fprintf(stderr, "refused without a word\n");
        std::abort();
    }
}

// All pieces, as the one of them that is there.
class OnePiece final : public Pieces {
  public:
    OnePiece(const PartFile& part, const PartEntry& entry) : part_(part), entry_(entry) {}
    size_t size() const override { return 2; }
    ByteReader read(size_t) const override {
        return part_.read(entry_.task, entry_.sink, entry_.item);
    }

  private:
    const PartFile& part_;
    const PartEntry& entry_;
};

inline void fuzz_part(std::string_view input) {
    for (const std::string& bytes : {std::string(input), part_with_checksums(std::string(input))}) {
        const int file = ::memfd_create("part", MFD_CLOEXEC);
        if (file < 0 || ::write(file, bytes.data(), bytes.size()) != ssize_t(bytes.size()))
            std::abort();
        const std::string path = "/proc/self/fd/" + std::to_string(file);
        part_read_or_refuse([&] {
            const PartFile part(path);
            for (const PartEntry& entry : part.entries()) {
                part_read_or_refuse([&] { join_samples(OnePiece(part, entry)); });
                part_read_or_refuse([&] {
                    ByteReader from = part.read(entry.task, entry.sink, entry.item);
                    ImageStack stack;
                    stack.add(take_image(from));
                    stack.whole();
                });
            }
        });
        part_read_or_refuse([&] { Parts({path}); });
        ::close(file);
    }
}

}  // namespace weft::test
