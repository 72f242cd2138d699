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
#include "learn/gradient/horizon_inputs.h"
#include "learn/gradient/horizon_value.h"
#include "learn/learner.h"
#include "learn/network/policy_network.h"

namespace skybody::learn {

/// Inputs of all slices.
struct GradientInputs {
  std::span<const float> parameters;
  const PolicyNetwork::Transposed* transposed = nullptr;
  std::span<const double> mean, scale;  ///< observations are normalised to (x - mean) scale
  std::int64_t iteration = 0;
};

/// Sums of a slice over an iteration, in this order. After them, for each value of a row of inputs,
/// the sum of its difference from the mean, and the sum of the squared difference.
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
                const PolicyNetwork& network, std::uint64_t seed, int first_env, int envs,
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
    HorizonInputs::visit(self.inputs_, name, visitor);
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
  /// Weights of the terms of the loss.
  struct Weights {
    Weights(const Hyperparameters& hyper, bool has_value);

    double transition;              ///< of one transition in the mean of an iteration
    double reward, goal, end;       ///< of the reward, the cost, the value after the horizon
    std::vector<double> discounts;  ///< of each transition
  };
  /// A group's flight through a horizon.
  struct Flight {
    Flight(int steps, int actions);

    std::vector<std::uint32_t> flying;  ///< per transition: lanes that take it
    std::vector<std::uint32_t> sound;   ///< those of them that no fault ended
    std::uint32_t terminated = 0;       ///< lanes whose episode the task has ended
    AlignedArray<double> goal;          ///< per transition: GoalCost::kGoalRows
    AlignedArray<double> gain;   ///< per transition and lane: summands of the value's targets
    AlignedArray<float> action;  ///< per transition and lane
  };
  /// Derivatives of the loss on the way back, for one transition.
  struct Slopes {
    Slopes(int rows, int actions, int input_stride);

    AlignedArray<double> adjoints;        ///< rows of TransitionAdjoint
    AlignedArray<double> to_action;       ///< by the actions
    AlignedArray<double> cost, distance;  ///< per lane: the goal's cost, and its distance [m]
    AlignedArray<float> inputs, outputs;  ///< by the network's inputs and outputs
  };
  void begin();
  void reset(Group& group, std::uint32_t lanes);
  void fly(Group& group, const GradientInputs& inputs);
  void act(const Group& group, const GradientInputs& inputs, int t);
  void take_outcome(const Group& group, int t);
  void go_back(Group& group, const GradientInputs& inputs);
  void pull_back_network(const Group& group, const GradientInputs& inputs, int t);
  void set_reward(int t, std::uint32_t lanes);
  void add_actions(int t, std::uint32_t lanes);
  void add_observations(const float* slopes, int count, double weight, std::uint32_t lanes,
                        const GradientInputs& inputs);
  void look_at_ends(Group& group, const GradientInputs& inputs);
  void update_value();
  std::uint32_t ending(int t) const;
  void begin_anew(Group& group, std::int64_t iteration);
  void add_seconds(GradientSum sum, Clock::time_point begin);
  double* goal_at(int t) {
    return flight_.goal.data() + std::ptrdiff_t{GoalCost::kGoalRows} * t * kGroupLanes;
  }
  float* action(int t, int lane) {
    return flight_.action.data() + (static_cast<std::ptrdiff_t>(t) * kGroupLanes + lane) * actions_;
  }
  PolicySteps steps_of(const Group& group, int t) const;
  PolicyNetwork::Memory& memory_of(int t);

  std::shared_ptr<const CompiledScenario> compiled_;
  const PolicyNetwork& network_;
  GoalCost cost_;
  Isa isa_;
  std::uint64_t seed_;
  int first_env_, envs_, horizon_, actions_;
  Weights weights_;
  std::unique_ptr<GroupWorkspace> work_;
  TransitionAdjoint adjoint_;
  std::vector<Group> groups_;
  HorizonInputs inputs_;
  Flight flight_;  ///< of the current group
  Slopes slopes_;
  AlignedArray<float> reward_;
  AlignedArray<std::uint64_t> status_;
  std::vector<PolicyNetwork::Memory> memory_;  ///< per transition; with images for one at a time
  std::unique_ptr<HorizonValue> value_;
  AlignedArray<float> gradient_;
  std::vector<double> sums_, returns_;
  std::vector<float> episode_returns_;
};

}  // namespace skybody::learn
