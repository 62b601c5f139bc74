#include "color/color_config.h"

#include <OpenColorIO/OpenColorIO.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>
#include <sstream>

#include "color/shipped_config.h"
#include "graph/diagnostic.h"
#include "graph/error.h"

namespace OCIO = OCIO_NAMESPACE;

namespace weft {

struct ColorTransform::Steps {
    std::vector<OCIO::ConstCPUProcessorRcPtr> processors;  // one; two where configs were joined
};

struct ColorConfig::Impl {
    OCIO::ConstConfigRcPtr config;
};

namespace {

// The same thing under the names that configs in use give it. A graph may say any of them.
const std::vector<std::vector<std::string>> same_display = {
    {"sRGB", "sRGB - Display"},
    {"Rec.709", "Rec.1886 Rec.709 - Display", "Rec.1886"},
    {"Display P3", "Display P3 - Display", "P3-D65 - Display"},
    {"Rec.2100-PQ", "Rec.2100-PQ - Display", "Rec.2020 ST2084"}};
const std::vector<std::vector<std::string>> same_view = {
    {"ACES 1.0 SDR", "ACES 1.0 - SDR Video"},
    {"ACES 1.1 SDR (P3 lim)", "ACES 1.1 - SDR Video (P3 lim)"},
    {"ACES 1.1 HDR (1000 nits)", "ACES 1.1 - HDR Video (1000 nits & Rec.2020 lim)",
     "ACES 1.1 - HDR Video (1000 nits)"},
    {"Un-tone-mapped", "Un-tone-mapped (sRGB)"},
    {"Raw", "raw"}};

// `wanted` as it stands in `known`, or one of the other names it goes by; "" if none is known.
std::string known_as(const std::string& wanted, const std::vector<std::string>& known,
                     const std::vector<std::vector<std::string>>& same) {
    const auto has = [&](const std::string& name) {
        return std::find(known.begin(), known.end(), name) != known.end();
    };
    if (has(wanted)) return wanted;
    for (const auto& names : same)
        if (std::find(names.begin(), names.end(), wanted) != names.end())
            for (const std::string& name : names)
                if (has(name)) return name;
    return {};
}

std::string known_names(const std::string& wrong, const std::vector<std::string>& known) {
    const std::string near = nearest_name(wrong, known);
    std::string text = near.empty() ? "" : fmt::format("; did you mean '{}'?", near);
    return text + fmt::format(" (it has {})", fmt::join(known, ", "));
}

// Work on OpenColorIO, with its errors told as ours.
template <class Work>
auto guarded(const std::string& config, Work&& work) {
    try {
        return work();
    } catch (const OCIO::Exception& e) {
        throw Error(fmt::format("OpenColorIO config '{}': {}", config, e.what()));
    }
}

OCIO::ConstCPUProcessorRcPtr processor(const OCIO::ConstConfigRcPtr& config,
                                       const OCIO::ConstTransformRcPtr& transform) {
    return config->getProcessor(transform)->getDefaultCPUProcessor();
}

OCIO::ConstTransformRcPtr between(const char* from, const char* to) {
    OCIO::ColorSpaceTransformRcPtr transform = OCIO::ColorSpaceTransform::Create();
    transform->setSrc(from);
    transform->setDst(to);
    return transform;
}

constexpr const char* interchange = "aces_interchange";

// Where a space was found, by the name it has there.
struct Found {
    bool shipped = false;  // in Weft's config only, to be joined
    std::string name;
};

Found find_space(const ColorConfig& self, const OCIO::ConstConfigRcPtr& config,
                 const OCIO::ConstConfigRcPtr& shipped, const std::string& space) {
    if (const auto found = config->getColorSpace(space.c_str())) return {false, found->getName()};
    const auto ours = config == shipped ? nullptr : shipped->getColorSpace(space.c_str());
    if (ours && config->getColorSpace(interchange)) return {true, ours->getName()};
    std::string message =
        fmt::format("OpenColorIO config '{}' has no colour space '{}'", self.name(), space);
    if (ours)
        message += fmt::format(", nor a role '{}' that would join it to Weft's own", interchange);
    throw Error(message + known_names(space, self.color_spaces()));
}

}  // namespace

void ColorTransform::apply(float* rgb, size_t pixels) const {
    if (!steps_ || pixels == 0) return;
    OCIO::PackedImageDesc image(rgb, long(pixels), 1, 3);
    for (const auto& step : steps_->processors) step->apply(image);
}

bool ColorTransform::is_identity() const {
    return !steps_ || std::all_of(steps_->processors.begin(), steps_->processors.end(),
                                  [](const auto& step) { return step->isNoOp(); });
}

ColorConfig::ColorConfig(std::shared_ptr<const Impl> impl, std::string name)
    : impl_(std::move(impl)), name_(std::move(name)) {}

std::shared_ptr<const ColorConfig> ColorConfig::shipped() {
    static const std::shared_ptr<const ColorConfig> config = [] {
        OCIO::SetLoggingLevel(OCIO::LOGGING_LEVEL_NONE);  // what matters comes as an exception
        std::istringstream text{std::string(shipped_config_text())};
        auto parsed = OCIO::Config::CreateFromStream(text);
        return std::make_shared<const ColorConfig>(std::make_shared<const Impl>(Impl{parsed}),
                                                   parsed->getName());
    }();
    return config;
}

std::vector<std::string> ColorConfig::further_files(const std::string& path) {
    const char* variable = std::getenv("OCIO");
    if (path.empty() && variable && *variable) return {variable};
    return {};
}

std::shared_ptr<const ColorConfig> ColorConfig::open(const std::string& path) {
    std::string file = path;
    const char* variable = std::getenv("OCIO");
    if (file.empty() && variable) file = variable;
    if (file.empty()) return shipped();
    OCIO::SetLoggingLevel(OCIO::LOGGING_LEVEL_NONE);
    const std::string origin = path.empty() ? "$OCIO names " : "";
    std::error_code missing;
    const auto changed = std::filesystem::last_write_time(file, missing);
    if (missing || !std::filesystem::is_regular_file(file, missing))
        throw Error(
            fmt::format("{}'{}', which is no file; expected an OpenColorIO config", origin, file));

    static std::mutex lock;
    static std::map<std::pair<std::string, std::filesystem::file_time_type>,
                    std::shared_ptr<const ColorConfig>>
        kept;
    const std::lock_guard guard(lock);
    auto& config = kept[{file, changed}];
    if (!config)
        config = guarded(file, [&] {
            auto parsed = OCIO::Config::CreateFromFile(file.c_str());
            parsed->validate();
            return std::make_shared<const ColorConfig>(std::make_shared<const Impl>(Impl{parsed}),
                                                       file);
        });
    return config;
}

std::string ColorConfig::label() const {
    const std::string own = impl_->config->getName();
    return own.empty() ? std::filesystem::path(name_).filename().string() : own;
}

std::vector<std::string> ColorConfig::color_spaces() const {
    std::vector<std::string> names;
    const int count =
        impl_->config->getNumColorSpaces(OCIO::SEARCH_REFERENCE_SPACE_ALL, OCIO::COLORSPACE_ACTIVE);
    for (int i = 0; i < count; ++i)
        names.emplace_back(impl_->config->getColorSpaceNameByIndex(OCIO::SEARCH_REFERENCE_SPACE_ALL,
                                                                   OCIO::COLORSPACE_ACTIVE, i));
    return names;
}

std::vector<std::string> ColorConfig::displays() const {
    std::vector<std::string> names;
    for (int i = 0; i < impl_->config->getNumDisplays(); ++i)
        names.emplace_back(impl_->config->getDisplay(i));
    return names;
}

std::vector<std::string> ColorConfig::views(const std::string& display) const {
    std::vector<std::string> names;
    for (int i = 0; i < impl_->config->getNumViews(display.c_str()); ++i)
        names.emplace_back(impl_->config->getView(display.c_str(), i));
    return names;
}

ColorTransform ColorConfig::convert(const std::string& from, const std::string& to) const {
    return guarded(name_, [&] {
        const auto& config = impl_->config;
        const auto& ours = shipped()->impl_->config;
        const Found source = find_space(*this, config, ours, from),
                    target = find_space(*this, config, ours, to);
        auto steps = std::make_shared<ColorTransform::Steps>();
        if (source.shipped == target.shipped) {
            steps->processors = {processor(source.shipped ? ours : config,
                                           between(source.name.c_str(), target.name.c_str()))};
        } else {
            const auto& first = source.shipped ? ours : config;
            const auto& second = target.shipped ? ours : config;
            steps->processors = {processor(first, between(source.name.c_str(), interchange)),
                                 processor(second, between(interchange, target.name.c_str()))};
        }
        ColorTransform result;
        result.steps_ = std::move(steps);
        result.color_space = target.name;
        return result;
    });
}

ColorTransform ColorConfig::display(const std::string& from, const std::string& wanted_display,
                                    const std::string& wanted_view,
                                    const std::string& looks) const {
    return guarded(name_, [&] {
        const auto& config = impl_->config;
        const auto& ours = shipped()->impl_->config;
        const Found source = find_space(*this, config, ours, from);

        const std::string asked =
            wanted_display.empty() ? config->getDefaultDisplay() : wanted_display;
        const std::string screen = known_as(asked, displays(), same_display);
        if (screen.empty())
            throw Error(fmt::format("OpenColorIO config '{}' has no display '{}'{}", name_, asked,
                                    known_names(asked, displays())));
        const std::vector<std::string> there = views(screen);
        const std::string look_at =
            wanted_view.empty() ? config->getDefaultView(screen.c_str()) : wanted_view;
        const std::string shown = known_as(look_at, there, same_view);
        if (shown.empty())
            throw Error(fmt::format("OpenColorIO config '{}' has no view '{}' for display '{}'{}",
                                    name_, look_at, screen, known_names(look_at, there)));

        OCIO::DisplayViewTransformRcPtr transform = OCIO::DisplayViewTransform::Create();
        transform->setSrc(source.shipped ? interchange : source.name.c_str());
        transform->setDisplay(screen.c_str());
        transform->setView(shown.c_str());
        auto steps = std::make_shared<ColorTransform::Steps>();
        if (source.shipped)
            steps->processors.push_back(processor(ours, between(source.name.c_str(), interchange)));
        if (looks.empty()) {
            steps->processors.push_back(processor(config, transform));
        } else {
            OCIO::LegacyViewingPipelineRcPtr pipeline = OCIO::LegacyViewingPipeline::Create();
            pipeline->setDisplayViewTransform(transform);
            pipeline->setLooksOverride(looks.c_str());
            pipeline->setLooksOverrideEnabled(true);
            steps->processors.push_back(pipeline->getProcessor(config, config->getCurrentContext())
                                            ->getDefaultCPUProcessor());
        }
        ColorTransform result;
        result.steps_ = std::move(steps);
        result.display = screen;
        result.view = shown;
        result.color_space = config->getDisplayViewColorSpaceName(screen.c_str(), shown.c_str());
        if (result.color_space.empty() || result.color_space == "<USE_DISPLAY_NAME>")
            result.color_space = screen;
        return result;
    });
}

ColorTransform ColorConfig::look(const std::string& from, const std::string& looks,
                                 bool inverse) const {
    return guarded(name_, [&] {
        const auto& config = impl_->config;
        const auto& ours = shipped()->impl_->config;
        const Found source = find_space(*this, config, ours, from);
        std::vector<std::string> known;
        for (int i = 0; i < config->getNumLooks(); ++i)
            known.emplace_back(config->getLookNameByIndex(i));
        // "a, -b | c": each name once, without its sign.
        std::string name;
        for (const char letter : looks + ",") {
            if (letter != ',' && letter != ':' && letter != '|') {
                name += letter;
                continue;
            }
            const size_t begin = name.find_first_not_of(" +-");
            name = begin == std::string::npos
                       ? ""
                       : name.substr(begin, name.find_last_not_of(' ') + 1 - begin);
            if (!name.empty() && std::find(known.begin(), known.end(), name) == known.end())
                throw Error(
                    fmt::format("OpenColorIO config '{}' has no look '{}'{}", name_, name,
                                known.empty() ? " (it has none)" : known_names(name, known)));
            name.clear();
        }
        const char* space = source.shipped ? interchange : source.name.c_str();
        OCIO::LookTransformRcPtr transform = OCIO::LookTransform::Create();
        transform->setSrc(space);
        transform->setDst(space);
        transform->setLooks(looks.c_str());
        transform->setDirection(inverse ? OCIO::TRANSFORM_DIR_INVERSE
                                        : OCIO::TRANSFORM_DIR_FORWARD);
        auto steps = std::make_shared<ColorTransform::Steps>();
        if (source.shipped)
            steps->processors.push_back(processor(ours, between(source.name.c_str(), interchange)));
        steps->processors.push_back(processor(config, transform));
        if (source.shipped)
            steps->processors.push_back(processor(ours, between(interchange, source.name.c_str())));
        ColorTransform result;
        result.steps_ = std::move(steps);
        result.color_space = from;
        return result;
    });
}

}  // namespace weft
