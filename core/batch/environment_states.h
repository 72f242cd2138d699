// The environments of a Pool, and one transition of a group of them, resets included.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/math/hash.h"
#include "core/base/simd/lane_mask.h"
#include "core/batch/batch.h"
#include "core/batch/environment_groups.h"
#include "core/batch/episode_flags.h"
#include "core/batch/pool_options.h"
#include "core/batch/request_queues.h"
#include "core/env/compiled_scenario.h"
#include "core/env/group_workspace.h"
#include "core/env/state_values.h"

namespace skybody {

/// State, action rows and episode flags of N_E environments in lane groups. Groups are independent:
/// different threads may run transition() on different groups. All other methods belong to the
/// caller, while no group runs.
class EnvironmentStates {
 public:
  EnvironmentStates(std::shared_ptr<const CompiledScenario> compiled, const PoolOptions& options);

  const CompiledScenario& compiled() const { return *compiled_; }
  const std::shared_ptr<const CompiledScenario>& shared_scenario() const { return compiled_; }
  int envs() const { return places_.envs; }
  const EnvironmentGroups& places() const { return places_; }
  EpisodeFlags& flags() { return flags_; }
  RequestQueues& requests() { return requests_; }
  /// Whether ended episodes are followed by a reset.
  bool renews() const { return autoreset_ != Autoreset::kDisabled; }
  RowWidths widths() const;

  /// The action row of an environment's next step.
  float* action(int env) { return actions_.data() + static_cast<std::size_t>(env) * action_size_; }

  /// One transition of the lanes in `mask`; their rows are written at row env of `rows`.
  /// @param thread  index of the scratch to use, 0 <= thread < options.threads: never two calls at
  ///   a time with the same index
  void transition(int group, std::uint32_t mask, Batch& rows, int thread);

  /// Initializes all environments with a seed.
  void initialize(std::uint64_t seed);

  std::vector<std::uint64_t> save() const;
  /// @throws Error if it does not match this scenario, number of environments and version
  void check_saved(std::span<const std::uint64_t> saved) const;
  /// @throws Error like check_saved()
  void restore(std::span<const std::uint64_t> saved);
  void fork(int source, int target, bool rekey);
  /// An environment's last row of observations, and its privileged row.
  void observation(int env, float* out) const;
  void privileged(int env, float* out) const;
  /// An image of an environment, as its sensor last made it.
  void image(int env, int image, std::uint8_t* out) const;
  /// A value of every environment's state, one after the other. All must have begun an episode.
  void state(const StateValue& value, double* out);
  /// The task's goals in an environment that has begun an episode: 4 values each.
  void goals(int env, std::vector<double>& out);
  double param(int env, const std::string& path) const;
  void set_param(int env, const std::string& path, double value);
  std::uint64_t hash(int env) const { return chains_[index(env)].value(); }
  /// Whether transitions are added to the hashes from now on.
  void keep_hash(bool keep) { keep_hash_.store(keep, std::memory_order_relaxed); }
  /// Physics steps since construction, by the dynamics that computed them.
  StepCounts step_counts() const;
  /// Resets so far.
  std::uint64_t episode(int env) const { return state(env).bits(kEpisode)[places_.lane_of(env)]; }
  /// All state words of an environment, in the order of the layout.
  std::vector<std::uint64_t> words(int env) const;

 private:
  static std::size_t index(int env) { return static_cast<std::size_t>(env); }
  StateGroup& state(int env) { return states_[index(places_.group_of(env))]; }
  const StateGroup& state(int env) const { return states_[index(places_.group_of(env))]; }
  void last_values(int env, int first, int count, float* out) const;
  Rows rows_of(int first, Batch& rows, GroupWorkspace& work) const;
  void step(int group, std::uint32_t mask, Batch& rows, GroupWorkspace& work);
  void reset(int group, std::uint32_t mask, Batch& rows, GroupWorkspace& work);
  void reset_ended(int group, std::uint32_t mask, Batch& rows, GroupWorkspace& work);
  void add_to_hash(int group, std::uint32_t mask, const Rows& rows);
  void draw_again(int group);

  std::shared_ptr<const CompiledScenario> compiled_;
  EnvironmentGroups places_;
  std::size_t action_size_;
  Autoreset autoreset_;
  std::atomic<bool> keep_hash_;
  bool has_info_;
  std::uint64_t first_env_id_;
  std::vector<StateGroup> states_;
  std::vector<std::unique_ptr<GroupWorkspace>> works_;  ///< one per thread
  std::vector<float> actions_;
  EpisodeFlags flags_;
  RequestQueues requests_;
  std::vector<HashChain> chains_;
};

}  // namespace skybody
