// One of the eight slices of an AnalyticGradientLearner's environments: runs a horizon of
// transitions forward and backward.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/derivative/transition_adjoint.h"
#include "core/env/group_workspace.h"
#include "learn/common/running_moments.h"
#include "learn/common/wall_clock.h"
#include "learn/gradient/goal_cost.h"
#include "learn/gradient/horizon_value.h"
#include "learn/learner.h"
#include "learn/network/network.h"

namespace skybody::learn {

/// Inputs of all slices.
struct GradientInputs {
  std::span<const float> parameters;
  const TransposedWeights* transposed = nullptr;
  std::span<const double> mean, scale;  ///< observations are normalised to (x - mean) scale
  std::int64_t iteration = 0;
};

/// Sums of a slice over an iteration, in this order. After them, for each observation, the sum of
/// its difference from the mean, and the sum of the squared difference.
enum GradientSum : int {
  kSumCost,
  kSumDistance,
  kSumSteps,
  kSumFaulted,
  kSumEnds,              ///< environments at the end of the horizon
  kSumTouching,          ///< number of these that are in contact at the end of the horizon
  kSumFlightSeconds,     ///< time in transitions; for reports only
  kSumInferenceSeconds,  ///< time in the network's forward pass
  kSumReturnSeconds,     ///< time in the backward pass through the horizon
  kGradientSums
};

/// A slice's environments are groups of lanes that it steps itself. Its results do not depend on
/// the thread that runs it.
class GradientSlice {
 public:
  /// @param compiled  the training version of the scenario
  /// @param network   must outlive the slice
  /// @param value     must outlive the slice; null: no value function
  /// @param alike     a slice of the same scenario that has already found the dependencies among
  ///        plugins' values; null: this one finds them
  /// @throws Error if no derivatives are available
  GradientSlice(std::shared_ptr<const CompiledScenario> compiled, const Hyperparameters& hyper,
                const Network& network, std::uint64_t seed, int first_env, int envs,
                const ValueFunction* value, const GradientSlice* alike);

  /// Runs a horizon in all environments and sums gradients.
  void run(const GradientInputs& inputs);

  /// Training data of the last run() for the value function; null: no value function.
  HorizonValue* value() const { return value_.get(); }

  std::span<const float> gradient() const { return {gradient_.data(), gradient_.size()}; }
  std::span<const double> sums() const { return sums_; }
  std::span<const float> episode_returns() const { return episode_returns_; }

  template <class Self, class Visitor>
  static void visit(Self& self, const std::string& name, Visitor& visitor) {
    visitor(name + ".returns", self.returns_.data(), self.returns_.size());
    visitor(name + ".observations", self.observations_.data(), self.observations_.size());
  }
  void save(std::vector<std::uint64_t>& words) const;
  std::size_t saved_words() const;
  void restore(std::span<const std::uint64_t> words);

 private:
  struct Group {
    StateGroup state;
    std::uint32_t lanes;  ///< lanes with environments: the first ones
    int count;            ///< number of these lanes
    int first;            ///< first environment, within the slice
  };
  void look();
  void begin();
  void reset(Group& group, std::uint32_t lanes);
  void fly(Group& group, const GradientInputs& inputs);
  void normalize(int env, const GradientInputs& inputs, float* to) const;
  void act(const Group& group, const GradientInputs& inputs, int t);
  void take_outcome(const Group& group, int t);
  void go_back(Group& group, const GradientInputs& inputs);
  void set_reward(int t, std::uint32_t lanes);
  void add_actions(int t, std::uint32_t lanes);
  void add_observations(const float* slopes, double weight, std::uint32_t lanes,
                        const GradientInputs& inputs);
  void look_at_ends(Group& group, const GradientInputs& inputs);
  void update_value();
  std::uint32_t ending(int t) const;
  void begin_anew(Group& group, std::int64_t iteration);
  void add_seconds(GradientSum sum, Clock::time_point begin);
  double* goal_at(int t) {
    return goal_.data() + std::ptrdiff_t{GoalCost::kGoalRows} * t * kGroupLanes;
  }
  float* row(AlignedArray<float>& rows, int t, int lane, int width) const {
    return rows.data() + (static_cast<std::ptrdiff_t>(t) * kGroupLanes + lane) * width;
  }

  std::shared_ptr<const CompiledScenario> compiled_;
  const Network& network_;
  GoalCost cost_;
  Isa isa_;
  std::uint64_t seed_;
  int first_env_, envs_, horizon_, actions_, seen_, stride_;
  double weight_;                  ///< weight of one transition in the mean of an iteration
  double reward_weight_;           ///< weight of the reward
  double goal_weight_;             ///< weight of the cost
  double end_weight_;              ///< weight of the value after the horizon
  std::vector<double> discounts_;  ///< discount of each transition
  std::unique_ptr<GroupWorkspace> work_;
  TransitionAdjoint adjoint_;
  std::vector<Group> groups_;
  std::vector<std::uint32_t> flying_,
      sound_;  ///< per transition: lanes that take it; those of them that no fault ended
  std::uint32_t terminated_ = 0;  ///< lanes whose episode the task has ended
  AlignedArray<double> goal_, adjoints_, to_action_, cost_row_, distance_;
  AlignedArray<double>
      gain_;  ///< per transition and lane: the summands of the value function's targets
  AlignedArray<float> observations_;  ///< current, of all environments
  AlignedArray<float> x_, action_;    ///< per transition and lane
  AlignedArray<float> end_x_;         ///< after the last transition, per lane
  AlignedArray<float> dx_, dy_, reward_, next_observation_;
  AlignedArray<std::uint64_t> status_;
  std::vector<NetworkActivations> memory_;  ///< per transition
  std::unique_ptr<HorizonValue> value_;
  AlignedArray<float> gradient_;
  std::vector<double> sums_, returns_;
  std::vector<float> episode_returns_;
};

}  // namespace skybody::learn
