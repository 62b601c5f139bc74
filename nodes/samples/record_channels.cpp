#include "samples/record_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "graph/error.h"
#include "runtime/context.h"

namespace weft {
namespace {

bool all_zero(std::span<const float> values) {
    return std::all_of(values.begin(), values.end(), [](float v) { return v == 0; });
}

}  // namespace

Samples samples_of_header(const RecordHeader& header) {
    Samples samples;
    samples.width = header.width;
    samples.height = header.height;
    samples.spp = header.spp;
    samples.set_size(header.records());
    samples.lens = Lens{.c0 = header.c0, .c1 = header.c1};
    return samples;
}

Array<float> columns(const Array<float>& records, size_t width, size_t first, size_t components,
                     Context& ctx) {
    const size_t count = records.size() / width;
    const std::shared_ptr<float[]> values(new float[count * components]);
    const float* from = records.view().data() + first;
    ctx.parallel(count, size_t{1} << 16, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            for (size_t k = 0; k < components; ++k)
                values[i * components + k] = from[i * width + k];
    });
    return {{values.get(), count * components}, values};
}

void restore_infinite_depth(std::vector<float>& z) {
    for (float& depth : z)
        if (depth >= record_infinity) depth = std::numeric_limits<float>::infinity();
}

void drop_idle_channels(Samples& samples) {
    const auto drop = [&](std::string_view name) {
        std::erase_if(samples.channels, [&](const Channel& c) { return c.name == name; });
    };
    if (samples.lens && samples.lens->pinhole() && all_zero(samples.uv())) {
        drop("uv");
        samples.lens.reset();
    }
    if (all_zero(samples.t()) && all_zero(samples.motion())) {
        drop("t");
        drop("motion");
    }
    if (all_zero(samples.values("z_gradient"))) drop("z_gradient");
}

void check_record_writable(const Samples& samples, const std::string& path, SampleFormat format,
                           std::initializer_list<std::string_view> held, Context& ctx) {
    if (samples.domain != "camera")
        throw Error(
            fmt::format("cannot write '{}': {} has pixels and this buffer, seen from a light, has "
                        "none; write .npz",
                        path, name_of(format)));
    if (samples.spp == 0)
        throw Error(
            fmt::format("cannot write '{}': {} has the same number of samples in every pixel, in "
                        "this buffer it varies; write .npz or .exr",
                        path, name_of(format)));
    samples.require(fmt::format("{} file", name_of(format)), {"xy", "z", "rgb"});
    std::vector<std::string> lost;
    for (const Channel& channel : samples.channels)
        if (std::find(held.begin(), held.end(), channel.name) == held.end())
            lost.push_back(channel.name);
    if (samples.lens && *samples.lens != Lens{.c0 = samples.lens->c0, .c1 = samples.lens->c1})
        lost.push_back("the lens' aspect, blades and rotation");
    if (samples.color_space != "lin_rec709")
        lost.push_back(fmt::format("the colour space ({})", samples.color_space));
    const Json meta = samples.meta_object();
    for (const JsonMember& member : meta.members)
        for (const std::string_view key : {"source", "shutter", "shutter_curve", "lights"})
            if (member.key == key && !member.value.is(Json::Kind::null))
                lost.push_back(fmt::format("'{}' of meta", key));
    if (!lost.empty())
        ctx.warn(fmt::format("{}: {} cannot hold {}; write .npz to keep {}", path, name_of(format),
                             fmt::join(lost, ", "), lost.size() > 1 ? "them" : "it"));
    const auto z = samples.z();
    const auto far = std::count_if(z.begin(), z.end(), [](float depth) {
        return depth >= record_infinity && depth <= std::numeric_limits<float>::max();
    });
    if (far > 0)
        ctx.warn(
            fmt::format("{}: {} holds no depth of 1e10 and more: {} sample{} will read back as at "
                        "infinity",
                        path, name_of(format), far, far == 1 ? "" : "s"));
}

}  // namespace weft
