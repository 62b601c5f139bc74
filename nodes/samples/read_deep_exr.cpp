#include "samples/read_deep_exr.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/error.h"
#include "runtime/context.h"
#include "samples/channel_choice.h"
#include "samples/check_samples.h"
#include "samples/convert.h"
#include "samples/exr_channels.h"
#include "samples/exr_header.h"
#include "samples/exr_unpack.h"
#include "samples/little_endian.h"
#include "samples/sample_meta.h"

namespace weft {
namespace {

using Bytes = std::span<const std::uint8_t>;

// A line of pixels: its counts and its samples, both packed.
struct Chunk {
    Bytes counts, samples;
    std::uint64_t unpacked = 0;  // bytes of the samples
};

// Where a channel of the file goes.
struct Target {
    ExrPixel type = ExrPixel::single;
    float* values = nullptr;
    std::uint32_t* ids = nullptr;  // one of the two, or neither: not wanted
    size_t stride = 1;
};

class DeepReader {
  public:
    DeepReader(const FileBytes& file, const ReadOptions& options, Context& ctx)
        : file_(file), options_(options), ctx_(ctx), header_(read_exr_header(file)) {}

    Samples read() {
        read_chunk_heads();
        read_counts();
        Samples samples;
        samples.set_size(size_t(first_.back()));
        describe(samples);
        std::vector<Target> targets = make_channels(samples);
        read_lines(targets);
        if (samples.size() == 0) fail("the buffer holds no samples");
        if (!samples.find("rgb")) fail("no channels R, G, B; a sample file needs them");
        if (!samples.find("xy")) add_centres(samples);
        return samples;
    }

  private:
    [[noreturn]] void fail(const std::string& message) const {
        throw Error(fmt::format("{}: {}", file_.name, message));
    }
    size_t width() const { return size_t(header_.width); }
    size_t height() const { return size_t(header_.height); }

    void read_chunk_heads() {
        std::uint64_t used = 0, counts = 0;
        for (size_t line = 0; line < height(); ++line) {
            const Chunk chunk = chunk_at(line);
            used += chunk.counts.size() + chunk.samples.size();
            counts += chunk.counts.size();
            if (chunk.unpacked > exr_unpacked_limit(chunk.samples.size()))
                fail(fmt::format("line {} says it holds {} bytes, which {} packed bytes cannot",
                                 line, chunk.unpacked, chunk.samples.size()));
            chunks_.push_back(chunk);
        }
        if (used > file_.bytes.size()) fail("its lines overlap; the file is damaged");
        if (4 * std::uint64_t(width()) * height() > exr_unpacked_limit(counts))
            fail(fmt::format("its {} x {} pixels do not fit into the file; it is damaged", width(),
                             height()));
    }

    Chunk chunk_at(size_t line) const {
        const std::uint64_t offset = header_.offsets[line];
        const size_t number = header_.several ? 4 : 0, head = number + 28;
        if (offset == 0) fail(fmt::format("line {} is missing; the file was not finished", line));
        if (file_.bytes.size() < head || offset > file_.bytes.size() - head)
            fail(fmt::format("line {} lies outside the file; it is cut short or damaged", line));
        Bytes rest = file_.bytes.subspan(size_t(offset));
        if (header_.several && u32(rest, 0) != std::uint32_t(header_.part))
            fail(fmt::format("line {} belongs to another part; the file is damaged", line));
        rest = rest.subspan(number);
        if (number_at<std::int32_t>(rest, 0) != std::int64_t(header_.y0) + std::int64_t(line))
            fail(fmt::format("line {} is not where the table says; the file is damaged", line));
        const std::uint64_t counts = u64(rest, 4), samples = u64(rest, 12),
                            unpacked = u64(rest, 20);
        rest = rest.subspan(28);
        if (counts > rest.size() || samples > rest.size() - counts)
            fail(fmt::format("line {} lies outside the file; it is cut short or damaged", line));
        return {rest.subspan(0, size_t(counts)), rest.subspan(size_t(counts), size_t(samples)),
                unpacked};
    }

    // Runs work(line, scratch) for all lines; of several failures the first line's is told.
    template <class Work>
    void for_lines(Work&& work) {
        std::vector<std::string> failures(height());
        ctx_.parallel(height(), 8, [&](size_t begin, size_t end) {
            std::vector<std::uint8_t> scratch;
            for (size_t line = begin; line < end; ++line) try {
                    work(line, scratch);
                } catch (const Error& error) {
                    failures[line] = error.what();
                }
        });
        for (const std::string& failure : failures)
            if (!failure.empty()) throw Error(failure);
    }

    // A line's table holds running sums: the samples of its pixels up to each.
    void read_counts() {
        std::vector<std::uint32_t> sums(width() * height());
        for_lines([&](size_t line, std::vector<std::uint8_t>& scratch) {
            const std::span<std::uint32_t> of_line(sums.data() + line * width(), width());
            if (!exr_unpack(ExrPacking(header_.compression), chunks_[line].counts,
                            {reinterpret_cast<std::uint8_t*>(of_line.data()), of_line.size_bytes()},
                            scratch))
                fail(fmt::format(
                    "the sample counts of line {} cannot be unpacked; the file is damaged", line));
            if (!std::is_sorted(of_line.begin(), of_line.end()))
                fail(fmt::format("the sample counts of line {} don't add up", line));
            const std::uint64_t bytes = std::uint64_t(of_line.back()) * bytes_of_sample();
            if (bytes != chunks_[line].unpacked)
                fail(fmt::format("line {} holds {} bytes; its {} samples need {}", line,
                                 chunks_[line].unpacked, of_line.back(), bytes));
        });
        first_.reserve(sums.size() + 1);
        std::uint64_t before = 0;
        for (size_t line = 0; line < height(); ++line) {
            first_.push_back(before);
            for (size_t x = 0; x < width(); ++x)
                first_.push_back(before + sums[line * width() + x]);
            before = first_.back();
            first_.pop_back();
        }
        first_.push_back(before);
    }

    size_t bytes_of_sample() const {
        size_t bytes = 0;
        for (const ExrChannel& channel : header_.channels) bytes += size_of(channel.type);
        return bytes;
    }

    void describe(Samples& samples) const {
        if (!header_.meta.empty()) {
            read_meta(header_.meta, file_.name, samples);
            if (samples.width != header_.width || samples.height != header_.height)
                fail(fmt::format("meta says {} x {} pixels, the data window has {} x {}",
                                 samples.width, samples.height, header_.width, header_.height));
        }
        samples.width = header_.width;
        samples.height = header_.height;
        const std::uint64_t spp = samples.pixels() ? first_.back() / samples.pixels() : 0;
        bool constant = spp > 0 && spp <= INT32_MAX;
        for (size_t pixel = 0; pixel <= samples.pixels() && constant; ++pixel)
            constant = first_[pixel] == pixel * spp;
        if (samples.spp > 0 && (!constant || spp != std::uint64_t(samples.spp)))
            fail(fmt::format("meta says {} samples in every pixel, which is not so", samples.spp));
        samples.spp = constant ? int(spp) : 0;
        if (!constant) samples.first = first_;
    }

    // Groups the file's channels into ours, made to be filled.
    std::vector<Target> make_channels(Samples& samples) const {
        std::vector<std::string> known;
        struct Group {
            std::string name;
            std::vector<std::pair<int, size_t>> parts;  // component, channel of the file
        };
        std::vector<Group> groups;
        for (size_t i = 0; i < header_.channels.size(); ++i) {
            const ExrPart part = exr_part(header_.channels[i].name);
            auto group = std::find_if(groups.begin(), groups.end(),
                                      [&](const Group& g) { return g.name == part.channel; });
            if (group == groups.end()) {
                groups.push_back({part.channel, {}});
                group = groups.end() - 1;
                known.push_back(part.channel);
            }
            group->parts.emplace_back(part.part, i);
        }
        refuse_unknown_channels(options_, file_.name, known);

        std::vector<Target> targets(header_.channels.size());
        for (Group& group : groups) {
            if (!is_wanted(options_, group.name)) continue;
            std::sort(group.parts.begin(), group.parts.end());
            Channel channel;
            channel.name = group.name;
            channel.components = int(group.parts.size());
            channel.role = role_in_meta(samples.meta, file_.name, group.name);
            for (size_t k = 0; k < group.parts.size(); ++k)
                if (group.parts[k].first != int(k))
                    fail(fmt::format("channel '{}' lacks a component: it has {}", group.name,
                                     names_of(group.parts)));
            const int standard = standard_components(group.name);
            if (standard && standard != channel.components)
                fail(fmt::format("channel '{}' has {} component{} ({}); expected {}", group.name,
                                 channel.components, channel.components == 1 ? "" : "s",
                                 names_of(group.parts), standard));
            make_values(channel, group.parts, samples.size(), targets);
            samples.channels.push_back(std::move(channel));
        }
        return targets;
    }

    std::string names_of(const std::vector<std::pair<int, size_t>>& parts) const {
        std::string text;
        for (const auto& [part, i] : parts)
            text += (text.empty() ? "" : ", ") + header_.channels[i].name;
        return text;
    }

    void make_values(Channel& channel, const std::vector<std::pair<int, size_t>>& parts,
                     size_t samples, std::vector<Target>& targets) const {
        const size_t count = samples * parts.size();
        const bool whole =
            std::all_of(parts.begin(), parts.end(),
                        [&](const auto& part) {
                            return header_.channels[part.second].type == ExrPixel::uint;
                        }) &&
            !is_basic_channel(channel.name);
        const std::shared_ptr<float[]> values(whole ? nullptr : new float[count]);
        const std::shared_ptr<std::uint32_t[]> ids(whole ? new std::uint32_t[count] : nullptr);
        for (const auto& [part, i] : parts) {
            targets[i] = {header_.channels[i].type, whole ? nullptr : values.get() + part,
                          whole ? ids.get() + part : nullptr, parts.size()};
        }
        if (whole)
            channel.ids = {std::span<const std::uint32_t>(ids.get(), count), ids};
        else
            channel.values = {std::span<const float>(values.get(), count), values};
    }

    void read_lines(const std::vector<Target>& targets) {
        for_lines([&](size_t line, std::vector<std::uint8_t>& scratch) {
            std::vector<std::uint8_t> plain(size_t(chunks_[line].unpacked));
            if (!exr_unpack(ExrPacking(header_.compression), chunks_[line].samples, plain, scratch))
                fail(fmt::format("the samples of line {} cannot be unpacked; the file is damaged",
                                 line));
            const auto begin = size_t(first_[line * width()]);
            const size_t count = size_t(first_[(line + 1) * width()]) - begin;
            Bytes rest = plain;
            for (size_t i = 0; i < targets.size(); ++i) {
                const size_t bytes = count * size_of(header_.channels[i].type);
                fill(targets[i], begin, rest.subspan(0, bytes), count);
                rest = rest.subspan(bytes);
            }
        });
    }

    static void fill(const Target& target, size_t begin, Bytes from, size_t count) {
        for (size_t i = 0; i < count; ++i) {
            const size_t to = (begin + i) * target.stride;
            if (target.ids)
                target.ids[to] = u32(from, 4 * i);
            else if (!target.values)
                return;
            else if (target.type == ExrPixel::half)
                target.values[to] = float_from_half(u16(from, 2 * i));
            else if (target.type == ExrPixel::uint)
                target.values[to] = float(u32(from, 4 * i));
            else
                target.values[to] = number_at<float>(from, 4 * i);
        }
    }

    void add_centres(Samples& samples) const {
        std::vector<float> xy;
        xy.reserve(2 * samples.size());
        for (size_t pixel = 0; pixel < samples.pixels(); ++pixel)
            for (auto i = first_[pixel]; i < first_[pixel + 1]; ++i) {
                xy.push_back(float(pixel % width()) + 0.5f);
                xy.push_back(float(pixel / width()) + 0.5f);
            }
        samples.add("xy", 2, std::move(xy));
        ctx_.warn(
            fmt::format("{}: no channels x, y: samples are taken to lie at their pixels' centres; "
                        "reconstruction from true positions is sharper",
                        file_.name));
    }

    const FileBytes& file_;
    const ReadOptions& options_;
    Context& ctx_;
    ExrHeader header_;
    std::vector<Chunk> chunks_;
    std::vector<std::uint64_t> first_;  // pixels + 1
};

}  // namespace

Samples read_deep_exr(const FileBytes& file, const ReadOptions& options, Context& ctx) {
    Samples samples = DeepReader(file, options, ctx).read();
    check_samples(samples, file.name, options.tolerate, ctx);
    return samples;
}

}  // namespace weft
