#include "learn/rollout/rollout.h"

#include <algorithm>
#include <string>

#include "core/base/system/error.h"
#include "learn/common/policy_metadata.h"
#include "learn/network/panel_matrix.h"
#include "learn/network/product.h"

namespace skybody::learn {
namespace {

const RolloutOptions& checked(const RolloutOptions& options) {
  const auto demand = [](bool good, const char* name, double value, const char* allowed) {
    if (good) return;
    throw Error(std::string("option ") + name + " = " + std::to_string(value) + ": allowed is " +
                allowed);
  };
  demand(options.steps >= 1, "steps", options.steps, "at least 1");
  demand(options.discount >= 0.0 && options.discount <= 1.0, "discount", options.discount,
         "0 to 1");
  demand(options.gae_lambda >= 0.0 && options.gae_lambda <= 1.0, "gae_lambda", options.gae_lambda,
         "0 to 1");
  demand(options.observation_clip > 0.0, "observation_clip", options.observation_clip, "above 0");
  if (options.compiled->observation_size() > 0 && options.compiled->action_size() > 0)
    return options;
  throw Error("`" + options.compiled->scenario().name +
              "` has no vector of observations or takes no actions: there is nothing to learn");
}

PoolOptions pool_options(const RolloutOptions& options) {
  PoolOptions pool;
  pool.envs = options.envs;
  pool.threads = options.threads;
  pool.seed = options.seed;
  return pool;
}

}  // namespace

Rollout::Rollout(const RolloutOptions& options)
    : stride_(padded(checked(options).compiled->observation_size())),
      terms_{static_cast<float>(options.discount), static_cast<float>(options.gae_lambda), 1.0f},
      normalization_steps_(options.normalization_steps),
      environments_(options.compiled, pool_options(options)),
      normalizer_(static_cast<std::size_t>(options.compiled->observation_size()),
                  options.observation_clip),
      discounted_(options.envs, options.discount),
      return_moments_(1),
      advantages_(options.steps, options.envs),
      rows_(advantages_.at(options.steps + 1, 0) * static_cast<std::size_t>(stride_)),
      last_(product(rows(), stride_)),
      last_values_(product(options.steps, options.envs)),
      actions_(product(rows(), options.compiled->action_size())),
      advantage_(last_values_.size()),
      target_(last_values_.size()),
      returns_(static_cast<std::size_t>(options.envs)),
      error_(find_position_error(*options.compiled)) {
  cut_.reserve(last_values_.size());
  episode_returns_.reserve(last_values_.size());
}

void Rollout::begin() {
  advantages_.begin();
  cut_.clear();
  episode_returns_.clear();
  error_sum_ = error_count_ = 0.0;
}

/// Writes the current observations, normalized, to the rows of a step.
void Rollout::observe(int step) {
  const int width = environments_.compiled().observation_size();
  float* const first =
      rows_.data() + static_cast<std::ptrdiff_t>(advantages_.at(step, 0)) * stride_;
  for (int env = 0; env < envs(); ++env) {
    std::copy_n(environments_.observation(env), width, first + std::ptrdiff_t{env} * stride_);
  }
  const bool is_frozen =
      normalization_steps_ > 0.0 && static_cast<double>(total_steps_) >= normalization_steps_;
  normalizer_.apply(first, envs(), stride_, step < advantages_.steps() && !is_frozen);
}

std::span<float> Rollout::actions_of(int step) {
  const std::size_t count = product(envs(), environments_.compiled().action_size());
  return std::span(actions_).subspan(static_cast<std::size_t>(step) * count, count);
}

void Rollout::act(int step) {
  environments_.step(actions_of(step));
  double sum = 0.0, squares = 0.0;
  for (int env = 0; env < envs(); ++env) {
    const float reward = environments_.batch().reward[static_cast<std::size_t>(env)];
    const EpisodeEnd end = environments_.end_of(env);
    const bool goes_on = end == EpisodeEnd::kNone;
    advantages_.set(advantages_.at(step, env), reward, goes_on);
    const double difference = discounted_.add(env, reward, goes_on) - return_moments_.mean[0];
    sum += difference;
    squares += difference * difference;
    double& total = returns_[static_cast<std::size_t>(env)];
    total += static_cast<double>(reward);
    add_error(env, !goes_on);
    if (goes_on) continue;
    episode_returns_.push_back(static_cast<float>(total));
    total = 0.0;
    if (end != EpisodeEnd::kCut) continue;
    std::copy_n(environments_.last_observation(env), environments_.compiled().observation_size(),
                last_.data() + static_cast<std::ptrdiff_t>(cut_.size()) * stride_);
    cut_.push_back(advantages_.at(step, env));
  }
  return_moments_.add(envs(), {&sum, 1}, {&squares, 1});
}

void Rollout::add_error(int env, bool has_ended) {
  const Batch& batch = environments_.batch();
  if (!error_.is_told() || batch.fault[static_cast<std::size_t>(env)] != 0) return;
  const float* info = (has_ended ? batch.final_info : batch.info).data();
  error_sum_ += error_.of(info + product(env, batch.width.info));
  error_count_ += 1.0;
}

void Rollout::finish() {
  observe(advantages_.steps());
  normalizer_.apply(last_.data(), static_cast<int>(cut_.size()), stride_, false);
  normalizer_.update();
  total_steps_ += rows();
}

PolicyFile Rollout::policy(const TrainedNetwork& network, const std::string& algorithm) const {
  PolicyFile file = policy_metadata(environments_.compiled(), algorithm, total_steps_);
  set_normalization(normalizer_.moments(), normalizer_.bound(), file);
  file.layers = network.network().layers(network.parameters());
  return file;
}

void Rollout::estimate() {
  for (std::size_t k = 0; k < cut_.size(); ++k) {
    advantages_.set_end_value(cut_[k], last_values_[k]);
  }
  terms_.reward_scale = static_cast<float>(return_moments_.scale(0));
  advantages_.estimate(terms_, [&](int step, int env, float advantage, float target) {
    advantage_[advantages_.at(step, env)] = advantage;
    target_[advantages_.at(step, env)] = target;
  });
}

}  // namespace skybody::learn
