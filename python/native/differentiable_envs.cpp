#include "python/native/differentiable_envs.h"

#include <algorithm>
#include <cmath>

#include "core/base/simd/fp_environment.h"
#include "core/base/simd/lane_mask.h"
#include "core/io/yaml/diagnostics.h"
#include "core/model/located_error.h"

namespace skybody::python {
namespace {

/// Enough transitions to find the dependences between values of plugins.
constexpr int kFewestRecorded = 8;

std::unique_ptr<TransitionAdjoint> make_adjoint(const LoadedScenario& scenario, int steps) {
  try {
    return std::make_unique<TransitionAdjoint>(*scenario, steps, true);
  } catch (const LocatedError& error) {
    throw InputError({{Severity::kError, error.mark(), error.message()}});
  }
}

std::size_t product(int a, int b) {
  return static_cast<std::size_t>(a) * static_cast<std::size_t>(b);
}

}  // namespace

DifferentiableEnvs::DifferentiableEnvs(const LoadedScenario& scenario, int num_envs, int steps,
                                       std::uint64_t seed)
    : scenario_(scenario),
      size_(num_envs),
      steps_(steps),
      seen_(scenario->observation_size()),
      actions_(scenario->action_size()),
      task_rows_(task_rows(*scenario)),
      work_(scenario->make_workspace(kGroupLanes)),
      observation_(product(num_envs, seen_)),
      reward_(static_cast<std::size_t>(num_envs)),
      status_(static_cast<std::size_t>(num_envs)),
      given_(product(steps, num_envs) * static_cast<std::size_t>(actions_)),
      to_action_(product(kGroupLanes, actions_)) {
  const FpEnvironment guard;
  for (int first = 0; first < num_envs; first += kGroupLanes) {
    add_group(first, std::min(num_envs - first, kGroupLanes));
  }
  adjoints_ = AlignedArray<double>(product(kGroupLanes, state_size()));
  initialize(seed);
}

void DifferentiableEnvs::add_group(int first, int count) {
  const auto steps = static_cast<std::size_t>(steps_);
  auto adjoint = make_adjoint(scenario_, std::max(steps_, kFewestRecorded));
  if (groups_.empty()) {
    StateGroup scratch = scenario_->make_state(kGroupLanes);
    AlignedArray<float> observation(product(kGroupLanes, seen_)), reward(kGroupLanes);
    AlignedArray<std::uint64_t> status(kGroupLanes);
    adjoint->look_at_flights(scratch, *work_, {observation.data(), reward.data(), status.data()},
                             kFewestRecorded);
  } else {
    adjoint->copy_sparsity(*groups_[0].adjoint);
  }
  adjoint->color_columns();
  groups_.push_back({scenario_->make_state(kGroupLanes), std::move(adjoint), first, count,
                     std::vector<std::uint32_t>(steps), std::vector<std::uint32_t>(steps)});
}

void DifferentiableEnvs::initialize(std::uint64_t seed) {
  for (Group& group : groups_) {
    each_lane(first_lanes(group.count), [&](int l) {
      scenario_->initialize(group.state, l, seed, static_cast<std::uint64_t>(group.first + l));
    });
  }
}

Rows DifferentiableEnvs::rows(const Group& group) {
  return {observation_.data() + product(group.first, seen_), reward_.data() + group.first,
          status_.data() + group.first};
}

std::uint32_t DifferentiableEnvs::running(const Group& group) const {
  std::uint32_t lanes = 0;
  each_lane(first_lanes(group.count), [&](int l) {
    if (status_[static_cast<std::size_t>(group.first + l)] == kRunning) lanes |= 1u << l;
  });
  return lanes;
}

// --- forward ------------------------------------------------------------------------------------

void DifferentiableEnvs::reset(std::optional<std::uint64_t> seed) {
  const FpEnvironment guard;
  if (seed) initialize(*seed);
  for (Group& group : groups_) {
    scenario_->reset(group.state, *work_, first_lanes(group.count), rows(group));
    group.is_begun = false;
  }
  first_ += count_;
  count_ = 0;
  is_reset_ = true;
}

void DifferentiableEnvs::step(std::span<const float> actions) {
  if (!is_reset_) throw Error("step() before reset()");
  if (count_ == steps_) {
    throw Error("the record is full: `steps` is " + std::to_string(steps_) +
                "; call reset(), or make the environments with larger `steps`");
  }
  const FpEnvironment guard;
  std::copy(actions.begin(), actions.end(), given_.begin() + count_ * std::ssize(actions));
  for (Group& group : groups_) step(group, actions);
  ++count_;
}

void DifferentiableEnvs::step(Group& group, std::span<const float> actions) {
  const std::uint32_t lanes = running(group);
  std::fill_n(reward_.begin() + group.first, group.count, 0.0f);
  if (lanes != 0) {
    group.adjoint->step(group.state, *work_, lanes, &actions[product(group.first, actions_)],
                        actions_, rows(group), count_);
  }
  std::uint32_t sound = lanes;
  each_lane(lanes, [&](int l) {
    if ((status_[static_cast<std::size_t>(group.first + l)] & kFault) != 0) sound &= ~(1u << l);
  });
  group.flown[static_cast<std::size_t>(count_)] = lanes;
  group.sound[static_cast<std::size_t>(count_)] = sound;
}

// --- backward -----------------------------------------------------------------------------------

void DifferentiableEnvs::pull_back(std::int64_t transition, const Slopes& slopes,
                                   std::span<double> state, std::span<float> action) {
  if (transition < first_ || transition >= first_ + count_) {
    throw Error("transition " + std::to_string(transition) +
                " is not in the record, which begins at the last reset" +
                (count_ == 0 ? ": it is empty"
                             : " and has transitions " + std::to_string(first_) + " to " +
                                   std::to_string(first_ + count_ - 1)) +
                "; call pull_back() before the next reset()");
  }
  const FpEnvironment guard;
  const auto t = static_cast<int>(transition - first_);
  for (Group& group : groups_) {
    if (!group.is_begun) group.adjoint->begin(group.state, first_lanes(group.count));
    group.is_begun = true;
    load(group, t, slopes);
    to_action_.fill_zero();
    const std::uint32_t lanes = group.sound[static_cast<std::size_t>(t)];
    if (lanes != 0) {
      group.adjoint->pull_back(group.state, t, lanes, adjoints_.data(), to_action_.data());
    }
    unload(group, t, state, action);
  }
}

/// Sets the adjoints after transition `t`. A transition that a fault ended has none.
void DifferentiableEnvs::load(const Group& group, int t, const Slopes& slopes) {
  const int observed = group.adjoint->observation_row(), rewarded = group.adjoint->reward_row();
  const std::uint32_t flown = group.flown[static_cast<std::size_t>(t)];
  const std::uint32_t faulted = flown & ~group.sound[static_cast<std::size_t>(t)];
  adjoints_.fill_zero();
  each_lane(first_lanes(group.count) & ~faulted, [&](int l) {
    const std::size_t env = static_cast<std::size_t>(group.first + l);
    const auto at = [&](int row) -> double& {
      return adjoints_[product(row, kGroupLanes) + static_cast<std::size_t>(l)];
    };
    const double* const from = slopes.state.data() + env * static_cast<std::size_t>(state_size());
    for (int row = 0; row < state_size(); ++row) at(row) = from[row];
    const float* const seen = slopes.observation.data() + env * static_cast<std::size_t>(seen_);
    for (int k = 0; k < seen_; ++k) {
      const int row = task_rows_[static_cast<std::size_t>(k)];
      if (row >= 0) at(observed + row) += static_cast<double>(seen[k]);
    }
    if ((flown >> l & 1u) != 0) at(rewarded) += static_cast<double>(slopes.reward[env]);
  });
}

void DifferentiableEnvs::unload(const Group& group, int t, std::span<double> state,
                                std::span<float> action) {
  each_lane(first_lanes(group.count), [&](int l) {
    const auto lane = static_cast<std::size_t>(l);
    const std::size_t env = static_cast<std::size_t>(group.first) + lane;
    double* const to = state.data() + env * static_cast<std::size_t>(state_size());
    for (int row = 0; row < state_size(); ++row) {
      to[row] = adjoints_[product(row, kGroupLanes) + lane];
    }
    const bool is_sound = (group.sound[static_cast<std::size_t>(t)] >> l & 1u) != 0;
    for (int k = 0; k < actions_; ++k) {
      const std::size_t place =
          env * static_cast<std::size_t>(actions_) + static_cast<std::size_t>(k);
      const double slope = to_action_[product(k, kGroupLanes) + lane];
      action[place] = is_sound && !is_clipped(t, place) ? static_cast<float>(slope) : 0.0f;
    }
  });
}

bool DifferentiableEnvs::is_clipped(int t, std::size_t k) const {
  return std::abs(given_[product(t, size_) * static_cast<std::size_t>(actions_) + k]) > 1.0f;
}

}  // namespace skybody::python
