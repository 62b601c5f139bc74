// compare, show: what files hold, and how far one is from another.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "cli/commands.h"
#include "cli/terminal.h"
#include "image/measures.h"
#include "image/picture_file.h"
#include "runtime/executor.h"
#include "runtime/plan.h"
#include "samples/file_bytes.h"
#include "samples/sample_file.h"

namespace weft::cli {
namespace {

// Loops on all cores; warnings to the terminal.
class CommandContext final : public Context {
  public:
    void warn(const std::string& message) override { complain("warning: " + message); }
    bool cancelled() const override { return interruption(); }
    void parallel(size_t count, size_t grain, const std::function<void(size_t, size_t)>& work) override {
        executor_->parallel(count, std::max<size_t>(grain, 1), [&](size_t begin, size_t end) {
            check_cancelled();
            work(begin, end);
        });
    }
    void progress(double, double, std::string_view) override {}
    const Provenance& provenance() const override { return none_; }

  private:
    std::unique_ptr<Executor> executor_ = make_tbb_executor(0);
    Provenance none_;
};

struct Range {
    double low = INFINITY, high = -INFINITY;
    size_t infinite = 0;
};

Range range_of(const Channel& channel) {
    Range range;
    for (float value : channel.values.view()) {
        if (!std::isfinite(value)) {
            ++range.infinite;
            continue;
        }
        range.low = std::min(range.low, double(value));
        range.high = std::max(range.high, double(value));
    }
    for (std::uint32_t id : channel.ids.view()) {
        range.low = std::min(range.low, double(id));
        range.high = std::max(range.high, double(id));
    }
    return range;
}

std::string spp_text(const Samples& samples) {
    return samples.spp > 0 ? fmt::format("{}", samples.spp) : fmt::format("{:.3g} on average, varying", samples.mean_spp());
}

std::string samples_text(const Samples& samples, const std::string& file, SampleFormat format) {
    std::string text = fmt::format("{}: samples, {}\n  size          {} x {} pixels, {} a pixel, {} samples\n", file, name_of(format),
                                   samples.width, samples.height, spp_text(samples), samples.size());
    text += fmt::format("  colour space  {}\n  domain        {}\n", samples.color_space, samples.domain);
    if (samples.lens) text += fmt::format("  lens          circle of confusion {:g} / z + {:g} pixels\n", samples.lens->c0, samples.lens->c1);
    else text += "  lens          none (pinhole)\n";
    if (const Json* source = samples.meta.find("source"); source && source->is(Json::Kind::text)) text += "  source        " + source->text + "\n";
    text += "  channels\n";
    for (const Channel& channel : samples.channels) {
        const Range range = range_of(channel);
        text += fmt::format("    {:<18} x {}  {:<9} {:.6g} to {:.6g}{}\n", channel.name, channel.components, name_of(channel.role), range.low,
                            range.high, range.infinite ? fmt::format(", {} not finite", range.infinite) : "");
    }
    return text;
}

Json samples_json(const Samples& samples, const std::string& file, SampleFormat format) {
    Json one = Json::object();
    one.set("file", file);
    one.set("format", std::string(name_of(format)));
    one.set("samples", std::uint64_t(samples.size()));
    one.set("mean_spp", samples.mean_spp());
    one.set("meta", samples.meta_object());
    Json& channels = one.set("channels", Json::list());
    for (const Channel& channel : samples.channels) {
        const Range range = range_of(channel);
        Json c = Json::object();
        c.set("name", channel.name);
        c.set("components", channel.components);
        c.set("role", std::string(name_of(channel.role)));
        if (range.low <= range.high) {
            c.set("minimum", range.low);
            c.set("maximum", range.high);
        }
        c.set("not_finite", std::uint64_t(range.infinite));
        channels.items.push_back(std::move(c));
    }
    return one;
}

}  // namespace

int compare(const std::string& picture, const std::string& reference, const std::string& error_picture, bool json) {
    catch_interruptions();
    CommandContext ctx;
    const Comparison comparison = compare_files(picture, reference, ctx);
    Table table = measures_table();
    add_row(table, picture, comparison.measures);
    print(json ? table.json().dump(true) + "\n" : table.text());
    if (!error_picture.empty()) {
        std::vector<std::string> warnings;
        write_picture(error_picture, comparison.error, {}, warnings);
        for (const std::string& warning : warnings) ctx.warn(warning);
    }
    return done;
}

int show(const std::string& file, bool json) {
    catch_interruptions();
    if (!std::filesystem::exists(file)) throw Error(fmt::format("{}: there is no such file", file));
    const FileBytes bytes = map_file(file);
    if (const std::optional<SampleFormat> format = format_of(bytes)) {
        CommandContext ctx;
        ReadOptions options;
        options.channels = {"*"};
        options.tolerate = 1;
        const Samples samples = read_sample_file(bytes, options, ctx);
        print(json ? samples_json(samples, file, *format).dump(true) + "\n" : samples_text(samples, file, *format));
        return done;
    }
    const PictureInfo info = picture_info(file);
    print(json ? to_json(info, file).dump(true) + "\n" : to_text(info, file));
    return done;
}

}  // namespace weft::cli
