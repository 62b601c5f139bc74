#include "rpf/streams.h"

#include <string>

#include "graph/error.h"

namespace weft {

void Neighbourhoods::describe(FieldVisitor& see) const {
    const std::array<std::uint32_t, 2> all{0, std::uint32_t(samples())};
    see.field("own", std::array{std::uint32_t(own())});
    see.field("scale", scale, int(scale.size()));
    see.field("mean", mean, int(mean.size()));
    see.children("samples", all);
    see.field("sample", sample);
}

void Weights::describe(FieldVisitor& see) const {
    see.field("w-random", std::array{w_random});
    see.field("w-color", w_color, 3);
    see.field("weight", of_row, int(of_row.size()));
}

void SampleColors::take_own(const Neighbourhoods& around, const Samples& colors) {
    if (colors.size() != around.vectors->size())
        throw Error("'colors' has " + std::to_string(colors.size()) +
                    " samples, the vectors were made of " + std::to_string(around.vectors->size()) +
                    "; link what an earlier pass made of the same buffer");
    own_pixels = around.own_pixels;
    own_offset = around.own_offset;
    sample.assign(around.sample.begin(), around.sample.begin() + std::ptrdiff_t(around.own()));
    rgb.resize(3 * sample.size());
    effective.resize(sample.size());
}

void SampleColors::describe(FieldVisitor& see) const {
    const std::array<std::uint32_t, 2> all{0, std::uint32_t(sample.size())};
    see.children("samples", all);
    see.field("sample", sample);
    see.field("rgb", rgb, 3);
    see.field("effective", effective);
}

}  // namespace weft
