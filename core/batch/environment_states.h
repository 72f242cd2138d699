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
#include "core/batch/lane_flags.h"
#include "core/batch/pool_options.h"
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
  int envs() const { return envs_; }
  /// Environments of one group are stored side by side: span() of them, fewer in the last group.
  /// The span is 1 where the physics runs lane by lane, or where larger groups would leave threads
  /// idle.
  int groups() const { return static_cast<int>(states_.size()); }
  int span() const { return span_; }
  int group_of(int env) const { return env / span_; }
  int lane_of(int env) const { return env % span_; }
  int env_of(int group, int lane) const { return group * span_ + lane; }
  RowWidths widths() const;

  /// The kind of the next transition of an environment: a step with this action, or a reset.
  float* action(int env) { return actions_.data() + static_cast<std::size_t>(env) * action_size_; }
  void want_reset(int env) { wants_reset_.set(group_of(env), bit(env), true); }
  void want_step(int env) { wants_reset_.set(group_of(env), bit(env), false); }
  void want_step_all();
  /// Adds a request for the transitions of an environment that are sent from now on. The
  /// environment may be in flight.
  /// @param at_reset  true: at the next begin of an episode; false: before the next transition, or,
  ///   if that is a reset, in it
  void ask(int env, std::shared_ptr<const ParamRequest> request, bool at_reset);
  /// Hands an environment's requests over to the thread that runs it next. Call it before sending.
  void hand_over(int env) {
    if (has_asked_) hand_over_requests(env);
  }
  void hand_over_all();

  bool started(int env) const { return (started_.of(group_of(env)) & bit(env)) != 0; }
  bool ended(int env) const { return (ended_.of(group_of(env)) & bit(env)) != 0; }
  /// Whether all environments can be stepped without a reset.
  bool can_step_all() const;
  /// The lanes of a group that have an environment.
  std::uint32_t all_lanes(int group) const {
    return first_lanes(std::min(span_, envs_ - group * span_));
  }

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
  double param(int env, const std::string& path) const;
  void set_param(int env, const std::string& path, double value);
  std::uint64_t hash(int env) const { return chains_[index(env)].value(); }
  /// Whether transitions are added to the hashes from now on.
  void keep_hash(bool keep) { keep_hash_.store(keep, std::memory_order_relaxed); }
  /// Physics steps since construction, by the dynamics that computed them.
  StepCounts step_counts() const;
  /// Resets so far.
  std::uint64_t episode(int env) const { return state(env).bits(kEpisode)[lane_of(env)]; }
  /// All state words of an environment, in the order of the layout.
  std::vector<std::uint64_t> words(int env) const;

 private:
  std::uint32_t bit(int env) const { return 1u << lane_of(env); }
  static std::size_t index(int env) { return static_cast<std::size_t>(env); }
  StateGroup& state(int env) { return states_[index(group_of(env))]; }
  const StateGroup& state(int env) const { return states_[index(group_of(env))]; }
  void last_values(int env, int first, int count, float* out) const;
  Rows rows_of(int first, Batch& rows, GroupWorkspace& work) const;
  void step(int group, std::uint32_t mask, Batch& rows, GroupWorkspace& work);
  void reset(int group, std::uint32_t mask, Batch& rows, GroupWorkspace& work);
  void reset_ended(int group, std::uint32_t mask, Batch& rows, GroupWorkspace& work);
  void add_to_hash(int group, std::uint32_t mask, const Rows& rows);
  void refresh_flags(int env);
  void hand_over_requests(int env);
  void apply_requests(int group, std::uint32_t mask, GroupWorkspace& work);
  void begin_requests(int group, std::uint32_t mask, bool takes_all, GroupWorkspace& work);
  void end_requests(int group, std::uint32_t mask, GroupWorkspace& work);
  void describe(int group, std::uint32_t mask, bool is_reset, Batch& rows);
  bool describe_running(int first, const std::uint64_t* steps, bool is_reset, Batch& rows);

  std::shared_ptr<const CompiledScenario> compiled_;
  int envs_;
  int span_;
  std::size_t action_size_;
  Autoreset autoreset_;
  std::atomic<bool> keep_hash_;
  bool has_info_;
  std::uint64_t first_env_id_;
  std::vector<StateGroup> states_;
  std::vector<std::unique_ptr<GroupWorkspace>> works_;  ///< one per thread
  std::vector<float> actions_;
  AtomicLaneMasks wants_reset_;      ///< written by the caller
  AtomicLaneMasks started_, ended_;  ///< written by the thread that runs the group
  std::vector<HashChain> chains_;

  struct Asked {
    std::shared_ptr<const ParamRequest> request;
    bool at_reset;
  };
  using Requests = std::vector<std::shared_ptr<const ParamRequest>>;
  std::vector<std::vector<Asked>> asked_;   ///< per environment, used by the caller: requests not
                                            ///< yet handed over
  std::vector<std::vector<Asked>> handed_;  ///< used by the thread that runs the group: for the
                                            ///< next transition
  std::vector<Requests> waiting_;           ///< likewise: for the next reset
  bool has_asked_ = false;                  ///< used by the caller: any request so far
  std::atomic<bool> has_handed_{false};     ///< any request handed over so far
};

}  // namespace skybody
