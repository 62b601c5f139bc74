#include "samples/zip_reader.h"

#include <fmt/format.h>
#include <libdeflate.h>

#include <algorithm>

#include "graph/error.h"
#include "runtime/large_array.h"
#include "samples/little_endian.h"

namespace weft {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint32_t local_mark = 0x04034b50, central_mark = 0x02014b50, end_mark = 0x06054b50,
                        end64_mark = 0x06064b50, locator64_mark = 0x07064b50;
constexpr size_t local_size = 30, central_size = 46, end_size = 22, end64_size = 56,
                 locator64_size = 20;

struct Directory {
    std::uint64_t offset = 0, size = 0, count = 0;
};

class Reader {
  public:
    explicit Reader(const FileBytes& file) : file_(file), bytes_(file.bytes) {}

    std::vector<ZipMember> members() {
        const Directory directory = find_directory();
        if (directory.offset > bytes_.size() || directory.size > bytes_.size() - directory.offset)
            fail("its directory lies outside the file; the file is cut short or damaged");
        if (directory.count > directory.size / central_size)
            fail(fmt::format("its directory names {} members but has room for {}", directory.count,
                             directory.size / central_size));
        Bytes rest = bytes_.subspan(size_t(directory.offset), size_t(directory.size));
        std::vector<ZipMember> found;
        found.reserve(size_t(directory.count));
        for (std::uint64_t i = 0; i < directory.count; ++i) found.push_back(next_member(rest));
        refuse_overlap(found);
        return found;
    }

  private:
    [[noreturn]] void fail(const std::string& message) const {
        throw Error(fmt::format("{}: {}", file_.name, message));
    }

    // The end record is the last thing in the file but for a comment of at most 65535 bytes.
    Directory find_directory() const {
        if (bytes_.size() < end_size)
            fail(fmt::format("only {} bytes, no zip file", bytes_.size()));
        const size_t last = bytes_.size() - end_size;
        const size_t stop = last > 0xffff ? last - 0xffff : 0;
        for (size_t at = last + 1; at-- > stop;) {
            const Bytes end = bytes_.subspan(at);
            if (u32(end, 0) != end_mark || u16(end, 20) != end.size() - end_size) continue;
            return directory_at(end, at);
        }
        fail("no zip directory at its end; the file is cut short");
    }

    Directory directory_at(Bytes end, size_t at) const {
        Directory d{u32(end, 16), u32(end, 12), u16(end, 10)};
        const bool zip64 = d.offset == 0xffffffff || d.size == 0xffffffff || d.count == 0xffff;
        if (zip64 && at >= locator64_size && u32(bytes_, at - locator64_size) == locator64_mark) {
            const std::uint64_t where = u64(bytes_, at - locator64_size + 8);
            if (u32(bytes_, at - locator64_size + 16) > 1) refuse_disks();
            if (bytes_.size() < end64_size || where > bytes_.size() - end64_size ||
                u32(bytes_, size_t(where)) != end64_mark)
                fail("its zip64 end record is not where it says; the file is damaged");
            const Bytes end64 = bytes_.subspan(size_t(where), end64_size);
            if (u32(end64, 16) != 0 || u32(end64, 20) != 0) refuse_disks();
            return {u64(end64, 48), u64(end64, 40), u64(end64, 32)};
        }
        if (u16(end, 4) != 0 || u16(end, 6) != 0) refuse_disks();
        return d;
    }

    [[noreturn]] void refuse_disks() const {
        fail("one part of a zip over several files; join the parts first");
    }

    ZipMember next_member(Bytes& rest) const {
        if (rest.size() < central_size || u32(rest, 0) != central_mark)
            fail("its directory is damaged");
        const size_t name_size = u16(rest, 28), extra_size = u16(rest, 30),
                     note_size = u16(rest, 32);
        if (rest.size() - central_size < name_size + extra_size + note_size)
            fail("its directory is damaged");
        ZipMember member;
        member.name.assign(reinterpret_cast<const char*>(rest.data()) + central_size, name_size);
        if (u16(rest, 8) & 1)
            fail(fmt::format("member '{}' is encrypted; save it without a password", member.name));
        member.method = u16(rest, 10);
        member.crc = u32(rest, 16);
        std::uint64_t packed = u32(rest, 20), size = u32(rest, 24), offset = u32(rest, 42);
        std::uint32_t disk = u16(rest, 34);
        read_zip64(rest.subspan(central_size + name_size, extra_size), size, packed, offset, disk);
        if (disk != 0) refuse_disks();
        member.size = size;
        member.packed = data_at(member, offset, packed);
        rest = rest.subspan(central_size + name_size + extra_size + note_size);
        return member;
    }

    // Field 1 holds, in this order, what did not fit into 32 (the disk: 16) bits.
    static void read_zip64(Bytes extra, std::uint64_t& size, std::uint64_t& packed,
                           std::uint64_t& offset, std::uint32_t& disk) {
        while (extra.size() >= 4) {
            const size_t id = u16(extra, 0), length = u16(extra, 2);
            if (length > extra.size() - 4) return;
            Bytes field = extra.subspan(4, length);
            if (id == 1) {
                const auto take = [&](std::uint64_t& value) {
                    if (value != 0xffffffff || field.size() < 8) return;
                    value = u64(field, 0);
                    field = field.subspan(8);
                };
                take(size);
                take(packed);
                take(offset);
                if (disk == 0xffff && field.size() >= 4) disk = u32(field, 0);
            }
            extra = extra.subspan(4 + length);
        }
    }

    Bytes data_at(const ZipMember& member, std::uint64_t offset, std::uint64_t packed) const {
        const std::uint64_t all = bytes_.size();
        const auto damaged = [&]() {
            fail(
                fmt::format("member '{}' is not where the directory says; the file is cut short or "
                            "damaged",
                            member.name));
        };
        if (all < local_size || offset > all - local_size ||
            u32(bytes_, size_t(offset)) != local_mark)
            damaged();
        const Bytes local = bytes_.subspan(size_t(offset));
        const size_t head = local_size + u16(local, 26) + u16(local, 28);
        if (head > local.size() || packed > local.size() - head) damaged();
        const std::string_view name(reinterpret_cast<const char*>(local.data()) + local_size,
                                    u16(local, 26));
        if (name != member.name)
            fail(fmt::format("member '{}' is called '{}' in the directory; the file is damaged",
                             name, member.name));
        return local.subspan(head, size_t(packed));
    }

    // Members that share bytes are how small files pretend to be huge ones.
    void refuse_overlap(const std::vector<ZipMember>& members) const {
        std::vector<const ZipMember*> order;
        for (const ZipMember& m : members)
            if (!m.packed.empty()) order.push_back(&m);
        std::sort(order.begin(), order.end(), [](const ZipMember* a, const ZipMember* b) {
            return a->packed.data() < b->packed.data();
        });
        for (size_t i = 1; i < order.size(); ++i)
            if (order[i - 1]->packed.data() + order[i - 1]->packed.size() > order[i]->packed.data())
                fail(fmt::format("members '{}' and '{}' overlap; the file is damaged",
                                 order[i - 1]->name, order[i]->name));
    }

    const FileBytes& file_;
    Bytes bytes_;
};

}  // namespace

std::vector<ZipMember> zip_members(const FileBytes& file) {
    return Reader(file).members();
}

FileBytes zip_bytes(const FileBytes& file, const ZipMember& member) {
    const auto fail = [&](const std::string& message) {
        throw Error(fmt::format("{}: member '{}' {}", file.name, member.name, message));
    };
    FileBytes result{member.name, member.packed, file.owner, false};
    if (member.method == 8) {
        // Deflate makes at most 1032 bytes of one (RFC 1951: 258 bytes from two bits).
        if (member.size / 1032 > member.packed.size() + 1)
            fail(fmt::format(
                "says that it holds {} bytes, which {} packed bytes cannot; the file is "
                "damaged",
                member.size, member.packed.size()));
        const auto buffer = std::make_shared<LargeArray<std::uint8_t>>(size_t(member.size) + 1);
        std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> inflater(
            libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
        if (!inflater) throw std::bad_alloc();
        if (libdeflate_deflate_decompress(inflater.get(), member.packed.data(),
                                          member.packed.size(), buffer->data(), size_t(member.size),
                                          nullptr) != LIBDEFLATE_SUCCESS)
            fail("cannot be unpacked; the file is damaged");
        result.bytes = {buffer->data(), size_t(member.size)};
        result.owner = buffer;
    } else if (member.method != 0) {
        fail(
            fmt::format("is packed by method {}; expected stored or deflate, as numpy.savez and "
                        "numpy.savez_compressed write",
                        member.method));
    } else if (member.size != member.packed.size()) {
        fail(fmt::format("is stored but has two sizes, {} and {} bytes; the file is damaged",
                         member.packed.size(), member.size));
    }
    const std::uint32_t crc = libdeflate_crc32(0, result.bytes.data(), result.bytes.size());
    if (crc != member.crc)
        fail(fmt::format("has checksum {:08x}, the directory says {:08x}; the file is damaged", crc,
                         member.crc));
    return result;
}

}  // namespace weft
