#include "samples/read_npz.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "graph/error.h"
#include "runtime/context.h"
#include "samples/channel_choice.h"
#include "samples/check_samples.h"
#include "samples/npy.h"
#include "samples/sample_meta.h"
#include "samples/zip_reader.h"

namespace weft {
namespace {

class NpzReader {
  public:
    NpzReader(const FileBytes& file, const ReadOptions& options, Context& ctx)
        : file_(file), options_(options), ctx_(ctx), members_(zip_members(file)) {}

    Samples read() {
        Samples samples;
        read_meta(meta_text(), file_.name, samples);
        const std::vector<const ZipMember*> wanted = wanted_members();
        samples.set_size(size_of_buffer(samples));
        read_channels(wanted, samples);
        if (samples.size() == 0) fail("the buffer holds no samples");
        return samples;
    }

  private:
    [[noreturn]] void fail(const std::string& message) const {
        throw Error(fmt::format("{}: {}", file_.name, message));
    }

    // "xy" of a member "xy.npy"
    static std::string_view channel_of(const ZipMember& member) {
        std::string_view name = member.name;
        if (name.ends_with(".npy")) name.remove_suffix(4);
        return name;
    }
    const ZipMember* find(std::string_view channel) const {
        for (const ZipMember& m : members_)
            if (channel_of(m) == channel) return &m;
        return nullptr;
    }
    const ZipMember& need(std::string_view channel) const {
        if (const ZipMember* member = find(channel)) return *member;
        std::vector<std::string_view> have;
        for (const ZipMember& m : members_) have.push_back(channel_of(m));
        fail(fmt::format("no member '{}'; a sample file has meta, xy, rgb and more, this has {}",
                         channel,
                         have.empty() ? "none" : fmt::format("{}", fmt::join(have, ", "))));
    }
    std::string what(std::string_view channel) const {
        return fmt::format("{}: '{}'", file_.name, channel);
    }

    std::string meta_text() const {
        const FileBytes bytes = zip_bytes(file_, need("meta"));
        const Npy array = parse_npy(bytes.bytes, what("meta"));
        if (array.kind != 'u' || array.item_size != 1 || array.shape.size() > 1)
            fail(fmt::format(
                "'meta' is {} numbers of {} bytes; expected JSON text as an array of u1",
                shape_text(array.shape), array.item_size));
        return {reinterpret_cast<const char*>(array.data.data()), array.data.size()};
    }

    std::vector<const ZipMember*> wanted_members() const {
        std::vector<std::string> known;
        std::vector<const ZipMember*> wanted;
        need("xy");
        need("rgb");
        for (const ZipMember& member : members_) {
            const std::string_view channel = channel_of(member);
            if (channel == "meta" || channel == "count") continue;
            if (std::find(known.begin(), known.end(), channel) != known.end())
                fail(fmt::format("two members are called '{}'", channel));
            known.emplace_back(channel);
            if (is_wanted(options_, channel)) wanted.push_back(&member);
        }
        refuse_unknown_channels(options_, file_.name, known);
        return wanted;
    }

    // Where spp is constant, by arithmetic; where it varies, from `count`; of a light, from xy.
    size_t size_of_buffer(Samples& samples) const {
        const ZipMember* count = find("count");
        if (count && samples.domain == "camera") return read_count(*count, samples);
        if (samples.spp > 0) {
            std::uint64_t size = samples.pixels();
            if (__builtin_mul_overflow(size, std::uint64_t(samples.spp), &size) ||
                size > SIZE_MAX / 64)
                fail(fmt::format("meta: {} x {} pixels of {} samples are more than any file holds",
                                 samples.width, samples.height, samples.spp));
            return size_t(size);
        }
        if (samples.domain == "camera")
            fail(
                "meta: 'spp' is null, so samples a pixel vary; then a member 'count' (height, "
                "width) of type u4 must say how many each has");
        const FileBytes bytes = zip_bytes(file_, need("xy"));
        const Npy xy = parse_npy(bytes.bytes, what("xy"));
        if (xy.shape.size() != 2)
            fail(fmt::format("'xy' is {}; expected (N, 2)", shape_text(xy.shape)));
        return size_t(xy.shape[0]);
    }

    size_t read_count(const ZipMember& member, Samples& samples) const {
        const FileBytes bytes = zip_bytes(file_, member);
        const Npy array = parse_npy(bytes.bytes, what("count"));
        const auto height = std::uint64_t(samples.height), width = std::uint64_t(samples.width);
        if (array.kind != 'u' || array.shape != std::vector{height, width})
            fail(fmt::format("'count' is {}{} {}; expected u4 ({}, {})", array.kind,
                             array.item_size, shape_text(array.shape), height, width));
        const Array<std::uint32_t> counts = npy_whole(array, bytes.owner, ctx_);
        std::vector<std::uint64_t> first;
        if (samples.spp == 0) first.reserve(counts.size() + 1);
        std::uint64_t sum = 0;
        for (size_t pixel = 0; pixel < counts.size(); ++pixel) {
            if (samples.spp == 0)
                first.push_back(sum);
            else if (counts[pixel] != std::uint32_t(samples.spp))
                fail(fmt::format(
                    "meta says {} samples in every pixel, 'count' says {} in pixel ({}, "
                    "{})",
                    samples.spp, counts[pixel], pixel % width, pixel / width));
            sum += counts[pixel];
        }
        if (samples.spp == 0) {
            first.push_back(sum);
            samples.first = std::move(first);
        }
        return size_t(sum);
    }

    // Members are read side by side; of several failures the first in file order is told.
    void read_channels(const std::vector<const ZipMember*>& wanted, Samples& samples) const {
        std::vector<Channel> channels(wanted.size());
        std::vector<std::string> failures(wanted.size());
        ctx_.parallel(wanted.size(), 1, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) try {
                    channels[i] = read_channel(*wanted[i], samples);
                } catch (const Error& error) {
                    failures[i] = error.what();
                }
        });
        for (const std::string& failure : failures)
            if (!failure.empty()) throw Error(failure);
        for (Channel& channel : channels) samples.channels.push_back(std::move(channel));
    }

    Channel read_channel(const ZipMember& member, const Samples& samples) const {
        Channel channel;
        channel.name = channel_of(member);
        channel.role = role_in_meta(samples.meta, file_.name, channel.name);
        const FileBytes bytes = zip_bytes(file_, member);
        const Npy array = parse_npy(bytes.bytes, what(channel.name));
        check_shape(channel, array, samples);
        const bool number = is_basic_channel(channel.name) || channel.role == Role::radiance ||
                            channel.role == Role::feature || channel.role == Role::random;
        const bool name_of_thing = channel.name == "id" || channel.name == "light_index";
        if (name_of_thing && array.kind != 'u')
            fail(
                fmt::format("'{}' is of type f{}; expected whole numbers: save it with "
                            ".astype('u4')",
                            channel.name, array.item_size));
        if (name_of_thing || (!number && array.kind == 'u' && array.item_size == 4))
            channel.ids = npy_whole(array, bytes.owner, ctx_);
        else
            channel.values = npy_floats(array, bytes.owner, ctx_);
        return channel;
    }

    // (N,) or (N, k), N as meta says.
    void check_shape(Channel& channel, const Npy& array, const Samples& samples) const {
        const auto& shape = array.shape;
        const int components = standard_components(channel.name);
        const bool right =
            (shape.size() == 1 || (shape.size() == 2 && shape[1] > 0 && shape[1] < 4096)) &&
            (components == 0 || std::uint64_t(components) == (shape.size() == 2 ? shape[1] : 1));
        if (!right)
            fail(fmt::format("'{}' has shape {}; expected {}", channel.name, shape_text(shape),
                             components == 1   ? "(N,)"
                             : components == 0 ? "(N,) or (N, k)"
                                               : fmt::format("(N, {})", components)));
        if (shape[0] != samples.size())
            fail(samples.spp > 0
                     ? fmt::format("'{}' has {} samples; {} x {} pixels of {} samples make {}",
                                   channel.name, shape[0], samples.width, samples.height,
                                   samples.spp, samples.size())
                     : fmt::format("'{}' has {} samples; {} adds up to {}", channel.name, shape[0],
                                   samples.domain == "light" ? "'xy'" : "'count'", samples.size()));
        channel.components = shape.size() == 2 ? int(shape[1]) : 1;
    }

    const FileBytes& file_;
    const ReadOptions& options_;
    Context& ctx_;
    std::vector<ZipMember> members_;
};

}  // namespace

bool is_npz(const FileBytes& file) {
    const std::string_view start = file.text().substr(0, 4);
    return start == "PK\3\4" || start == std::string_view("PK\5\6", 4);
}

Samples read_npz(const FileBytes& file, const ReadOptions& options, Context& ctx) {
    Samples samples = NpzReader(file, options, ctx).read();
    check_samples(samples, file.name, options.tolerate, ctx);
    return samples;
}

}  // namespace weft
