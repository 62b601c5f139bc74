// process-sampler: a renderer of somebody else's as a child process, asked for batches of points
// over a socket (renderer_process.h says how).
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <memory>

#include <sys/mman.h>
#include <unistd.h>

#include "adaptive/renderer_process.h"
#include "adaptive/sampler_shape.h"
#include "samples/npy.h"
#include "samples/zip_reader.h"
#include "samples/zip_writer.h"

namespace weft {
namespace {
using namespace adaptive;

template <class T>
std::span<const std::uint8_t> bytes_of(const std::vector<T>& values) {
    return {reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(T)};
}

// A file in memory, which the writer of zips takes for one on disk.
class MemoryFile {
  public:
    MemoryFile() : file_(::memfd_create("weft-question", MFD_CLOEXEC)) {
        if (file_ < 0) throw Error("no memory for a question to the renderer");
    }
    ~MemoryFile() { ::close(file_); }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    std::string path() const { return fmt::format("/proc/self/fd/{}", file_); }

  private:
    int file_;
};

// The processes, each with its questions one by one; a question goes to any.
class Renderers {
  public:
    Renderers(const std::vector<std::string>& command, int processes, double timeout_s,
              const SamplerFunction& sampler)
        : width_(sampler.width), height_(sampler.height), features_(sampler.features) {
        for (const SamplerAxis& axis : sampler.axes) axes_ += axis.name + "\n";
        for (int i = 0; i < processes; ++i)
            all_.push_back(std::make_unique<RendererProcess>(command, timeout_s));
        name_ = fmt::format("the answer of '{}'", command[0]);
    }

    void evaluate(const SamplerPoints& points, std::uint64_t hidden_seed, std::span<float> values) {
        const size_t n = points.size();
        if (n == 0) return;
        size_t stride = 3;
        for (const SamplerFeature& feature : features_) stride += size_t(feature.components);
        // Numbers of 8 bytes, their headers, and room to spare.
        const size_t most = 65536 + 4096 * features_.size() + 2 * 8 * stride * n;
        const std::vector<std::uint8_t> answer =
            all_[next_++ % all_.size()]->ask(question(points, hidden_seed), most);
        FileBytes file{name_, answer, nullptr, false};
        const std::vector<ZipMember> members = zip_members(file);
        take(file, members, "rgb", 3, n, values, stride, 0);
        size_t before = 3;
        for (const SamplerFeature& feature : features_) {
            take(file, members, feature.name, size_t(feature.components), n, values, stride,
                 before);
            before += size_t(feature.components);
        }
    }

  private:
    std::vector<std::uint8_t> question(const SamplerPoints& points,
                                       std::uint64_t hidden_seed) const {
        const size_t n = points.size(), axes = points.axes.size();
        std::vector<float> point(axes * n);
        for (size_t d = 0; d < axes; ++d)
            for (size_t i = 0; i < n; ++i) point[axes * i + d] = points.axes[d][i];
        const std::vector<char> names(axes_.begin(), axes_.end());
        const std::vector<std::uint32_t> size{std::uint32_t(width_), std::uint32_t(height_)},
            seed{std::uint32_t(hidden_seed)};
        std::vector<ZipPiece> pieces{
            {"point.npy", npy_header("<f4", {n, axes}), bytes_of(point), {}, 0},
            {"axes.npy", npy_header("|u1", {names.size()}), bytes_of(names), {}, 0},
            {"size.npy", npy_header("<u4", {2}), bytes_of(size), {}, 0},
            {"seed.npy", npy_header("<u4", {1}), bytes_of(seed), {}, 0}};
        const MemoryFile memory;
        ZipWriter zip(memory.path());
        for (ZipPiece& piece : pieces) {
            finish(piece, false);
            zip.add(piece);
        }
        zip.close();
        const FileBytes written = map_file(memory.path());
        return {written.bytes.begin(), written.bytes.end()};
    }
    void take(const FileBytes& file, const std::vector<ZipMember>& members, const std::string& name,
              size_t components, size_t n, std::span<float> values, size_t stride,
              size_t before) const {
        const auto found = std::find_if(members.begin(), members.end(), [&](const ZipMember& m) {
            return m.name == name + ".npy" || m.name == name;
        });
        if (found == members.end())
            throw Error(fmt::format("{} has no array '{}'; expected {} x {} numbers", name_, name,
                                    n, components));
        const FileBytes bytes = zip_bytes(file, *found);
        const std::string what = fmt::format("{}: '{}'", name_, name);
        const Npy array = parse_npy(bytes.bytes, what);
        const std::vector<std::uint64_t>& shape = array.shape;
        if (shape.empty() || shape[0] != n || array.numbers() != n * components)
            throw Error(fmt::format("{} is {}; expected ({}, {}): one row for each point asked for",
                                    what, shape_text(shape), n, components));
        PlainContext plain;
        const Array<float> numbers = npy_floats(array, nullptr, plain);
        for (size_t i = 0; i < n; ++i)
            std::copy_n(&numbers.view()[components * i], components, &values[stride * i + before]);
    }

    int width_, height_;
    std::vector<SamplerFeature> features_;
    std::string axes_, name_;
    std::vector<std::unique_ptr<RendererProcess>> all_;
    std::atomic<size_t> next_ = 0;
};

struct ProcessSampler : SamplerShape {
    std::vector<std::string> command, features;
    int processes = 1;
    double timeout = 60;

    static void declare(Ports<ProcessSampler>& node) {
        node.about(
                "a program as a renderer to sample: a child process that reads questions and "
                "writes answers, arrays in .npz form")
            .out<SamplerFunction>("sampler", "radiance, and features where it has them")
            .param("command", &ProcessSampler::command,
                   {.about = "program and arguments: [\"python3\", \"renderer.py\"]",
                    .required = true})
            .param("features", &ProcessSampler::features,
                   {.about = "channels that it answers beside rgb, by their standard names: z, "
                             "motion, normal ..."})
            .param("processes", &ProcessSampler::processes,
                   {.min = 1, .max = 256, .about = "how many run at once"})
            .param("timeout", &ProcessSampler::timeout,
                   {.unit = "s", .min = 0.01, .max = 86400, .about = "for one question"});
        declare_shape(node);
    }

    void run(const Inputs&, Outputs& out, Context&) const {
        SamplerFunction made = sampler();
        made.features = standard_features(features);
        made.meta.set("source", "process-sampler");
        const auto renderers = std::make_shared<Renderers>(command, processes, timeout, made);
        made.evaluate = [renderers](const SamplerPoints& points, std::uint64_t hidden_seed,
                                    std::span<float> values) {
            renderers->evaluate(points, hidden_seed, values);
        };
        out.set("sampler", std::move(made));
    }
};

WEFT_NODE(ProcessSampler, "process-sampler", 1)

}  // namespace
}  // namespace weft
