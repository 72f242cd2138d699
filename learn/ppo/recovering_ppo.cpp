#include "learn/ppo/recovering_ppo.h"

#include <utility>

namespace skybody::learn {

RecoveringPpo::RecoveringPpo(std::shared_ptr<const PpoSetup> setup,
                             std::unique_ptr<SliceHolder> slices, int threads,
                             std::function<void()> replace)
    : ppo_(std::move(setup), std::move(slices), threads),
      replace_(std::move(replace)),
      kept_(ppo_.state()) {}

Report RecoveringPpo::iterate() {
  bool is_lost = false;
  for (int tries = 1;; ++tries) {
    try {
      if (is_lost) {
        replace_();
        ppo_.restore(kept_);
        is_lost = false;
      }
      return iterate_and_keep();
    } catch (const SlicesLost&) {
      if (tries == kMostTries) throw;
      is_lost = true;
    }
  }
}

Report RecoveringPpo::iterate_and_keep() {
  Report report = ppo_.iterate();
  kept_ = ppo_.state();
  return report;
}

void RecoveringPpo::restore(const LearnerState& state) {
  ppo_.restore(state);
  kept_ = state;
}

}  // namespace skybody::learn
