#include "learn/rollout/rollout_environments.h"

#include <utility>

#include "learn/network/product.h"

namespace skybody::learn {
namespace {

PoolOptions whole_steps(PoolOptions options) {
  options.batch = 0;
  options.autoreset = Autoreset::kSameStep;
  return options;
}

}  // namespace

RolloutEnvironments::RolloutEnvironments(std::shared_ptr<const CompiledScenario> compiled,
                                         PoolOptions options)
    : pool_(std::move(compiled), whole_steps(options)),
      observation_size_(pool_.compiled().observation_size()),
      privileged_size_(pool_.compiled().privileged_size()),
      own_observation_(product(pool_.envs(), observation_size_)),
      own_privileged_(product(pool_.envs(), privileged_size_)) {
  pool_.send_reset();
  pool_.recv();
  read_observations();
}

void RolloutEnvironments::step(std::span<const float> actions) {
  pool_.send(actions);
  batch_ = pool_.recv();
  observation_ = batch_->observation.data();
  privileged_ = batch_->privileged.data();
}

EpisodeEnd RolloutEnvironments::end_of(int env) const {
  const auto i = static_cast<std::size_t>(env);
  const bool is_terminated = batch_->terminated[i] != 0;
  if (!is_terminated && batch_->truncated[i] == 0) return EpisodeEnd::kNone;
  return is_terminated || batch_->fault[i] != 0 ? EpisodeEnd::kFinal : EpisodeEnd::kCut;
}

void RolloutEnvironments::reset(std::span<const std::uint8_t> mask) {
  pool_.send_reset(mask);
  pool_.recv();
  read_observations();
}

void RolloutEnvironments::restore(std::span<const std::uint64_t> words) {
  pool_.restore(words);
  read_observations();
}

void RolloutEnvironments::read_observations() {
  pool_.observations(own_observation_);
  pool_.privileged(own_privileged_);
  observation_ = own_observation_.data();
  privileged_ = own_privileged_.data();
  batch_.reset();
}

}  // namespace skybody::learn
