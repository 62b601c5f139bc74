#include "tests/runtime/toy_nodes.h"

#include <gtest/gtest.h>

#include <fstream>

#include "runtime/atomic_file.h"
#include "runtime/fusion.h"

namespace weft {

std::function<void()> on_hook;

Notes& Notes::instance() {
    static Notes notes;
    return notes;
}
const Grid& Notes::grid(const std::string& label) {
    for (const auto& [name, grid] : grids)
        if (name == label) return grid;
    static const Grid none;
    ADD_FAILURE() << "nothing was noted as " << label;
    return none;
}
bool Notes::has(const std::string& label) {
    const auto same = [&](const auto& entry) { return entry.first == label; };
    return std::any_of(grids.begin(), grids.end(), same) || std::any_of(numbers.begin(), numbers.end(), same);
}
void Notes::clear() {
    grids.clear();
    numbers.clear();
}

Graph toy_graph(const std::string& text, const Overrides& overrides) {
    LoadOptions options;
    options.overrides = overrides;
    options.for_run = true;
    Loaded loaded = load_graph_text(text, "toy.json", Registry::instance(), options);
    for (const Diagnostic& finding : loaded.findings)
        if (finding.level == Diagnostic::Level::error) ADD_FAILURE() << to_text(finding);
    return std::move(loaded.graph);
}

RunResult run_toy(const Graph& graph, Executor& executor, const RunOptions& options) {
    Notes::instance().clear();
    const Plan plan = make_plan(graph);
    Monitor monitor;
    return run_plan(plan, executor, monitor, options);
}

namespace {

struct ToyNumber {
    double value = 1;
    bool fail = false;
    static void declare(Ports<ToyNumber>& node) {
        node.about("makes a number").out<Number>("number", "it").param("value", &ToyNumber::value).param("fail", &ToyNumber::fail);
    }
    Cost cost(const Shapes&) const { return {{{"number", {.bytes = 1000}}}, 500}; }
    void run(const Inputs&, Outputs& out, Context& ctx) const {
        if (fail) ctx.fail("no number today");
        out.set("number", Number{value});
    }
};
WEFT_NODE(ToyNumber, "toy-number", 1)

struct ToyAdd {
    static void declare(Ports<ToyAdd>& node) {
        node.about("adds numbers").in<Number>("numbers", "to add", Need::variadic).out<Number>("sum", "of all");
    }
    Cost cost(const Shapes&) const { return {{{"sum", {.bytes = 3000}}}}; }
    void run(const Inputs& in, Outputs& out, Context&) const {
        double sum = 0;
        for (const Number* n : in.all<Number>("numbers")) sum += n->value;
        out.set("sum", Number{sum});
    }
};
WEFT_NODE(ToyAdd, "toy-add", 1)

// Adds in parallel loops within parallel loops.
struct ToyNested {
    static void declare(Ports<ToyNested>& node) {
        node.about("counts in nested loops").out<Number>("number", "how often").in<Number>("number", "unused", Need::optional);
    }
    void run(const Inputs&, Outputs& out, Context& ctx) const {
        const double sum = ctx.reduce(
            64, 4, 0.0,
            [&](size_t begin, size_t end) {
                std::atomic<int> inner = 0;
                ctx.parallel_for(end - begin, [&](size_t) { ctx.parallel_for(8, [&](size_t) { ++inner; }); });
                return double(inner);
            },
            [](double a, double b) { return a + b; });
        out.set("number", Number{sum});
    }
};
WEFT_NODE(ToyNested, "toy-nested", 1)

struct ToyHook {
    static void declare(Ports<ToyHook>& node) {
        node.about("calls the test").in<Number>("number", "passed on", Need::optional).out<Number>("number", "what came in");
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        if (on_hook) on_hook();
        ctx.check_cancelled();
        out.set("number", in.get_or<Number>("number", Number{}));
    }
};
WEFT_NODE(ToyHook, "toy-hook", 1)

struct ToyNote {
    std::string label = "note";
    static void declare(Ports<ToyNote>& node) {
        node.about("tells the test").writes().in<Grid>("grid", "to tell", Need::optional).in<Number>("number", "to tell", Need::optional)
            .param("label", &ToyNote::label);
    }
    void run(const Inputs& in, Outputs&, Context&) const {
        Notes& notes = Notes::instance();
        const std::lock_guard lock(notes.mutex);
        if (const Grid* grid = in.find<Grid>("grid")) notes.grids.emplace_back(label, *grid);
        if (const Number* number = in.find<Number>("number")) notes.numbers.emplace_back(label, number->value);
    }
};
WEFT_NODE(ToyNote, "toy-note", 1)

// Rounds of one record a pixel of the tile, at most 50 records a batch.
struct ToyDots {
    int width = 100, height = 70, rounds = 3;
    static void declare(Ports<ToyDots>& node) {
        node.about("makes dots").in<Number>("number", "added to every value", Need::optional).out<Dots>("dots", "a record a pixel and round")
            .param("width", &ToyDots::width).param("height", &ToyDots::height).param("rounds", &ToyDots::rounds);
    }
    Extent extent(const Inputs&) const { return {width, height}; }
    bool next(const Inputs& in, size_t index, Outputs& out) const {
        const Tile& tile = in.tile();
        const size_t pixels = size_t(tile.width()) * size_t(tile.height()), a_round = (pixels + 49) / 50;
        if (index >= a_round * size_t(rounds)) return false;
        const size_t round = index / a_round, begin = index % a_round * 50, end = std::min(pixels, begin + 50);
        const float base = float(in.get_or<Number>("number", Number{}).value);
        Dots& dots = out.get<Dots>("dots");
        dots.value.clear();
        dots.owned_pixels.clear();
        for (size_t i = begin; i < end; ++i) {
            const int x = tile.x0 + int(i) % tile.width(), y = tile.y0 + int(i) / tile.width();
            dots.owned_pixels.push_back(std::uint32_t(y * width + x));
            dots.value.push_back(base + 0.1f * float(x) + 0.01f * float(y) + 0.3f * float(round));
        }
        dots.pixels = dots.owned_pixels;
        return true;
    }
};
WEFT_NODE(ToyDots, "toy-dots", 1)

struct ToyScale {
    float by = 2;
    int fail_at_pixel = -1;
    static void declare(Ports<ToyScale>& node) {
        node.about("scales dots").in<Dots>("dots", "to scale").in<Number>("number", "a further factor", Need::optional).out<Dots>("dots", "scaled")
            .param("by", &ToyScale::by).param("fail-at-pixel", &ToyScale::fail_at_pixel);
    }
    void batch(const Inputs& in, Outputs& out) const {
        const Dots& dots = in.get<Dots>("dots");
        const float factor = by * float(in.get_or<Number>("number", Number{1}).value);
        Dots& scaled = out.get<Dots>("dots");
        scaled.value.resize(dots.size());
        for (size_t i = 0; i < dots.size(); ++i) {
            if (int(dots.pixels[i]) == fail_at_pixel) throw Error("cannot scale this one");
            scaled.value[i] = dots.value[i] * factor;
        }
    }
};
WEFT_NODE(ToyScale, "toy-scale", 1)

struct ToyOdd {
    static void declare(Ports<ToyOdd>& node) {
        node.about("selects the dots of odd pixels").in<Dots>("dots", "all").out<Dots>("dots", "all").out_selection<Dots>("odd", "those of odd pixels");
    }
    void batch(const Inputs& in, Outputs& out) const {
        const Dots& dots = in.get<Dots>("dots");
        if (out.wanted("dots")) out.get<Dots>("dots").value = dots.value;
        if (!out.wanted("odd")) return;
        Dots& odd = out.get<Dots>("odd");
        odd.value.clear();
        odd.owned_pixels.clear();
        odd.owned_parents.clear();
        for (size_t i = 0; i < dots.size(); ++i)
            if (dots.pixels[i] % 2) {
                odd.value.push_back(dots.value[i]);
                odd.owned_pixels.push_back(dots.pixels[i]);
                odd.owned_parents.push_back(std::uint32_t(i));
            }
        odd.pixels = odd.owned_pixels;
        odd.parents = odd.owned_parents;
    }
};
WEFT_NODE(ToyOdd, "toy-odd", 1)

// toy-scale and toy-odd in one go; not by 7.
struct ToyScaleOdd {
    float by = 0;
    int fail_at_pixel = -1;
    static void declare(Fusing<ToyScaleOdd>& fusing) {
        fusing.about("scales dots and selects those of odd pixels")
            .part("toy-scale").part("toy-odd")
            .inner("toy-scale.dots", {"toy-odd.dots"})
            .in("dots", {"toy-scale.dots"})
            .in("number", {"toy-scale.number"})
            .out("dots", "toy-odd.dots")
            .out("odd", "toy-odd.odd")
            .param("toy-scale.by", &ToyScaleOdd::by)
            .param("toy-scale.fail-at-pixel", &ToyScaleOdd::fail_at_pixel);
    }
    bool suits() const { return by != 7; }
    struct Scratch {
        Dots scaled;
        std::vector<std::uint32_t> batches;
    };
    void batch(const Inputs& in, Outputs& out, Scratch& scratch) const {
        const Dots& dots = in.get<Dots>("dots");
        const float factor = by * float(in.get_or<Number>("number", Number{1}).value);
        Dots& scaled = out.wanted("dots") ? out.get<Dots>("dots") : scratch.scaled;
        scaled.value.resize(dots.size());
        Dots* odd = out.wanted("odd") ? &out.get<Dots>("odd") : nullptr;
        if (odd) odd->value.clear(), odd->owned_pixels.clear(), odd->owned_parents.clear();
        for (size_t i = 0; i < dots.size(); ++i) {
            if (int(dots.pixels[i]) == fail_at_pixel) throw Error("cannot scale this one");
            scaled.value[i] = dots.value[i] * factor;
            if (!odd || dots.pixels[i] % 2 == 0) continue;
            odd->value.push_back(scaled.value[i]);
            odd->owned_pixels.push_back(dots.pixels[i]);
            odd->owned_parents.push_back(std::uint32_t(i));
        }
        if (!odd) return;
        odd->pixels = odd->owned_pixels;
        odd->parents = odd->owned_parents;
    }
};
WEFT_FUSION(ToyScaleOdd, "toy-scale-odd")

struct ToyMerge {
    static void declare(Ports<ToyMerge>& node) {
        node.about("puts a selection back").in<Dots>("dots", "all").in_branch<Dots>("branch", "some, which win").out<Dots>("dots", "merged");
    }
    void batch(const Inputs& in, Outputs& out) const {
        const Dots& branch = in.get<Dots>("branch");
        Dots& merged = out.get<Dots>("dots");
        merged.value = in.get<Dots>("dots").value;
        for (size_t i = 0; i < branch.size(); ++i) merged.value[branch.parents[i]] = branch.value[i];
    }
};
WEFT_NODE(ToyMerge, "toy-merge", 1)

struct ToySum {
    using Result = Grid;
    struct Scratch {
        std::vector<double> sums;
    };
    static void declare(Ports<ToySum>& node) {
        node.about("sums dots a pixel").in<Dots>("dots", "to sum").out<Grid>("grid", "the sums").out<Number>("total", "of the grid");
    }
    void open(const Inputs&, const Extent& extent, Result& grid) const {
        grid = {extent.width, extent.height, std::vector<double>(size_t(extent.width) * size_t(extent.height))};
    }
    void begin(const Inputs& in, Scratch& scratch) const {
        scratch.sums.assign(size_t(in.tile().width()) * size_t(in.tile().height()), 0);
    }
    void batch(const Inputs& in, Scratch& scratch) const {
        const Dots& dots = in.get<Dots>("dots");
        for (size_t i = 0; i < dots.size(); ++i) {
            const int x = int(dots.pixels[i]) % in.extent().width - in.tile().x0, y = int(dots.pixels[i]) / in.extent().width - in.tile().y0;
            scratch.sums[size_t(y) * size_t(in.tile().width()) + size_t(x)] += double(dots.value[i]);
        }
    }
    void end(const Inputs& in, Scratch& scratch, Result& grid) const {
        const Tile& tile = in.tile();
        for (int y = tile.y0; y < tile.y1; ++y)
            for (int x = tile.x0; x < tile.x1; ++x)
                grid.cells[size_t(y) * size_t(grid.width) + size_t(x)] =
                    scratch.sums[size_t(y - tile.y0) * size_t(tile.width()) + size_t(x - tile.x0)];
    }
    void save(const Inputs&, const Scratch& scratch, ByteWriter& to) const { to.put_all(scratch.sums); }
    void load(const Inputs&, ByteReader& from, Scratch& scratch) const { from.fill(scratch.sums); }
    void close(const Inputs&, Result& grid, Outputs& out, Context&) const {
        double total = 0;
        for (double cell : grid.cells) total += cell;
        if (out.wanted("total")) out.set("total", Number{total});
        if (out.wanted("grid")) out.set("grid", std::move(grid));
    }
};
WEFT_NODE(ToySum, "toy-sum", 1)

// Reads the first number of a file, and one of a file beside it.
struct ToyRead {
    InputFile file;
    std::string beside;
    static void declare(Ports<ToyRead>& node) {
        node.about("reads a number").out<Number>("number", "it").param("file", &ToyRead::file).param("beside", &ToyRead::beside);
    }
    std::vector<std::string> reads() const { return beside.empty() ? std::vector<std::string>() : std::vector<std::string>{beside}; }
    void run(const Inputs&, Outputs& out, Context&) const {
        Number number;
        std::ifstream(file.path) >> number.value;
        out.set("number", number);
    }
};
WEFT_NODE(ToyRead, "toy-read", 1)

struct ToyWrite {
    OutputFile file;
    static void declare(Ports<ToyWrite>& node) {
        node.about("writes a number").writes().in<Number>("number", "to write").param("file", &ToyWrite::file);
    }
    void run(const Inputs& in, Outputs&, Context& ctx) const {
        write_file(file.path, std::to_string(in.get<Number>("number").value) + " " + ctx.provenance().graph + ctx.provenance().inputs);
    }
};
WEFT_NODE(ToyWrite, "toy-write", 1)

// A grid made row by row: a value whose work can be divided.
struct ToyRows {
    int width = 10, height = 23;
    bool whole = false;
    static void declare(Ports<ToyRows>& node) {
        node.about("makes a grid").in<Number>("number", "added", Need::optional).out<Grid>("grid", "it").param("width", &ToyRows::width)
            .param("height", &ToyRows::height).param("whole", &ToyRows::whole);
    }
    std::vector<double> row(const Inputs& in, size_t y) const {
        std::vector<double> cells(static_cast<size_t>(width));
        const double base = in.get_or<Number>("number", Number{0}).value;
        for (size_t x = 0; x < cells.size(); ++x) cells[x] = base + 1.0 / double(1 + x + 100 * y);
        return cells;
    }
    void run(const Inputs& in, Outputs& out, Context&) const {
        Grid grid{width, height, {}};
        for (size_t y = 0; y < size_t(height); ++y)
            for (double cell : row(in, y)) grid.cells.push_back(cell);
        out.set("grid", std::move(grid));
    }
    bool divides() const { return !whole; }
    size_t pieces(const Inputs&) const { return size_t(height); }
    void piece(const Inputs& in, size_t index, ByteWriter& to, Context&) const { to.put_all(row(in, index)); }
    void join(const Pieces& pieces, Outputs& out, Context&) const {
        Grid grid{width, height, {}};
        for (size_t y = 0; y < pieces.size(); ++y)
            for (double cell : pieces.read(y).take_all<double>()) grid.cells.push_back(cell);
        out.set("grid", std::move(grid));
    }
};
WEFT_NODE(ToyRows, "toy-rows", 1)

// A sink that keeps its tiles to itself.
struct ToyDrain {
    struct Result {};
    struct Scratch {};
    static void declare(Ports<ToyDrain>& node) { node.about("takes dots").in<Dots>("dots", "to take").out<Number>("number", "1"); }
    void open(const Inputs&, const Extent&, Result&) const {}
    void batch(const Inputs&, Scratch&) const {}
    void end(const Inputs&, Scratch&, Result&) const {}
    void close(const Inputs&, Result&, Outputs& out, Context&) const { out.set("number", Number{1}); }
};
WEFT_NODE(ToyDrain, "toy-drain", 1)

struct ToyBatchHook {
    static void declare(Ports<ToyBatchHook>& node) {
        node.about("calls the test once a batch").in<Dots>("dots", "passed on").out<Dots>("dots", "what came in");
    }
    void batch(const Inputs& in, Outputs& out) const {
        if (on_hook) on_hook();
        out.get<Dots>("dots").value = in.get<Dots>("dots").value;
    }
};
WEFT_NODE(ToyBatchHook, "toy-batch-hook", 1)

}  // namespace
}  // namespace weft
