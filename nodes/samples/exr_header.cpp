#include "samples/exr_header.h"

#include <fmt/format.h>

#include <optional>

#include "graph/error.h"
#include "samples/little_endian.h"

namespace weft {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint32_t magic = 20000630;
constexpr std::uint32_t flag_deep = 0x800, flag_parts = 0x1000;

struct Attribute {
    std::string name, type;
    Bytes value;
};

class HeaderReader {
  public:
    explicit HeaderReader(const FileBytes& file) : file_(file), rest_(file.bytes) {}

    ExrHeader read() {
        if (rest_.size() < 8) fail("cut short in its header");
        const std::uint32_t version = u32(rest_, 4);
        if ((version & 0xff) != 2)
            fail(fmt::format("OpenEXR version {}; this program reads version 2", version & 0xff));
        rest_ = rest_.subspan(8);
        const bool several = version & flag_parts;
        std::vector<ExrHeader> parts;
        do {
            ExrHeader header = read_one();
            header.part = int(parts.size());
            header.several = several;
            parts.push_back(std::move(header));
        } while (several && !ends_here());
        return with_offsets(parts);
    }

  private:
    [[noreturn]] void fail(const std::string& message) const {
        throw Error(fmt::format("{}: {}", file_.name, message));
    }
    bool ends_here() {
        if (rest_.empty()) fail("cut short in its header");
        if (rest_[0] != 0) return false;
        rest_ = rest_.subspan(1);
        return true;
    }
    std::string word(Bytes& from) const {
        const std::string_view text(reinterpret_cast<const char*>(from.data()), from.size());
        const size_t end = text.substr(0, 256).find('\0');
        if (end == text.npos) fail("cut short or damaged in its header");
        from = from.subspan(end + 1);
        return std::string(text.substr(0, end));
    }

    Attribute attribute() {
        Attribute a{word(rest_), word(rest_), {}};
        if (rest_.size() < 4) fail("cut short in its header");
        const size_t size = u32(rest_, 0);
        if (size > rest_.size() - 4)
            fail(fmt::format("cut short in attribute '{}' of its header", a.name));
        a.value = rest_.subspan(4, size);
        rest_ = rest_.subspan(4 + size);
        return a;
    }

    ExrHeader read_one() {
        ExrHeader header;
        while (!ends_here()) {
            const Attribute a = attribute();
            const auto need = [&](size_t size) {
                if (a.value.size() != size) fail(fmt::format("attribute '{}' is damaged", a.name));
            };
            if (a.name == "dataWindow") {
                need(16);
                read_window(a.value, header);
            } else if (a.name == "compression") {
                need(1);
                header.compression = a.value[0];
            } else if (a.name == "type" && a.type == "string") {
                header.type.assign(a.value.begin(), a.value.end());
            } else if (a.name == "channels") {
                header.channels = read_channels(a.value);
            } else if (a.name == "weft:meta" && a.type == "string") {
                header.meta.assign(a.value.begin(), a.value.end());
            } else if (a.name == "chunkCount") {
                need(4);
                header.offsets.resize(count_of_chunks(u32(a.value, 0)));
            }
        }
        return header;
    }

    void read_window(Bytes value, ExrHeader& header) const {
        const auto at = [&](size_t i) {
            return std::int64_t(number_at<std::int32_t>(value, 4 * i));
        };
        const std::int64_t width = at(2) - at(0) + 1, height = at(3) - at(1) + 1;
        if (width < 1 || height < 1 || width > 1 << 30 || height > 1 << 30)
            fail(fmt::format("its data window has {} x {} pixels", width, height));
        header.x0 = int(at(0));
        header.y0 = int(at(1));
        header.width = int(width);
        header.height = int(height);
    }

    // Each has an offset of 8 bytes in the file.
    size_t count_of_chunks(std::uint64_t count) const {
        if (count > file_.bytes.size() / 8) fail("cut short: its lines do not fit into the file");
        return size_t(count);
    }

    std::vector<ExrChannel> read_channels(Bytes value) const {
        std::vector<ExrChannel> channels;
        while (value.size() > 1) {
            ExrChannel channel;
            channel.name = word(value);
            if (value.size() < 16) fail("its list of channels is damaged");
            const std::uint32_t type = u32(value, 0);
            if (type > 2) fail(fmt::format("channel '{}' has unknown type {}", channel.name, type));
            if (u32(value, 8) != 1 || u32(value, 12) != 1)
                fail(fmt::format(
                    "channel '{}' is not there in every pixel; deep samples need it to be",
                    channel.name));
            channel.type = type == 0   ? ExrPixel::uint
                           : type == 1 ? ExrPixel::half
                                       : ExrPixel::single;
            channels.push_back(std::move(channel));
            value = value.subspan(16);
        }
        return channels;
    }

    // Behind the headers stands a table for each part.
    ExrHeader with_offsets(std::vector<ExrHeader>& parts) {
        std::optional<ExrHeader> found;
        for (ExrHeader& part : parts) {
            const bool deep = part.type == "deepscanline";
            if (!part.several && part.offsets.empty() && deep)
                part.offsets.resize(count_of_chunks(std::uint64_t(part.height)));
            if (part.offsets.size() > rest_.size() / 8) fail("cut short in its table of lines");
            if (deep && !found) {
                if (part.width == 0 || part.channels.empty())
                    fail("its header lacks dataWindow or channels");
                if (part.offsets.size() != size_t(part.height))
                    fail(fmt::format("it has {} chunks for {} lines of deep samples",
                                     part.offsets.size(), part.height));
                for (size_t i = 0; i < part.offsets.size(); ++i)
                    part.offsets[i] = u64(rest_, 8 * i);
                found = part;
            }
            rest_ = rest_.subspan(8 * part.offsets.size());
        }
        if (!found) {
            std::string types;
            for (const ExrHeader& part : parts) types += (types.empty() ? "" : ", ") + part.type;
            fail(fmt::format("no deep scanline part in this EXR (it has: {})", types));
        }
        if (found->compression > 2)
            fail(fmt::format(
                "deep samples packed by method {}; this program reads none, RLE and ZIPS",
                found->compression));
        return std::move(*found);
    }

    const FileBytes& file_;
    Bytes rest_;
};

}  // namespace

bool is_exr(const FileBytes& file) {
    return file.bytes.size() >= 8 && u32(file.bytes, 0) == magic;
}

bool is_deep_exr(const FileBytes& file) {
    return is_exr(file) && (u32(file.bytes, 4) & flag_deep);
}

ExrHeader read_exr_header(const FileBytes& file) {
    return HeaderReader(file).read();
}

}  // namespace weft
