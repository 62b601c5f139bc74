// pick-light: of several lights each location asks one, as often as its part of their power; what it
// finds counts as many times more. A row of nodes for each light then costs that of one.
// Source: Shirley, Wang and Zimmerman 1996 (one light a sample, by estimated power).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "light-field/location_number.h"
#include "light-field/streams.h"
#include "runtime/node.h"
#include "shadows/fit_light_view_kernel.h"
#include "shadows/streams.h"

namespace weft {
namespace {

struct PickLight {
    std::string light;
    std::vector<std::string> lights;
    std::uint64_t seed = 1;

    static void declare(Ports<PickLight>& node) {
        node.about(
                "leaves each location one of several lights to ask, by their power: what they see is "
                "not there for the others")
            .in<SeenSamples>("seen", "the sample that each location sees")
            .in<Locations>("locations", "the same")
            .in<Samples>("samples", "the camera's, whose meta.lights tells the lights' power")
            .out<SeenSamples>("seen", "of locations that ask this light; none for all others")
            .param("light", &PickLight::light, {.about = "this one"})
            .param("lights", &PickLight::lights,
                   {.about = "all of them, by name; empty: each location asks this light"})
            .param("seed", &PickLight::seed, {.about = "of the choice"});
    }

    // Which numbers in [0, 1) ask this light.
    struct Scratch {
        const Samples* of = nullptr;
        double begin = 0, end = 1;
    };
    void batch(const Inputs& in, Outputs& out, Scratch& s) const {
        const SeenSamples& seen = in.get<SeenSamples>("seen");
        const Locations& at = in.get<Locations>("locations");
        SeenSamples& own = out.get<SeenSamples>("seen");
        if (const Samples& samples = in.get<Samples>("samples"); s.of != &samples) {
            share_out(samples, s);
            s.of = &samples;
        }
        own.chance = float(s.end - s.begin);
        own.sample.resize(at.size());
        for (size_t l = 0; l < at.size(); ++l) {
            const double number = choice(at, l);
            const bool ours = number >= s.begin && number < s.end;
            own.sample[l] = ours ? seen.sample[l] : SeenSamples::none;
        }
    }

  private:
    void share_out(const Samples& samples, Scratch& s) const {
        s.begin = 0, s.end = 1;
        if (lights.empty()) return;
        const auto found = std::find(lights.begin(), lights.end(), light);
        if (found == lights.end())
            throw Error(
                fmt::format("light '{}' is not one of 'lights'; expected its name among them", light));
        double before = 0, all = 0, own = 0;
        for (auto one = lights.begin(); one != lights.end(); ++one) {
            const double power = shadows::light_power(samples, *one);
            if (one < found) before += power;
            if (one == found) own = power;
            all += power;
        }
        if (!(own > 0)) throw Error(fmt::format("light '{}' has no power", light));
        s.begin = before / all;
        s.end = found + 1 == lights.end() ? 1 : (before + own) / all;
    }
    // Evenly spread over the locations of a pixel: multiples of the golden ratio, from a start of the
    // pixel's own.
    double choice(const Locations& at, size_t l) const {
        if (!at.shared)
            return double(light_field::location_number(at.x[l], at.y[l], at.u_of(l), at.t_of(l),
                                                       mix(seed + 2)));
        constexpr double golden = 0.6180339887498949;
        const double number =
            double(unit_float(mix(mix(seed + 2) ^ at.pixels[l]))) + golden * double(at.number);
        return number - std::floor(number);
    }
};

WEFT_NODE(PickLight, "pick-light", 1)

}  // namespace
}  // namespace weft
