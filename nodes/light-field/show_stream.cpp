// Debug sinks: pictures of what happens at locations, a pixel the mean over its own.
//   show-candidates   how many samples are near a location
//   show-surfaces     how many surfaces they make
//   show-decision     how visibility was settled: parts of the locations that are undecided, one surface,
//                     covered, last or nearest
#include <array>

#include "image/image.h"
#include "light-field/streams.h"
#include "runtime/node.h"

namespace weft {
namespace {

// What the three have in common. Node::values(batch, l, out) gives channels of one location.
template <class Node, class Stream, size_t channels>
struct Show {
    struct Scratch {
        std::vector<float> sums;
    };
    struct Result {
        Image image;
    };
    void open(const Inputs&, const Extent& extent, Result& result) const {
        result.image = Image(extent.width, extent.height, Node::channel_names());
    }
    void begin(const Inputs& in, Scratch& scratch) const {
        scratch.sums.assign(size_t(in.tile().width()) * size_t(in.tile().height()) * (channels + 1), 0);
    }
    void batch(const Inputs& in, Scratch& scratch) const {
        const Stream& stream = in.get<Stream>(Node::port);
        const Tile& tile = in.tile();
        const auto across = std::uint32_t(in.extent().width);
        for (size_t l = 0; l < stream.size(); ++l) {
            const std::uint32_t px = stream.pixels[l] % across, py = stream.pixels[l] / across;
            const size_t local = size_t(py - std::uint32_t(tile.y0)) * size_t(tile.width()) + (px - std::uint32_t(tile.x0));
            std::array<float, channels> values{};
            Node::values(stream, l, values);
            float* to = &scratch.sums[local * (channels + 1)];
            for (size_t k = 0; k < channels; ++k) to[k] += values[k];
            to[channels] += 1;
        }
    }
    void end(const Inputs& in, Scratch& scratch, Result& result) const {
        const Tile& tile = in.tile();
        const float* of = scratch.sums.data();
        for (int y = tile.y0; y < tile.y1; ++y)
            for (int x = tile.x0; x < tile.x1; ++x, of += channels + 1)
                for (size_t k = 0; k < channels && of[channels] > 0; ++k) result.image.at(x, y)[k] = of[k] / of[channels];
    }
    void save(const Inputs&, const Scratch& scratch, ByteWriter& to) const { to.put_all(scratch.sums); }
    void load(const Inputs&, ByteReader& from, Scratch& scratch) const { from.fill(scratch.sums); }
    void close(const Inputs&, Result& result, Outputs& out, Context&) const { out.set("image", std::move(result.image)); }
};

struct ShowCandidates : Show<ShowCandidates, Candidates, 1> {
    static constexpr const char* port = "candidates";
    static std::vector<std::string> channel_names() { return {"Y"}; }
    static void values(const Candidates& c, size_t l, std::array<float, 1>& out) { out[0] = float(c.of(l)); }
    static void declare(Ports<ShowCandidates>& node) {
        node.about("how many samples are near a location, a mean a pixel")
            .in<Candidates>("candidates", "the samples near each location")
            .out<Image>("image", "Y: candidates a location");
    }
};

struct ShowSurfaces : Show<ShowSurfaces, Surfaces, 1> {
    static constexpr const char* port = "surfaces";
    static std::vector<std::string> channel_names() { return {"Y"}; }
    static void values(const Surfaces& s, size_t l, std::array<float, 1>& out) { out[0] = float(s.count_of[l]); }
    static void declare(Ports<ShowSurfaces>& node) {
        node.about("how many surfaces are near a location, a mean a pixel")
            .in<Surfaces>("surfaces", "surfaces of the samples near each location")
            .out<Image>("image", "Y: surfaces a location");
    }
};

struct ShowDecision : Show<ShowDecision, Visibility, 3> {
    static constexpr const char* port = "visibility";
    static std::vector<std::string> channel_names() { return {"R", "G", "B"}; }
    static void values(const Visibility& v, size_t l, std::array<float, 3>& out) {
        const Decision d = v.decision[l];
        out = {d == Decision::undecided || d == Decision::nearest ? 1.0f : 0.0f, d == Decision::covered || d == Decision::last ? 1.0f : 0.0f,
               d == Decision::one ? 1.0f : 0.0f};
    }
    static void declare(Ports<ShowDecision>& node) {
        node.about("how visibility was settled, as a picture of parts")
            .in<Visibility>("visibility", "the surface seen from each location")
            .out<Image>("image", "R: undecided, G: one surface of several, B: one surface in all");
    }
};

WEFT_NODE(ShowCandidates, "show-candidates", 1)
WEFT_NODE(ShowSurfaces, "show-surfaces", 1)
WEFT_NODE(ShowDecision, "show-decision", 1)

}  // namespace
}  // namespace weft
