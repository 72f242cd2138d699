// The environments of a rollout, with their current observations.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/batch/pool.h"

namespace skybody::learn {

/// How a step ended an episode, for the value of the states after it.
enum class EpisodeEnd {
  kNone,   ///< it goes on
  kFinal,  ///< terminated, or ended by a fault: no value follows
  kCut     ///< truncated: the value of the last observation follows
};

/// A Pool that is stepped as a whole. An environment whose episode ends begins the next one in the
/// same step. Not copyable; one thread at a time.
class RolloutEnvironments {
 public:
  /// Begins episodes in all environments.
  /// @param options  `batch` and `autoreset` are replaced: a batch has all environments
  /// @throws Error as Pool
  RolloutEnvironments(std::shared_ptr<const CompiledScenario> compiled, PoolOptions options);

  int size() const { return pool_.envs(); }
  const Pool& pool() const { return pool_; }
  const CompiledScenario& compiled() const { return pool_.compiled(); }

  /// Current observation of an environment, observation_size() floats in the units of the task's
  /// channels. Valid until the next step(), reset() or restore().
  const float* observation(int env) const { return observation_ + offset(env, observation_size_); }
  /// Likewise its privileged row, privileged_size() floats, for value functions.
  const float* privileged(int env) const { return privileged_ + offset(env, privileged_size_); }

  /// One action of every environment.
  /// @param actions  size() rows of action_size() values in [-1, 1], clipped
  /// @throws Error on another number of values; an exception of a worker
  void step(std::span<const float> actions);
  /// Results of the last step(), such as rewards and infos. There is none after construction,
  /// reset() and restore().
  const Batch& batch() const { return *batch_; }
  bool has_batch() const { return batch_ != nullptr; }
  EpisodeEnd end_of(int env) const;
  /// Observation and privileged row after the last step of an episode that the last step() ended.
  const float* last_observation(int env) const {
    return batch_->final_observation.data() + offset(env, observation_size_);
  }
  const float* last_privileged(int env) const {
    return batch_->final_privileged.data() + offset(env, privileged_size_);
  }

  /// Begins new episodes in the environments whose byte is not 0.
  void reset(std::span<const std::uint8_t> mask);
  /// Every word of every environment.
  std::vector<std::uint64_t> save() const { return pool_.save(); }
  /// @throws Error if `words` are not of these environments; nothing has then changed
  void restore(std::span<const std::uint64_t> words);

 private:
  static std::ptrdiff_t offset(int env, int width) { return std::ptrdiff_t{env} * width; }
  void read_observations();

  Pool pool_;
  int observation_size_, privileged_size_;
  std::shared_ptr<const Batch> batch_;
  const float *observation_ = nullptr, *privileged_ = nullptr;
  std::vector<float> own_observation_, own_privileged_;  ///< storage if no batch has them
};

}  // namespace skybody::learn
