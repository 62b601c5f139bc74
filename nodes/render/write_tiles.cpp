// write-tiles: rendered samples to a sample file, each tile where it belongs as soon as it is done.
#include "render/rendered_tiles.h"
#include "runtime/node.h"
#include "samples/npz_tiles.h"
#include "samples/sample_meta.h"

namespace weft::render {
namespace {

struct WriteTiles {
    OutputFile file{"out/samples.npz"};

    static void declare(Ports<WriteTiles>& node) {
        node.about(
                "writes rendered samples to an .npz file tile by tile, whole or not at all; what a "
                "file of "
                "write-samples holds, in less memory")
            .writes()
            .in<RenderedTiles>("samples", "of render-tiles")
            .optional_file("file", &WriteTiles::file,
                           {.about = "file to write; folders are made. Empty: nothing is written"});
    }

    // A tile's samples: one row of pixels after the other, so that a row lies together in the file.
    struct Scratch {
        bool any = false;
        const RenderedHead* head = nullptr;
        std::string meta;
        std::uint64_t samples = 0;  // of the whole buffer
        ChannelSet channels;
        std::vector<std::uint64_t> row_first;  // in the buffer
        std::vector<std::uint32_t> counts;     // of the tile's pixels
        std::array<std::vector<float>, channel_count> values;
        std::array<std::vector<std::uint32_t>, channel_count> ids;
    };
    struct Result {
        std::mutex mutex;
        std::unique_ptr<NpzTiles> file;
        const RenderedHead* head = nullptr;
    };

    void open(const Inputs&, const Extent&, Result&) const {}
    void begin(const Inputs&, Scratch& s) const {
        s.any = false;
        for (auto& values : s.values) values.clear();
        for (auto& ids : s.ids) ids.clear();
    }
    void batch(const Inputs& in, Scratch& s) const {
        if (file.path.empty()) return;
        const RenderedTiles& from = in.get<RenderedTiles>("samples");
        const Tile& tile = in.tile();
        if (!s.any) {
            s.any = true;
            s.head = from.head;
            s.meta = from.head->samples.meta.dump();
            s.samples = from.head->samples.size();
            s.channels = from.head->channels;
            s.row_first.clear();
            s.counts.clear();
            for (int y = tile.y0; y < tile.y1; ++y) {
                s.row_first.push_back(from.head->plan->first(tile.x0, y));
                for (int x = tile.x0; x < tile.x1; ++x)
                    s.counts.push_back(std::uint32_t(from.head->plan->of(x, y)));
            }
        }
        for (const ChannelId c : s.channels.list()) {
            const size_t i = size_t(c);
            s.values[i].insert(s.values[i].end(), from.batch.values[i].begin(),
                               from.batch.values[i].end());
            s.ids[i].insert(s.ids[i].end(), from.batch.ids[i].begin(), from.batch.ids[i].end());
        }
    }

    void end(const Inputs& in, Scratch& s, Result& result) const {
        if (!s.any) return;
        {
            const std::lock_guard lock(result.mutex);
            if (s.head) result.head = s.head;
            if (!result.file) {
                Samples head;
                read_meta(s.meta, file.path, head);
                head.set_size(s.samples);
                std::vector<NpzTiles::Member> members;
                for (const ChannelId c : s.channels.list())
                    members.push_back(
                        {std::string(info_of(c).name), info_of(c).components, info_of(c).whole});
                result.file = std::make_unique<NpzTiles>(file.path, head, std::move(members));
            }
        }
        NpzTiles& to = *result.file;
        const Tile& tile = in.tile();
        const size_t across = size_t(tile.width());
        const std::vector<ChannelId> channels = s.channels.list();
        size_t at = 0;
        for (size_t row = 0; row < size_t(tile.height()); ++row) {
            size_t samples = 0;
            for (size_t x = 0; x < across; ++x) samples += s.counts[row * across + x];
            for (size_t c = 0; c < channels.size(); ++c) {
                const size_t k = size_t(info_of(channels[c]).components), i = size_t(channels[c]);
                if (info_of(channels[c]).whole)
                    to.write(c, s.row_first[row],
                             std::span<const std::uint32_t>(s.ids[i]).subspan(at, samples));
                else
                    to.write(c, s.row_first[row],
                             std::span<const float>(s.values[i]).subspan(at * k, samples * k));
            }
            if (to.adaptive())
                to.write_counts(
                    std::uint64_t(tile.y0 + int(row)) * std::uint64_t(in.extent().width) +
                        std::uint64_t(tile.x0),
                    std::span<const std::uint32_t>(s.counts).subspan(row * across, across));
            at += samples;
        }
    }

    void close(const Inputs&, Result& result, Outputs&, Context& ctx) const {
        if (file.path.empty()) return;
        if (!result.file) ctx.fail("there were no samples to write");
        if (result.head) result.head->warn(ctx);
        result.file->close(ctx);
    }

    void save(const Inputs&, const Scratch& s, ByteWriter& to) const {
        to.put(std::uint8_t(s.any));
        if (!s.any) return;
        to.put_text(s.meta);
        to.put(s.samples);
        to.put(s.channels);
        to.put_all(s.row_first);
        to.put_all(s.counts);
        for (const ChannelId c : s.channels.list()) {
            if (info_of(c).whole)
                to.put_all(s.ids[size_t(c)]);
            else
                to.put_all(s.values[size_t(c)]);
        }
    }
    void load(const Inputs& in, ByteReader& from, Scratch& s) const {
        s.any = from.take<std::uint8_t>() != 0;
        if (!s.any) return;
        s.meta = from.take_text();
        s.samples = from.take<std::uint64_t>();
        s.channels = from.take<ChannelSet>();
        const Tile& tile = in.tile();
        s.row_first.resize(size_t(tile.height()));
        s.counts.resize(size_t(tile.width()) * size_t(tile.height()));
        from.fill(s.row_first);
        from.fill(s.counts);
        std::uint64_t samples = 0;
        for (const std::uint32_t count : s.counts) samples += count;
        for (const ChannelId c : s.channels.list()) {
            const size_t i = size_t(c);
            if (info_of(c).whole)
                s.ids[i] = from.take_all<std::uint32_t>();
            else
                s.values[i] = from.take_all<float>();
            const size_t numbers = info_of(c).whole ? s.ids[i].size() : s.values[i].size();
            if (numbers != samples * std::uint64_t(info_of(c).components))
                throw Error("holds another number of samples than its pixels have");
        }
    }
};

WEFT_NODE(WriteTiles, "write-tiles", 1);

}  // namespace
}  // namespace weft::render
