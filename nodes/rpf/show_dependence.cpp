// show-dependence: a picture of W_c^r, the part of each pixel's colour that depends on random
// parameters: 1 is noise. With dependency-estimate's `random` set to one parameter it is the map of
// that one. Source: Sen and Darabi 2012, Fig. 5 (maps of W_c^r,1, W_c^r,2 and W_c^r).
#include "image/image.h"
#include "rpf/streams.h"
#include "runtime/node.h"

namespace weft {
namespace {

struct ShowDependence {
    static void declare(Ports<ShowDependence>& node) {
        node.about("how far each pixel's colour depends on random parameters, as a picture")
            .in<Neighbourhoods>("neighbourhoods", "which pixels the weights are of")
            .in<Weights>("weights", "what dependency-estimate found")
            .out<Image>("image", "Y: W_c^r, from 0, signal, to 1, noise");
    }
    Cost cost(const Shapes& in) const {
        const Shape s = in["neighbourhoods"];
        const double pixels = double(s.width) * double(s.height);
        return {{{"image", {s.width, s.height, 1, 0, 4 * pixels}}}, 0, 0};
    }

    struct Scratch {
        std::vector<float> values;  // of the tile's pixels
    };
    struct Result {
        Image image;
    };
    void open(const Inputs&, const Extent& extent, Result& result) const {
        result.image = Image(extent.width, extent.height, 1);
    }
    void begin(const Inputs& in, Scratch& scratch) const {
        scratch.values.assign(size_t(in.tile().width()) * size_t(in.tile().height()), 0.0f);
    }
    void batch(const Inputs& in, Scratch& scratch) const {
        const Neighbourhoods& n = in.get<Neighbourhoods>("neighbourhoods");
        const Tile& tile = in.tile();
        for (int y = std::max(n.block.y0, tile.y0); y < std::min(n.block.y1, tile.y1); ++y)
            for (int x = std::max(n.block.x0, tile.x0); x < std::min(n.block.x1, tile.x1); ++x)
                scratch.values[size_t(y - tile.y0) * size_t(tile.width()) + size_t(x - tile.x0)] =
                    in.get<Weights>("weights").w_random;
    }
    void end(const Inputs& in, Scratch& scratch, Result& result) const {
        const Tile& tile = in.tile();
        for (int y = tile.y0; y < tile.y1; ++y)
            std::copy_n(&scratch.values[size_t(y - tile.y0) * size_t(tile.width())], tile.width(),
                        result.image.at(tile.x0, y));
    }
    void save(const Inputs&, const Scratch& scratch, ByteWriter& to) const {
        to.put_all(scratch.values);
    }
    void load(const Inputs&, ByteReader& from, Scratch& scratch) const {
        from.fill(scratch.values);
    }
    void close(const Inputs&, Result& result, Outputs& out, Context&) const {
        out.set("image", std::move(result.image));
    }
};

WEFT_NODE(ShowDependence, "show-dependence", 1)

}  // namespace
}  // namespace weft
