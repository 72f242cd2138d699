// One of the eight slices of a AnalyticGradientLearner's environments: flies a horizon of
// transitions and goes back through them.
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
  std::span<const double> mean, scale;  ///< observations are normalised by: (x - mean) scale
  std::int64_t iteration = 0;
};

/// Sums of a slice over an iteration, in this order; behind them, of each observation, the sum
/// of its difference from the mean, and of that squared.
enum GradientSum : int {
  kSumCost,
  kSumDistance,
  kSumSteps,
  kSumFaulted,
  kSumEnds,              ///< environments
  kSumTouching,          ///< of them, those that a horizon leaves in contact with something
  kSumFlightSeconds,     ///< in transitions; figures alone, no bits follow from them
  kSumInferenceSeconds,  ///< in the network, forwards
  kSumReturnSeconds,     ///< from the horizon's end to its beginning
  kGradientSums
};

/// A slice's environments are groups of lanes that it steps itself. What it gives does not depend
/// on the thread that runs it.
class GradientSlice {
 public:
  /// @param compiled  that is trained in
  /// @param network   outlives this
  /// @param value     outlives this; null: there is none
  /// @param alike     a slice of the same scenario, which knows already which values of plugins
  ///                  depend on which; null: this one finds out
  /// @throws Error where no derivatives are known
  GradientSlice(std::shared_ptr<const CompiledScenario> compiled, const Hyperparameters& hyper,
                const Network& network, std::uint64_t seed, int first_env, int envs,
                const ValueFunction* value, const GradientSlice* alike);

  /// Flies a horizon in all environments and adds up gradients.
  void run(const GradientInputs& inputs);

  /// Lessons of the last run() for the value function; null: there is no value function.
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
    std::uint32_t lanes;  ///< that hold environments: the first
    int count;            ///< of them
    int first;            ///< environment, within the slice
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
  double weight_;                  ///< of one transition in the mean of an iteration
  double reward_weight_;           ///< of its reward, beside the cost's 1
  double goal_weight_;             ///< likewise of the cost
  double end_weight_;              ///< likewise of the value behind the horizon
  std::vector<double> discounts_;  ///< of each transition
  std::unique_ptr<GroupWorkspace> work_;
  TransitionAdjoint adjoint_;
  std::vector<Group> groups_;
  std::vector<std::uint32_t> flying_, sound_;  ///< per transition: lanes that take it; those
                                               ///< of them that no fault ended
  std::uint32_t terminated_ = 0;               ///< lanes that the task has ended
  AlignedArray<double> goal_, adjoints_, to_action_, cost_row_, distance_;
  AlignedArray<double> gain_;         ///< per transition and lane: what the value function sums up
  AlignedArray<float> observations_;  ///< of all environments now
  AlignedArray<float> x_, action_;    ///< per transition and lane
  AlignedArray<float> end_x_;         ///< likewise after the last transition, per lane
  AlignedArray<float> dx_, dy_, reward_, next_observation_;
  AlignedArray<std::uint64_t> status_;
  std::vector<NetworkActivations> memory_;  ///< per transition
  std::unique_ptr<HorizonValue> value_;
  AlignedArray<float> gradient_;
  std::vector<double> sums_, returns_;
  std::vector<float> episode_returns_;
};

}  // namespace skybody::learn
