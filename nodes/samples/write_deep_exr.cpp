#include "samples/write_deep_exr.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <fmt/format.h>

#include "graph/error.h"
#include "runtime/atomic_file.h"
#include "runtime/context.h"
#include "samples/exr_channels.h"
#include "samples/sample_meta.h"

namespace weft {
namespace {

// One component of one of our channels, and the place of each pixel's first sample in it.
struct Plane {
    std::string name;
    const char* values = nullptr;
    size_t stride = 0;  // bytes from sample to sample
    Imf::PixelType type = Imf::FLOAT;
    std::vector<const char*> of_pixel;  // of one line
};

std::vector<Plane> planes_of(const Samples& samples, const std::string& path, Context& ctx) {
    std::vector<Plane> planes;
    for (const Channel& channel : samples.channels) {
        for (int part = 0; part < channel.components; ++part) {
            const std::string name = exr_name(channel, part);
            const ExrPart back = exr_part(name);
            if (back.channel != channel.name || back.part != part || name.size() > 255) {
                ctx.warn(
                    fmt::format("{}: channel '{}' is left out: '{}' cannot be its name in a deep "
                                "EXR; rename it or write .npz",
                                path, channel.name, name));
                break;
            }
            Plane plane;
            plane.name = name;
            plane.stride = sizeof(float) * size_t(channel.components);
            plane.type = channel.whole() ? Imf::UINT : Imf::FLOAT;
            plane.values = channel.whole()
                               ? reinterpret_cast<const char*>(channel.ids.view().data() + part)
                               : reinterpret_cast<const char*>(channel.values.view().data() + part);
            planes.push_back(std::move(plane));
        }
    }
    return planes;
}

}  // namespace

void write_deep_exr(const Samples& samples, const std::string& path, bool deflate, Context& ctx) {
    if (samples.domain != "camera")
        throw Error(
            fmt::format("cannot write '{}': a deep EXR has pixels and this buffer, seen from a "
                        "light, has none; write .npz",
                        path));
    std::vector<Plane> planes = planes_of(samples, path, ctx);
    AtomicFile file(path);
    try {
        Imf::Header header(samples.width, samples.height);
        header.setType(Imf::DEEPSCANLINE);
        header.compression() = deflate ? Imf::ZIPS_COMPRESSION : Imf::NO_COMPRESSION;
        header.insert("weft:meta", Imf::StringAttribute(meta_to_write(samples, ctx).dump()));

        // Slices of one line, used for all: their line stride is 0. The library only reads from
        // them.
        const auto width = size_t(samples.width);
        std::vector<unsigned> counts(width);
        Imf::DeepFrameBuffer frame;
        frame.insertSampleCountSlice(
            Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts.data()), sizeof(unsigned), 0));
        for (Plane& plane : planes) {
            plane.of_pixel.resize(width);
            header.channels().insert(plane.name, Imf::Channel(plane.type));
            frame.insert(plane.name,
                         Imf::DeepSlice(plane.type, reinterpret_cast<char*>(plane.of_pixel.data()),
                                        sizeof(char*), 0, plane.stride));
        }
        Imf::DeepScanLineOutputFile out(file.temporary().c_str(), header, 0);
        out.setFrameBuffer(frame);
        for (size_t y = 0; y < size_t(samples.height); ++y) {
            ctx.check_cancelled();
            for (size_t x = 0; x < width; ++x) {
                const Samples::Range range = samples.of_pixel(y * width + x);
                counts[x] = unsigned(range.end - range.begin);
                for (Plane& plane : planes)
                    plane.of_pixel[x] = plane.values + range.begin * plane.stride;
            }
            out.writePixels(1);
        }
    } catch (const Cancelled&) {
        throw;
    } catch (const std::exception& error) {
        throw Error(fmt::format("cannot write '{}': {}", path, error.what()));
    }
    file.commit();
}

}  // namespace weft
