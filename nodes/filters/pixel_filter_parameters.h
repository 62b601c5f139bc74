// The parameters of nodes that have a pixel filter: such a node inherits FilterChoice and declares
// its fields by these.
#pragma once
#include "filters/pixel_filters.h"
#include "runtime/node.h"

namespace weft {

// Its width and what some filters have besides; `widest`: how wide it may be, in pixels.
template <class Node>
void declare_filter_sizes(Ports<Node>& node, double widest) {
    const auto of = [](float FilterChoice::*field) { return static_cast<float Node::*>(field); };
    node.param("width", of(&FilterChoice::width),
               {.unit = "px",
                .min = 0,
                .max = widest,
                .about = "all across; 0: the filter's own (box 1, tent 2, gaussian 3, mitchell 4, "
                         "lanczos 6, blackman-harris 3)"})
        .param("sigma", of(&FilterChoice::sigma),
               {.unit = "px", .min = 0.01, .max = widest, .about = "gaussian: standard deviation"})
        .param("b", of(&FilterChoice::b), {.min = -3, .max = 3, .about = "mitchell: B, blur"})
        .param("c", of(&FilterChoice::c), {.min = -3, .max = 3, .about = "mitchell: C, ringing"})
        .param(
            "tau", of(&FilterChoice::tau),
            {.unit = "px", .min = 0.5, .max = widest, .about = "lanczos: where its window ends"});
}

// Of nodes that sum what each pixel gives to all around it: the widest filter costs memory.
template <class Node>
void declare_filter(Ports<Node>& node) {
    node.choice("filter", static_cast<FilterKind Node::*>(&FilterChoice::kind), filter_names(),
                {.about = "pixel filter"});
    declare_filter_sizes(node, 16);
}

}  // namespace weft
