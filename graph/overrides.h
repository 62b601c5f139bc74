// The options of the command line that change a graph, taken apart: --set, --swap, --bypass.
#pragma once
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "graph/document.h"
#include "graph/graph.h"

namespace weft::loading {

struct SetOption {
    std::string node;  // "": a parameter of the graph
    Word name;         // the parameter
    Word value;
    Place place;  // the whole option
    bool used = false;
};

struct SwapOption {
    std::string node;
    Word type;
    int pin = 0;
    std::vector<SetOption> settings;
    Place place;
    bool used = false;
};

struct BypassOption {
    std::string node;
    Place place;
    bool used = false;
};

struct Options {
    std::deque<SetOption> set;
    std::deque<SwapOption> swap;
    std::deque<BypassOption> bypass;

    // The last one given counts; all are marked as used.
    const SwapOption* swap_of(std::string_view node);
    const BypassOption* bypass_of(std::string_view node);
    const SetOption* set_of(std::string_view node, std::string_view name);
};

Options take_options(const Overrides& overrides, Findings& findings);

// The value an option gives to a parameter: JSON if it is, where the kind allows; else the text
// itself.
Json option_value(const Word& value, Kind kind);

}  // namespace weft::loading
