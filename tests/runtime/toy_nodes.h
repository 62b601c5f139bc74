// Small nodes for the tests of the runtime: numbers for values, one number a record for streams.
#pragma once
#include <atomic>
#include <mutex>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "runtime/node.h"
#include "runtime/registry.h"
#include "runtime/run.h"

namespace weft {

struct Number {
    double value = 0;
    size_t bytes() const { return sizeof(value); }
    void describe(FieldVisitor& visit) const {
        const float f = float(value);
        visit.field("value", std::span(&f, 1));
    }
};
WEFT_VALUE_TYPE(Number, "Number", "one number")

struct Grid {
    int width = 0, height = 0;
    std::vector<double> cells;
};
WEFT_VALUE_TYPE(Grid, "Grid", "numbers in rows")

struct Dots : Batch {
    std::vector<float> value;
    std::vector<std::uint32_t> owned_pixels, owned_parents;  // of a source and of a selection
    void count(Items& items) const { items.add("dots", size()); }
    void describe(FieldVisitor& visit) const { visit.field("value", std::span(value)); }
};
WEFT_STREAM_TYPE(Dots, "Dots", "one number a record")

// What 'toy-note' was given, by its label.
struct Notes {
    std::mutex mutex;
    std::vector<std::pair<std::string, Grid>> grids;
    std::vector<std::pair<std::string, double>> numbers;
    static Notes& instance();
    const Grid& grid(const std::string& label);
    bool has(const std::string& label);
    void clear();
};

// Called by 'toy-hook' nodes, once a run or once a batch.
extern std::function<void()> on_hook;

// Loads a document given as text; fails the calling test if it has findings of level error.
Graph toy_graph(const std::string& text, const Overrides& overrides = {});

RunResult run_toy(const Graph& graph, Executor& executor, const RunOptions& options = {});

}  // namespace weft
