#include "adaptive/adaptive_steps.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "adaptive/request_points.h"

namespace weft::adaptive {
namespace {

constexpr const char* contrasts[] = {"relative", "absolute", "sqrt"};
constexpr const char* reaches[] = {"leaf", "neighbours"};

Json json_of(const AdaptiveSetup& setup, size_t taken) {
    Json json = Json::object(), axes = Json::list(), features = Json::list();
    for (const SamplerAxis& axis : setup.sampler.axes) {
        Json& one = axes.items.emplace_back(Json::object());
        one.set("name", axis.name);
        one.set("scale", double(axis.scale));
    }
    for (const SamplerFeature& feature : setup.sampler.features) {
        Json& one = features.items.emplace_back(Json::object());
        one.set("name", feature.name);
        one.set("components", feature.components);
    }
    const AdaptiveSettings& s = setup.settings;
    json.set("axes", std::move(axes));
    json.set("features", std::move(features));
    json.set("budget", s.budget);
    json.set("initial", s.initial);
    json.set("round", s.round);
    json.set("capacity", s.capacity);
    json.set("candidates", s.candidates);
    json.set("reach", reaches[int(s.reach)]);
    json.set("contrast", contrasts[int(s.contrast)]);
    json.set("scale", s.scale);
    json.set("seed", s.seed);
    json.set("taken", double(taken));
    return json;
}

// Members of a state's description; each Error says which.
class Description {
  public:
    explicit Description(const Samples& state) {
        const Json* found = state.meta.find("adaptive");
        if (!found || !found->is(Json::Kind::object))
            throw Error(
                "these samples are no state: their meta has no \"adaptive\"; link the state of "
                "adaptive-begin or adaptive-step");
        json_ = found;
    }
    const Json& member(std::string_view name, Json::Kind kind, const Json* of = nullptr) const {
        const Json* found = (of ? of : json_)->find(name);
        if (!found || !found->is(kind))
            throw Error(
                fmt::format("the state's \"adaptive\" has no {} '{}'; it was damaged after "
                            "adaptive-begin wrote it",
                            name_of(kind), name));
        return *found;
    }
    double number(std::string_view name, double least, double most) const {
        const double value = member(name, Json::Kind::number).number;
        if (!(value >= least && value <= most))
            throw Error(
                fmt::format("the state's '{}' is {}; expected {} to {}", name, value, least, most));
        return value;
    }
    // Which of `names` it is.
    size_t choice(std::string_view name, std::span<const char* const> names) const {
        const std::string& value = member(name, Json::Kind::text).text;
        const auto found = std::find(names.begin(), names.end(), value);
        if (found == names.end())
            throw Error(fmt::format("the state's '{}' is '{}'; expected one of {}", name, value,
                                    fmt::join(names, ", ")));
        return size_t(found - names.begin());
    }

  private:
    const Json* json_;
};

AdaptiveSetup setup_of(const Samples& state) {
    const Description of(state);
    AdaptiveSetup made;
    SamplerFunction& sampler = made.sampler;
    sampler.width = state.width, sampler.height = state.height;
    sampler.color_space = state.color_space;
    sampler.lens = state.lens;
    sampler.meta = state.meta;
    std::erase_if(sampler.meta.members, [](const JsonMember& m) { return m.key == "adaptive"; });
    for (const Json& axis : of.member("axes", Json::Kind::list).items)
        sampler.axes.push_back({of.member("name", Json::Kind::text, &axis).text,
                                float(of.member("scale", Json::Kind::number, &axis).number)});
    for (const Json& feature : of.member("features", Json::Kind::list).items)
        sampler.features.push_back(
            {of.member("name", Json::Kind::text, &feature).text,
             int(std::clamp(of.member("components", Json::Kind::number, &feature).number, 1.0,
                            1024.0))});
    AdaptiveSettings& s = made.settings;
    s.budget = of.number("budget", 0.01, 65536);
    s.initial = of.number("initial", 0, 65536);
    s.round = of.number("round", 0, 1);
    s.capacity = int(of.number("capacity", 2, 64));
    s.candidates = int(of.number("candidates", 1, 64));
    s.scale = of.number("scale", 0, 65536);
    const Json& seed = of.member("seed", Json::Kind::number);
    s.seed = std::uint64_t(seed.integer);
    s.reach = Reach(of.choice("reach", reaches));
    s.contrast = Contrast(of.choice("contrast", contrasts));
    return made;
}

}  // namespace

AdaptiveSteps::AdaptiveSteps(AdaptiveSetup setup) : setup_(std::move(setup)) {
    start();
}

AdaptiveSteps::AdaptiveSteps(const Samples& state) : setup_(setup_of(state)) {
    start();
    const auto taken = size_t(Description(state).number("taken", 0, double(state.size())));
    const Evaluated all = answers_of(state, setup_.sampler.features, 0, state.size());
    const size_t stride = setup_.sampler.values() - 3;
    while (run_->samples() < taken) {
        const size_t begin = run_->samples(), n = asked_.empty() ? 0 : asked_[0].size(),
                     end = begin + n;
        if (n == 0 || end > taken)
            throw Error(
                fmt::format("the state has taken {} samples, which is no end of a step; it was "
                            "damaged, or made by another version",
                            taken));
        Evaluated part;
        part.rgb.assign(all.rgb.begin() + std::ptrdiff_t(3 * begin),
                        all.rgb.begin() + std::ptrdiff_t(3 * end));
        part.features.assign(all.features.begin() + std::ptrdiff_t(stride * begin),
                             all.features.begin() + std::ptrdiff_t(stride * end));
        insert(part);
    }
}

void AdaptiveSteps::start() {
    points_.resize(setup_.sampler.dimensions());
    run_ = std::make_unique<AdaptiveRun>(setup_.sampler, setup_.settings);
    ask();
}

void AdaptiveSteps::ask() {
    asked_.clear();
    for (const auto& view : run_->request()) asked_.emplace_back(view.begin(), view.end());
}

void AdaptiveSteps::insert(const Evaluated& values) {
    for (size_t d = 0; d < asked_.size(); ++d)
        points_[d].insert(points_[d].end(), asked_[d].begin(), asked_[d].end());
    all_.rgb.insert(all_.rgb.end(), values.rgb.begin(), values.rgb.end());
    all_.features.insert(all_.features.end(), values.features.begin(), values.features.end());
    all_.broken += values.broken;
    run_->insert(values);
    ask();
}

void AdaptiveSteps::take(const Samples& results) {
    SamplerFunction& sampler = setup_.sampler;
    if (results.width != sampler.width || results.height != sampler.height)
        throw Error(fmt::format("the results are of {} x {} pixels, the requests of {} x {}",
                                results.width, results.height, sampler.width, sampler.height));
    if (run_->samples() == 0) {
        sampler.features = features_of(results);
        sampler.lens = results.lens;
        sampler.color_space = results.color_space;
        sampler.meta = results.meta;
    }
    const size_t n = asked_.empty() ? 0 : asked_[0].size();
    if (n == 0) return;
    Evaluated values = answers_of(results, sampler.features, std::uint32_t(run_->samples()), n);
    values.broken = blacken_broken(values.rgb);
    insert(values);
}

Samples AdaptiveSteps::state() const {
    std::vector<std::vector<float>> points = points_;
    for (size_t d = 0; d < asked_.size(); ++d)
        points[d].insert(points[d].end(), asked_[d].begin(), asked_[d].end());
    const std::vector<std::span<const float>> views(points.begin(), points.end());
    Evaluated all = all_;
    all.rgb.resize(3 * points[0].size());
    all.features.resize((setup_.sampler.values() - 3) * points[0].size());
    std::vector<std::uint32_t> order;
    Samples made = samples_of(setup_.sampler, views, all, {}, order);
    made.add_ids("request", std::move(order));
    made.meta.set("adaptive", json_of(setup_, run_->samples()));
    return made;
}

Samples AdaptiveSteps::requests() const {
    const std::vector<std::span<const float>> views(asked_.begin(), asked_.end());
    return request_points(setup_.sampler, views, std::uint32_t(run_->samples()));
}

size_t AdaptiveSteps::budget() const {
    return size_t(std::llround(setup_.settings.budget * double(setup_.sampler.pixels())));
}

}  // namespace weft::adaptive
