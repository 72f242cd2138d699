// Hyper-parameters of the learners, in one list with one row each. The struct, the checks, `--set`,
// config.json and the Python binding are generated from it.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/io/files/policy_file.h"

namespace skybody::learn {

/// The learners of this library, with the names of `--algo`.
enum class Algorithm { kFastPpo, kGradient };
/// In the order of Algorithm.
inline constexpr const char* kAlgorithmNames[] = {"fast-ppo", "gradient"};
inline const char* name(Algorithm algorithm) {
  return kAlgorithmNames[static_cast<int>(algorithm)];
}

// X(type, name, default, least, largest, algorithms, meaning)
//   type: int, double, bool, Sizes (units of each layer), Activation
//   algorithms: P: fast-ppo, G: gradient, B: both
// clang-format off
#define SKYBODY_HYPERPARAMETERS(X) \
  X(int, envs, 256, 1, 1 << 24, B, "environments that are stepped side by side") \
  X(int, rollout_steps, 32, 1, 1e6, B, "steps of each environment between two updates; for `gradient` the horizon of its derivatives") \
  X(int, minibatch, 1024, 2, 1e9, P, "transitions per gradient step") \
  X(int, epochs, 1, 1, 1000, P, "passes over a rollout; a second one fits noise of the first one's advantages") \
  X(int, value_epochs, 5, 1, 1000, B, "the value function's passes") \
  X(double, learning_rate, 1e-3, 1e-12, 1, B, "of Adam, at the beginning") \
  X(double, final_learning_rate, 0.05, 0, 1, B, "at the end, as a share of `learning_rate`; linear between. The value function keeps the first") \
  X(double, discount, 0.99, 0, 1, B, "gamma; for `gradient` where it has a value function") \
  X(double, gae_lambda, 0.95, 0, 1, B, "lambda of generalized advantage estimation, or of the value function's targets in `gradient`") \
  X(double, clip_range, 0.2, 1e-6, 10, P, "of the ratio of probabilities") \
  X(double, target_kl, 0, 0, 100, P, "a rollout's updates of the policy stop after a pass beyond 1.5 times this KL divergence; 0: never. With one of `epochs` there is nothing to stop") \
  X(double, entropy_weight, 0, 0, 100, P, "of this term in the loss") \
  X(double, value_weight, 0.5, 0, 100, P, "of this term in the loss") \
  X(double, max_grad_norm, 0.5, 0, 1e6, B, "gradients are scaled down to this norm; 0: never") \
  X(double, log_std, -1, -20, 2, P, "logarithm of the actions' standard deviation, at the beginning") \
  X(double, final_log_std, 0, -20, 2, P, "at the end: learned below the line of the two; 0: learned freely") \
  X(bool, bounded_mean, false, 0, 1, P, "actions' mean through a tanh, so that noise always tells about actions") \
  X(bool, squashed, false, 0, 1, P, "actions are the tanh of what is drawn, so that none is cut off; not with `bounded_mean`") \
  X(bool, shared_policy, false, 0, 1, P, "one policy for all robots of a team: each sees its own columns and those of nobody") \
  X(Sizes, hidden, (Sizes{64, 64}), 1, 8192, B, "sizes of the hidden layers, of policy and value function each; `hidden=`: none, a linear policy") \
  X(int, recurrent_units, 0, 0, 4096, P, "units of gated recurrent memory in front of the policy's hidden layers; 0: none. A minibatch is then whole rollouts of some environments. The value function has no memory: show it privileged columns") \
  X(Activation, activation, Activation::kTanh, 0, 0, B, "tanh, relu or elu") \
  X(bool, normalize_rewards, true, 0, 1, P, "divide rewards by the deviation of the discounted return") \
  X(int, physics_steps, 4, 0, 1 << 20, G, "physics steps of an action in training, of the scenario's rule but longer; 0: the scenario's own. Policies are judged by the scenario's own") \
  X(double, approach_speed, 3, 1e-3, 1e3, G, "largest speed towards the goal that is asked for [m/s]") \
  X(double, approach_rate, 2, 1e-3, 1e3, G, "close to the goal that speed is the distance times this [1/s]") \
  X(double, goal_weight, 1, 0, 1e6, G, "of the smooth cost that follows from the goal; 0: the task's own reward alone") \
  X(double, end_value_weight, 0, 0, 100, G, "of what a value function says of a horizon's last observation; 0: there is none, and what follows a horizon does not count") \
  X(double, reward_weight, 0, 0, 1e6, G, "of the task's own reward, which is taken off the cost; 0 is quicker") \
  X(double, observation_clip, 10, 1e-3, 1e6, P, "bound of normalized observations") \
  X(double, normalization_steps, 0, 0, 1e18, B, "after which observations' statistics stay; 0: they never do") \
  X(double, averaging_steps, 0, 0, 1e18, B, "the policy that is kept is a mean over about so many steps; 0: the last")
// clang-format on

using Sizes = std::vector<int>;

/// Values of all hyper-parameters; those of other algorithms are ignored.
struct Hyperparameters {
#define SKYBODY_ROW(TYPE, NAME, DEFAULT, LEAST, LARGEST, ALGORITHMS, MEANING) TYPE NAME = DEFAULT;
  SKYBODY_HYPERPARAMETERS(SKYBODY_ROW)
#undef SKYBODY_ROW
};

/// A row of the list.
struct HyperparameterRow {
  const char* name;
  double least, largest;    ///< range of a number, or of each of Sizes
  bool fast_ppo, gradient;  ///< algorithms that use it
  const char* meaning;
};

/// All rows, in order.
std::span<const HyperparameterRow> hyperparameter_rows();

/// Whether an algorithm has the hyper-parameter of a row.
inline bool has(const HyperparameterRow& row, Algorithm algorithm) {
  return algorithm == Algorithm::kGradient ? row.gradient : row.fast_ppo;
}

/// Names of an algorithm's hyper-parameters, in the list's order.
std::vector<std::string> hyperparameter_names(Algorithm algorithm);

/// @throws Error if one of the algorithm's hyper-parameters is out of range, or `hidden` has more
///         layers than a policy file: the message has its name, the value and the range
void check(const Hyperparameters& hyper, Algorithm algorithm);

}  // namespace skybody::learn
