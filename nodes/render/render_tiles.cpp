// render-tiles: what render-samples makes, as a stream: a tile's samples go on to whoever reads
// them (filter-tiles, write-tiles) and are never held whole. The samples are the same, bit for bit.
// A node type of its own, since a node is either a value's maker or a stream's source.
#include "render/render_samples_node.h"
#include "render/rendered_tiles.h"
#include "render/sample_buffer.h"

namespace weft::render {
namespace {

struct RenderTiles : RenderSamplesNode {
    static void declare(Ports<RenderTiles>& node) {
        node.about(
                "renders a scene's samples tile by tile, for filter-tiles and write-tiles, without "
                "holding them all")
            .in<Scene>("scene", "what to render, from its camera")
            .in<Image>("counts",
                       "samples of each pixel, in its first channel; spp, width and height are "
                       "then not looked at",
                       Need::optional)
            .out<RenderedTiles>("samples", "the channels asked for, batch by batch");
        declare_samples(node);
    }

    struct Head {
        std::mutex mutex;
        RenderedHead head;
        const Prepared::Made* of = nullptr;
    };
    std::shared_ptr<Head> shared = std::make_shared<Head>();

    struct Scratch {
        std::shared_ptr<Prepared::Made> made;
        PathWorkspacePointer workspace;
        BatchCursor cursor;
        std::vector<PixelRun> runs;
    };

    Cost cost(const Shapes& in) const {
        const Shape shape = samples_shape(in);
        return {{{"samples", {shape.width, shape.height, 0, shape.records, 0}}},
                16e6,
                double(shape.records) * 1000 * std::max(max_depth, 1)};
    }

    Extent extent(const Inputs& in) const {
        prepared->release();  // another run may have another scene
        PlainContext ctx;
        const auto made = prepare(in, ctx);
        const std::lock_guard lock(shared->mutex);
        shared->head = {empty_samples(made->tracer, made->plan), made->tracer.options().channels,
                        &made->plan, {}};
        shared->head.samples.meta = shared->head.samples.meta_object();
        shared->head.warn = [made, told = std::make_shared<std::atomic<bool>>(false),
                             warnings = ctx.warnings](Context& to) {
            if (told->exchange(true)) return;
            for (const std::string& warning : warnings) to.warn(warning);
            warn_of_deviation(made->tracer, to);
        };
        return {made->plan.width(), made->plan.height()};
    }

    bool next(const Inputs& in, size_t index, Outputs& out, Scratch& scratch) const {
        if (index == 0) {
            PlainContext ctx;
            scratch.made = prepare(in, ctx);
            if (!scratch.workspace) scratch.workspace = scratch.made->tracer.workspace();
            const Tile& tile = in.tile();
            scratch.cursor = BatchCursor(scratch.made->plan, {tile.x0, tile.y0, tile.x1, tile.y1});
        }
        if (!scratch.cursor.next(scratch.runs)) return false;
        RenderedTiles& to = out.get<RenderedTiles>("samples");
        scratch.made->tracer.render(scratch.runs, *scratch.workspace, to.batch);
        to.head = &shared->head;
        to.own_pixels.clear();
        for (const PixelRun& run : scratch.runs)
            to.own_pixels.insert(to.own_pixels.end(), run.count,
                                 std::uint32_t(run.y) * std::uint32_t(scratch.made->plan.width()) +
                                     std::uint32_t(run.x));
        to.pixels = to.own_pixels;
        to.parents = {};
        return true;
    }
};

WEFT_NODE(RenderTiles, "render-tiles", 3);

}  // namespace
}  // namespace weft::render
