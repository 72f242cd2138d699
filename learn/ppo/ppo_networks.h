// The two networks of PPO with their parameters.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/aligned_array.h"
#include "core/base/isa.h"
#include "learn/hyperparameters.h"
#include "learn/network/network.h"
#include "learn/ppo/agent_table.h"
#include "learn/ppo/policy_network.h"

namespace skybody::learn {

/// A policy, whose parameters end with the logarithms of the actions' deviations, and a value
/// function, which also sees what is privileged. They share nothing.
class PpoNetworks {
 public:
  PpoNetworks(const AgentTable& agents, const Hyperparameters& hyper, Isa isa);

  /// Fresh ones. @param seed  of all random numbers
  void initialize(std::uint64_t seed, double log_std);
  /// Another learner's: copies both arrays, and makes ready to compute.
  /// @param policy, value  as policy_parameters() and value_parameters() are
  /// @throws Error on another number of values
  void set(std::span<const float> policy, std::span<const float> value);
  /// To be called after parameters were changed in place.
  void policy_changed();
  void value_changed();

  const PolicyNetwork& policy() const { return policy_; }
  const Network& value() const { return value_; }
  /// Policy weights and biases, then log_std, padded to a multiple of 16 floats.
  std::span<float> policy_parameters() { return {parameters_[0].data(), parameters_[0].size()}; }
  std::span<const float> policy_parameters() const {
    return {parameters_[0].data(), parameters_[0].size()};
  }
  std::span<float> value_parameters() { return {parameters_[1].data(), parameters_[1].size()}; }
  std::span<const float> value_parameters() const {
    return {parameters_[1].data(), parameters_[1].size()};
  }
  /// The policy's weights and biases alone.
  std::span<const float> policy_weights() const {
    return policy_parameters().first(policy_.parameter_count());
  }
  /// The value function's, likewise.
  std::span<const float> value_weights() const {
    return value_parameters().first(value_.parameter_count());
  }
  /// Logarithm of each action's standard deviation.
  std::span<float> log_std() { return policy_parameters().subspan(log_std_at(), actions_); }
  std::span<const float> log_std() const {
    return policy_parameters().subspan(log_std_at(), actions_);
  }
  std::size_t log_std_at() const { return policy_.parameter_count(); }
  const PolicyNetwork::Transposed& policy_transposed() const { return policy_transposed_; }
  const TransposedWeights& value_transposed() const { return value_transposed_; }

 private:
  PolicyNetwork policy_;
  Network value_;
  std::size_t actions_;
  AlignedArray<float> parameters_[2];
  PolicyNetwork::Transposed policy_transposed_;
  TransposedWeights value_transposed_;
};

}  // namespace skybody::learn
