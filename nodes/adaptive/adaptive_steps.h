// Adaptive sampling by steps, for renderers that no node can call: between two steps somebody
// renders the requests. The state is a sample buffer: what was sampled so far and, black, what is
// asked for now, with `request`; under "adaptive" in its meta the settings. The boxes are made
// again from it: they are a function of these, and cost less than any sample.
#pragma once
#include <memory>

#include "adaptive/adaptive_run.h"

namespace weft::adaptive {

// Settings, and the sampler as far as results tell of it, without `evaluate`.
struct AdaptiveSetup {
    SamplerFunction sampler;
    AdaptiveSettings settings;
};

class AdaptiveSteps {
  public:
    explicit AdaptiveSteps(AdaptiveSetup setup);
    // From a state. Throws Error where the buffer is none.
    explicit AdaptiveSteps(const Samples& state);
    AdaptiveSteps(const AdaptiveSteps&) = delete;
    AdaptiveSteps& operator=(const AdaptiveSteps&) = delete;

    // Takes the results of what is asked for now.
    void take(const Samples& results);

    Samples state() const;
    Samples requests() const;
    const AdaptiveRun& run() const { return *run_; }
    size_t budget() const;

  private:
    void start();
    void ask();  // for the next round
    void insert(const Evaluated& values);

    AdaptiveSetup setup_;
    std::unique_ptr<AdaptiveRun> run_;
    std::vector<std::vector<float>> asked_;  // axes x what is asked for now
    Evaluated all_;                          // taken so far, in order of requests
    std::vector<std::vector<float>> points_;
};

}  // namespace weft::adaptive
