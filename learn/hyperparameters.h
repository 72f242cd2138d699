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
  X(int, envs, 256, 1, 1 << 24, B, "number of environments") \
  X(int, rollout_steps, 32, 1, 1e6, B, "steps of each environment between two updates; in `gradient`, the horizon of the derivatives") \
  X(int, minibatch, 1024, 2, 1e9, P, "transitions per gradient step") \
  X(int, epochs, 1, 1, 1000, P, "passes over a rollout; a second pass fits the noise of the advantages") \
  X(int, value_epochs, 5, 1, 1000, B, "passes of the value function over a rollout") \
  X(double, learning_rate, 1e-3, 1e-12, 1, B, "learning rate of Adam at the beginning") \
  X(double, final_learning_rate, 0.05, 0, 1, B, "learning rate at the end, as a fraction of `learning_rate`; linear in between. The value function keeps `learning_rate`") \
  X(double, discount, 0.99, 0, 1, B, "gamma; `gradient` uses it only with a value function") \
  X(double, gae_lambda, 0.95, 0, 1, B, "lambda of generalized advantage estimation; in `gradient`, of the value function's targets") \
  X(double, clip_range, 0.2, 1e-6, 10, P, "clipping range of the probability ratio") \
  X(double, target_kl, 0, 0, 100, P, "policy updates on a rollout stop after a pass whose KL divergence exceeds 1.5 times this value; 0: never. No effect if `epochs` is 1") \
  X(double, entropy_weight, 0, 0, 100, P, "weight of the entropy in the loss") \
  X(double, value_weight, 0.5, 0, 100, P, "weight of the value function's error in the loss") \
  X(double, max_grad_norm, 0.5, 0, 1e6, B, "larger gradients are scaled down to this norm; 0: never") \
  X(double, log_std, -1, -20, 2, P, "logarithm of the actions' standard deviation at the beginning") \
  X(double, final_log_std, 0, -20, 2, P, "upper bound of `log_std` at the end, linear from `log_std`; 0: no bound") \
  X(bool, bounded_mean, false, 0, 1, P, "pass the actions' mean through a tanh, so that noise always changes the actions") \
  X(bool, squashed, false, 0, 1, P, "actions are the tanh of the drawn values, so that none is clipped; not with `bounded_mean`") \
  X(bool, shared_policy, false, 0, 1, P, "one policy for all robots of a team: each robot observes its own columns and those without an owner") \
  X(Sizes, hidden, (Sizes{64, 64}), 1, 8192, B, "sizes of the hidden layers, both of the policy and of the value function; `hidden=`: none, a linear policy") \
  X(int, recurrent_units, 0, 0, 4096, P, "units of gated recurrent memory in front of the policy's hidden layers; 0: none. With memory, a minibatch consists of whole rollouts of some environments. The value function has no memory: give it privileged columns") \
  X(Sizes, cnn_channels, (Sizes{16, 32, 32}), 1, 4096, B, "channels of each convolution of an observed image; `cnn_channels=` with empty `cnn_kernels` and `cnn_strides`: none") \
  X(Sizes, cnn_kernels, (Sizes{8, 4, 3}), 1, 4096, B, "height and width of each convolution's kernel [pixels]") \
  X(Sizes, cnn_strides, (Sizes{4, 2, 1}), 1, 4096, B, "stride of each convolution [pixels]") \
  X(bool, cnn_same_padding, false, 0, 1, B, "zeros around the images of each convolution, so that strides alone reduce the size; false: windows inside of the image only") \
  X(int, cnn_features, 128, 1, 8192, B, "outputs of the dense layer after the convolutions; they join the observation in front of the memory and the hidden layers") \
  X(double, cnn_range, 0, 0, 1e9, B, "pixels that are not bytes are clipped at this value, such as a depth [m]; 0: the upper bound of the image's column") \
  X(bool, value_images, true, 0, 1, P, "the value function has an image network of its own; false: it observes vectors only, with the privileged columns, and learns faster") \
  X(Activation, activation, Activation::kTanh, 0, 0, B, "tanh, relu or elu; of convolutions, too") \
  X(bool, normalize_rewards, true, 0, 1, P, "divide rewards by the standard deviation of the discounted return") \
  X(int, physics_steps, 4, 0, 1 << 20, G, "physics steps per action in training, with the scenario's integrator and a longer `dt`; 0: the scenario's number. Policies are evaluated with the scenario's steps") \
  X(double, approach_speed, 3, 1e-3, 1e3, G, "largest desired speed towards the goal [m/s]") \
  X(double, approach_rate, 2, 1e-3, 1e3, G, "close to the goal, the desired speed is the distance times this value [1/s]") \
  X(double, goal_weight, 1, 0, 1e6, G, "weight of the smooth cost that is derived from the goal; 0: only the task's reward") \
  X(double, end_value_weight, 0, 0, 100, G, "weight of a value function's estimate at the last observation of a horizon; 0: no value function, and steps after the horizon do not count") \
  X(double, reward_weight, 0, 0, 1e6, G, "weight of the task's reward, which is subtracted from the cost; 0 is faster") \
  X(double, observation_clip, 10, 1e-3, 1e6, P, "bound of normalized observations") \
  X(double, normalization_steps, 0, 0, 1e18, B, "number of steps after which the statistics of observations are frozen; 0: never") \
  X(double, averaging_steps, 0, 0, 1e18, B, "the saved policy is a mean over about this many steps; 0: the last one")
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
