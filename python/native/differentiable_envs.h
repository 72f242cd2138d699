// Environments with derivatives of their transitions, for Python.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/derivative/transition_adjoint.h"
#include "core/env/group_workspace.h"
#include "python/native/loaded_scenario.h"

namespace skybody::python {

/// Steps environments and records their transitions since the last reset; goes back through them.
/// An environment whose episode has ended stands still until the next reset: its observation
/// repeats, its rewards are 0. On the caller's thread.
class DifferentiableEnvs {
 public:
  /// @param steps  greatest number of transitions between two resets
  /// @throws InputError if a plugin has no derivatives, Error if the integrator has none
  DifferentiableEnvs(const LoadedScenario& scenario, int num_envs, int steps, std::uint64_t seed);

  const LoadedScenario& scenario() const { return scenario_; }
  int size() const { return size_; }
  int steps() const { return steps_; }
  int observation_size() const { return seen_; }
  int action_size() const { return actions_; }
  /// Values per environment of derivatives by a state.
  int state_size() const { return groups_[0].adjoint->rows(); }
  /// The number of the next transition, counted from construction over all resets.
  std::int64_t transition() const { return first_ + count_; }

  /// Begins the next episode of all environments. @param seed  if given, episode 1 under this key
  void reset(std::optional<std::uint64_t> seed);
  /// @param actions  action_size() per environment
  /// @throws Error before reset(), or if the record is full
  void step(std::span<const float> actions);

  /// Of the last reset() or step(), in rows.
  std::span<const float> observations() const { return observation_; }
  std::span<const float> rewards() const { return reward_; }
  std::span<const std::uint64_t> status() const { return status_; }

  /// Derivatives of a sum by a transition's results, in rows.
  struct Slopes {
    std::span<const float> observation, reward;
    std::span<const double> state;  ///< of later transitions, by the state after this one
  };
  /// @param state   receives derivatives by the state before the transition
  /// @param action  receives derivatives by the action; 0 where it was clipped
  /// @throws Error if the transition is not in the record
  void pull_back(std::int64_t transition, const Slopes& slopes, std::span<double> state,
                 std::span<float> action);

  /// Admits one thread at a time.
  std::atomic<bool>& in_use() { return in_use_; }

 private:
  struct Group {
    StateGroup state;
    std::unique_ptr<TransitionAdjoint> adjoint;
    int first, count;                  ///< environments
    std::vector<std::uint32_t> flown;  ///< per transition: the lanes that took it
    std::vector<std::uint32_t> sound;  ///< those of them that no fault ended
    bool is_begun = false;             ///< adjoint->begin() was called since the last reset
  };
  Rows rows(const Group& group);
  void add_group(int first, int count);
  void initialize(std::uint64_t seed);
  void step(Group& group, std::span<const float> actions);
  void load(const Group& group, int t, const Slopes& slopes);
  void unload(const Group& group, int t, std::span<double> state, std::span<float> action);
  std::uint32_t running(const Group& group) const;
  bool is_clipped(int t, std::size_t k) const;

  LoadedScenario scenario_;
  int size_, steps_, seen_, actions_;
  std::vector<int> task_rows_;  ///< per value of an observation; -1: no derivatives
  std::unique_ptr<GroupWorkspace> work_;
  std::vector<Group> groups_;
  std::vector<float> observation_, reward_;
  std::vector<std::uint64_t> status_;
  std::vector<float> given_;  ///< actions of all transitions in the record
  AlignedArray<double> adjoints_, to_action_;
  std::int64_t first_ = 0;  ///< the number of the first transition in the record
  int count_ = 0;           ///< transitions in the record
  bool is_reset_ = false;
  std::atomic<bool> in_use_ = false;
};

}  // namespace skybody::python
