// The values of a run: made once, read by many, freed after their last reader.
#pragma once
#include <atomic>
#include <deque>
#include <memory>
#include <vector>

#include "runtime/plan.h"
#include "runtime/registry.h"

namespace weft {

// What a node's document calls another node.
std::string name_seen_from(const std::string& node, const std::string& other);

class Values {
  public:
    explicit Values(const Plan& plan);

    bool wanted(Link link) const;                 // somebody reads or taps it
    void* make(Link link);                        // an empty one, to be filled
    void* get(Link link) const { return at(link).object.get(); }
    void release(Link link);                      // one reading task is done with it
    const TypeInfo& type(Link link) const;

    // Inputs of a node: its values; streams are left out (segments put batches there).
    Inputs inputs_of(int node) const;
    Inputs inputs_of(const StagePlan& stage) const;
    Outputs outputs_of(int node);                 // with everything wanted made

  private:
    struct Entry {
        std::shared_ptr<void> object;
        std::atomic<int> readers = 0;
        bool tapped = false;
    };
    const Entry& at(Link link) const { return entries_[size_t(link.node)][size_t(link.port)]; }
    Entry& at(Link link) { return entries_[size_t(link.node)][size_t(link.port)]; }

    const Plan& plan_;
    std::vector<std::deque<Entry>> entries_;
};

}  // namespace weft
