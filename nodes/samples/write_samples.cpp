// write-samples: a sample buffer to a file.
#include "runtime/node.h"
#include "samples/sample_file.h"
#include "samples/samples.h"

namespace weft {
namespace {

struct WriteSamples {
    enum class Format { by_name, npz, deep_exr, tlfr, ilfr };
    enum class Packing { none, deflate };
    enum class Encoding { binary, text };

    OutputFile file{"out/samples.npz"};
    Format format = Format::by_name;
    Packing compression = Packing::none;
    Encoding encoding = Encoding::binary;

    static void declare(Ports<WriteSamples>& node) {
        node.about(
                "writes a sample buffer, whole or not at all. What the format cannot hold is named "
                "in a warning; .npz holds everything")
            .writes()
            .in<Samples>("samples", "the buffer to write")
            .param("file", &WriteSamples::file, {.about = "file to write; folders are made"})
            .choice("format", &WriteSamples::format, {"auto", "npz", "exr", "tlfr", "ilfr"},
                    {.about = "auto: by the file's extension; exr is deep EXR"})
            .choice("compression", &WriteSamples::compression, {"none", "deflate"},
                    {.about = "npz and exr: noisy floats hardly shrink, and only files written "
                              "with none are read without a copy"})
            .choice(
                "encoding", &WriteSamples::encoding, {"binary", "text"},
                {.about =
                     "tlfr and ilfr: numbers as raw floats, or as text with 9 digits (exact too)"});
    }

    void run(const Inputs& in, Outputs&, Context& ctx) const {
        WriteOptions options;
        if (format != Format::by_name) options.format = SampleFormat(int(format) - 1);
        options.deflate = compression == Packing::deflate;
        options.text = encoding == Encoding::text;
        write_sample_file(in.get<Samples>("samples"), file.path, options, ctx);
    }
};

WEFT_NODE(WriteSamples, "write-samples", 1)

}  // namespace
}  // namespace weft
