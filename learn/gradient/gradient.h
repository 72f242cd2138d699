// Learning through the dynamics: the policy's gradient is the derivative of a smooth cost over a
// horizon of the engine's own transitions, computed backwards through them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "learn/common/learner_threads.h"
#include "learn/common/seen_images.h"
#include "learn/gradient/gradient_slice.h"
#include "learn/gradient/training_steps.h"
#include "learn/learner.h"
#include "learn/network/adam.h"
#include "learn/network/weight_average.h"

namespace skybody::learn {

/// Trains a deterministic policy, tanh(network(normalised observation)), by the gradient of
/// GoalCost. The result does not depend on the number of threads.
class AnalyticGradientLearner : public Learner {
 public:
  /// make_learner() compiles `training` and calls this.
  /// @param training  the training version of the scenario: options.compiled with
  ///        training_overrides()
  /// @throws Error (with the cause) if derivatives are not available (TransitionAdjoint), or if the
  ///         physics steps of `training` differ from `physics_steps`
  AnalyticGradientLearner(const LearnerOptions& options,
                          std::shared_ptr<const CompiledScenario> training);

  std::int64_t steps() const override { return counters_.steps; }
  Report iterate() override;
  PolicyFile policy() const override;
  std::uint64_t parameter_hash() const override;
  LearnerState state() const override;
  void restore(const LearnerState& state) override;

 private:
  template <class Self, class Visitor>
  static void visit(Self& self, Visitor& visitor);
  void add_up();
  void normalize();
  double update_value();

  struct Counters {
    std::int64_t steps = 0, iteration = 0;
  };

  std::shared_ptr<const CompiledScenario> compiled_, training_;
  Hyperparameters hyper_;
  std::int64_t total_steps_;
  std::vector<SeenImage> images_;
  PolicyNetwork network_;
  AlignedArray<float> parameters_;
  PolicyNetwork::Transposed transposed_;
  Adam adam_;
  RunningMoments moments_;
  std::unique_ptr<ValueFunction> value_;  ///< null: none
  std::vector<double> scale_;             ///< factors that normalise rows of inputs
  WeightAverage average_;
  Counters counters_;
  LearnerThreads threads_;
  std::vector<std::unique_ptr<GradientSlice>> slices_;
  std::vector<const float*> gradients_, value_gradients_;
  std::vector<double> sums_;
};

}  // namespace skybody::learn
