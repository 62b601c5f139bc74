#include "samples/check_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "graph/error.h"
#include "runtime/context.h"
#include "samples/drop_samples.h"

namespace weft {
namespace {

enum class Fault { radiance, negative, depth, lens, light, time, place, finite, nan };

// Whether samples with this fault are dropped, and whether they count against `tolerate`.
bool drops(Fault f) {
    return f != Fault::negative && f != Fault::nan;
}
bool counts(Fault f) {
    return drops(f) && f != Fault::radiance;
}

std::string_view words(Fault f) {
    switch (f) {
        case Fault::radiance:
            return "radiance is NaN or infinite";
        case Fault::negative:
            return "radiance is negative";
        case Fault::depth:
            return "depth is NaN or not above 0";
        case Fault::lens:
            return "lens position lies outside the unit disk";
        case Fault::light:
            return "position on the light lies outside [-1, 1]";
        case Fault::time:
            return "time lies outside [0, 1]";
        case Fault::place:
            return "position lies more than a pixel outside its pixel";
        case Fault::finite:
            return "value is NaN or infinite";
        case Fault::nan:
            break;
    }
    return "value is NaN";
}

struct Check {
    const Channel* channel;
    Fault fault;
};

bool is_finite(float v) {
    return (std::bit_cast<std::uint32_t>(v) & 0x7f800000u) != 0x7f800000u;
}

constexpr float slack = 1e-3f;

// One sample's values against one fault; written so that NaN is a fault too.
bool is_bad(Fault fault, const float* v) {
    switch (fault) {
        case Fault::depth:
            return !(*v > 0);
        case Fault::time:
            return !(*v >= 0 && *v <= 1);
        case Fault::lens:
            return !(v[0] * v[0] + v[1] * v[1] <= (1 + slack) * (1 + slack));
        case Fault::light:
            return !(std::abs(v[0]) <= 1 + slack && std::abs(v[1]) <= 1 + slack);
        case Fault::negative:
            return *v < 0;
        case Fault::nan:
            return *v != *v;
        case Fault::radiance:
        case Fault::finite:
            return !is_finite(*v);
        case Fault::place:
            break;
    }
    return false;
}

// Faults of a pair of values; the others are looked for in each component.
bool is_of_pair(Fault f) {
    return f == Fault::lens || f == Fault::light;
}

bool is_misplaced(const float* xy, float x, float y) {
    return !(xy[0] >= x - 1 && xy[0] <= x + 2 && xy[1] >= y - 1 && xy[1] <= y + 2);
}

struct Finding {
    size_t count = 0, first = 0;
};

struct Findings {
    std::vector<Finding> of_check;
    std::vector<size_t> dropped;  // ascending
    size_t counted = 0;           // samples with a fault that counts
};

Findings joined(Findings a, const Findings& b) {
    if (b.of_check.empty()) return a;
    a.of_check.resize(b.of_check.size());
    for (size_t i = 0; i < b.of_check.size(); ++i) {
        if (a.of_check[i].count == 0) a.of_check[i].first = b.of_check[i].first;
        a.of_check[i].count += b.of_check[i].count;
    }
    a.dropped.insert(a.dropped.end(), b.dropped.begin(), b.dropped.end());
    a.counted += b.counted;
    return a;
}

class Checker {
  public:
    Checker(const Samples& samples) : samples_(samples) {
        for (const Channel& c : samples.channels)
            if (!c.whole()) add_checks(c);
    }

    const std::vector<Check>& checks() const { return checks_; }

    // A piece is looked at in blocks that stay in the cache; only a block in which something is
    // wrong is gone through sample by sample.
    Findings look(size_t begin, size_t end) const {
        Findings found;
        constexpr size_t block = 2048;
        for (size_t at = begin; at < end; at += block) {
            const size_t stop = std::min(end, at + block);
            bool clean = true;
            for (const Check& check : checks_) clean &= is_clean(check, at, stop);
            if (!clean) list(at, stop, found);
        }
        return found;
    }

  private:
    void add_checks(const Channel& c) {
        const bool light = samples_.domain == "light";
        if (c.name == "xy") {
            checks_.push_back({&c, light ? Fault::finite : Fault::place});
        } else if (c.name == "uv") {
            checks_.push_back({&c, light ? Fault::light : Fault::lens});
        } else if (c.name == "t") {
            checks_.push_back({&c, Fault::time});
        } else if (c.name == "z") {
            checks_.push_back({&c, Fault::depth});
        } else if (c.name == "motion" || c.name == "alpha" || c.name == "weight") {
            checks_.push_back({&c, Fault::finite});
        } else if (c.role == Role::radiance) {
            checks_.push_back({&c, Fault::radiance});
            checks_.push_back({&c, Fault::negative});
        } else {
            checks_.push_back({&c, Fault::nan});
        }
    }

    template <Fault fault>
    static bool any(const float* v, size_t count, size_t stride) {
        unsigned bad = 0;
        for (size_t i = 0; i < count; ++i) bad |= unsigned(is_bad(fault, v + i * stride));
        return bad != 0;
    }

    bool is_clean(const Check& check, size_t begin, size_t end) const {
        const auto components = size_t(check.channel->components);
        const float* v = check.channel->values.view().data() + begin * components;
        const size_t values = (end - begin) * components;
        switch (check.fault) {
            case Fault::radiance:
            case Fault::finite:
                return !any<Fault::finite>(v, values, 1);
            case Fault::negative:
                return !any<Fault::negative>(v, values, 1);
            case Fault::nan:
                return !any<Fault::nan>(v, values, 1);
            case Fault::depth:
                return !any<Fault::depth>(v, values, 1);
            case Fault::time:
                return !any<Fault::time>(v, values, 1);
            case Fault::lens:
                return !any<Fault::lens>(v, end - begin, 2);
            case Fault::light:
                return !any<Fault::light>(v, end - begin, 2);
            case Fault::place:
                break;
        }
        bool bad = false;
        for_each_pixel(begin, end, [&](size_t from, size_t to, float x, float y) {
            for (size_t i = from; i < to; ++i)
                bad |= is_misplaced(check.channel->values.view().data() + 2 * i, x, y);
        });
        return !bad;
    }

    // visit(begin, end, x, y) for the samples of every pixel that has some in [begin, end).
    template <class Visit>
    void for_each_pixel(size_t begin, size_t end, Visit&& visit) const {
        size_t pixel = pixel_of(samples_, begin);
        auto x = pixel % size_t(samples_.width), y = pixel / size_t(samples_.width);
        while (begin < end) {
            const size_t stop = std::min(end, samples_.of_pixel(pixel).end);
            visit(begin, stop, float(x), float(y));
            begin = stop;
            ++pixel;
            if (++x == size_t(samples_.width)) x = 0, ++y;
        }
    }

    void list(size_t begin, size_t end, Findings& found) const {
        found.of_check.resize(checks_.size());
        const auto visit = [&](size_t from, size_t to, float x, float y) {
            for (size_t i = from; i < to; ++i) list_one(i, x, y, found);
        };
        if (samples_.domain == "light")
            visit(begin, end, 0, 0);
        else
            for_each_pixel(begin, end, visit);
    }

    void list_one(size_t sample, float x, float y, Findings& found) const {
        bool drop = false, count = false;
        for (size_t k = 0; k < checks_.size(); ++k) {
            const Check& check = checks_[k];
            const auto components = size_t(check.channel->components);
            const float* v = check.channel->values.view().data() + sample * components;
            bool bad = false;
            if (check.fault == Fault::place)
                bad = is_misplaced(v, x, y);
            else if (is_of_pair(check.fault))
                bad = is_bad(check.fault, v);
            else
                for (size_t c = 0; c < components; ++c) bad |= is_bad(check.fault, v + c);
            if (!bad) continue;
            Finding& finding = found.of_check[k];
            if (finding.count++ == 0) finding.first = sample;
            drop |= drops(check.fault);
            count |= counts(check.fault);
        }
        if (drop) found.dropped.push_back(sample);
        found.counted += count;
    }

    const Samples& samples_;
    std::vector<Check> checks_;
};

std::string values_text(const Channel& channel, size_t sample) {
    const auto components = size_t(channel.components);
    const auto values = channel.values.view().subspan(sample * components, components);
    return components == 1 ? fmt::format("{}", values[0])
                           : fmt::format("({})", fmt::join(values, ", "));
}

// "z: depth is NaN or not above 0 in 3 samples; first: pixel (1, 2), sample 0, z = -1"
std::string describe(const Samples& samples, const Check& check, const Finding& finding) {
    return fmt::format("{}: {} in {} sample{}; first: {}, {} = {}", check.channel->name,
                       words(check.fault), finding.count, finding.count == 1 ? "" : "s",
                       place_of(samples, finding.first), check.channel->name,
                       values_text(*check.channel, finding.first));
}

}  // namespace

std::string place_of(const Samples& samples, size_t sample) {
    if (samples.domain == "light") return fmt::format("sample {}", sample);
    const size_t pixel = pixel_of(samples, sample);
    return fmt::format("pixel ({}, {}), sample {}", pixel % size_t(samples.width),
                       pixel / size_t(samples.width), sample - samples.of_pixel(pixel).begin);
}

void check_samples(Samples& samples, const std::string& file, double tolerate, Context& ctx) {
    const Checker checker(samples);
    const Findings found = ctx.reduce<Findings>(
        samples.size(), size_t{1} << 16, {},
        [&](size_t begin, size_t end) { return checker.look(begin, end); },
        [](Findings a, const Findings& b) { return joined(std::move(a), b); });
    if (found.of_check.empty()) return;

    const double part = double(found.counted) / double(samples.size());
    if (part > tolerate) {
        std::string reasons;
        for (size_t k = 0; k < found.of_check.size(); ++k)
            if (found.of_check[k].count && counts(checker.checks()[k].fault))
                reasons += (reasons.empty() ? "" : ". ") +
                           describe(samples, checker.checks()[k], found.of_check[k]);
        throw Error(
            fmt::format("{}: {} of {} samples ({:.3g} %) cannot be used, more than the "
                        "{:.3g} % tolerated. {}. Render again, or set 'tolerate' of "
                        "read-samples higher",
                        file, found.counted, samples.size(), 100 * part, 100 * tolerate, reasons));
    }
    if (found.dropped.size() == samples.size())
        throw Error(
            fmt::format("{}: no sample can be used: every one has a value that is NaN, "
                        "infinite or out of range",
                        file));
    for (size_t k = 0; k < found.of_check.size(); ++k)
        if (found.of_check[k].count)
            ctx.warn(fmt::format("{}: {} ({})", file,
                                 describe(samples, checker.checks()[k], found.of_check[k]),
                                 drops(checker.checks()[k].fault) ? "dropped" : "kept"));
    if (!found.dropped.empty()) drop_samples(samples, found.dropped);
}

}  // namespace weft
