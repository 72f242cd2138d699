// One group of environments, stepped like by a worker of Pool.
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "core/assemble/compile_scenario.h"
#include "core/base/simd/lane_mask.h"
#include "core/env/compiled_scenario.h"
#include "core/env/group_workspace.h"

namespace skybody::bench {

/// Several environments in lanes, reset, with their own rows.
class Group {
 public:
  /// @param lanes  0: the best number for the scenario
  Group(const std::string& scenario, const std::vector<std::string>& overrides, int lanes = 0)
      : compiled_(compile_scenario({scenario, overrides, {SKYBODY_BENCH_PLUGINS}})),
        group_(compiled_->make_state(lanes > 0 ? lanes : compiled_->preferred_lanes())),
        work_(compiled_->make_workspace(group_.lanes())),
        observation_(count() * static_cast<std::size_t>(compiled_->observation_size())),
        reward_(count()),
        action_(count() * static_cast<std::size_t>(compiled_->action_size()), 0.2f),
        status_(count()) {
    for (int l = 0; l < lanes_of(); ++l) {
      compiled_->initialize(group_, l, 0, static_cast<std::uint64_t>(l));
    }
    reset();
  }

  int lanes_of() const { return group_.lanes(); }
  /// The action of every lane from now on, each component in [-1, 1].
  void hold(float action) { std::fill(action_.begin(), action_.end(), action); }
  void reset() { compiled_->reset(group_, *work_, all(), rows()); }
  void step() {
    compiled_->step(group_, *work_, all(), action_.data(), compiled_->action_size(), rows());
  }
  /// Physics only.
  void advance() { compiled_->advance(group_, *work_, all(), 1); }
  /// Task and rows only.
  void evaluate() { compiled_->evaluate(group_, *work_, all(), rows()); }
  /// Resets all lanes from time to time, so that none reaches the ground.
  void keep_flying(long step) {
    if (step % 500 == 0) reset();
  }

 private:
  std::size_t count() const { return static_cast<std::size_t>(group_.lanes()); }
  std::uint32_t all() const { return first_lanes(group_.lanes()); }
  Rows rows() { return {observation_.data(), reward_.data(), status_.data()}; }

  std::shared_ptr<const CompiledScenario> compiled_;
  StateGroup group_;
  std::unique_ptr<GroupWorkspace> work_;
  std::vector<float> observation_, reward_, action_;
  std::vector<std::uint64_t> status_;
};

}  // namespace skybody::bench
