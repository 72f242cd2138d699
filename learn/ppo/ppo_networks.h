// The two networks of PPO with their parameters.
#pragma once

#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "core/base/simd/isa.h"
#include "learn/common/seen_images.h"
#include "learn/hyperparameters.h"
#include "learn/network/policy_network.h"
#include "learn/ppo/agent_table.h"

namespace skybody::learn {

/// A policy, whose parameters end with the logarithms of the actions' deviations, and a value
/// function, which also observes privileged values, and has no memory. They share no parameters.
class PpoNetworks {
 public:
  PpoNetworks(const AgentTable& agents, const std::vector<SeenImage>& images,
              const Hyperparameters& hyper, Isa isa);

  /// Initializes all parameters. @param seed  of all random numbers
  void initialize(std::uint64_t seed, double log_std);
  /// Copies the parameters of another learner, and prepares computations with them.
  /// @param policy, value  in the layout of policy_parameters() and value_parameters()
  /// @throws Error if the number of values differs
  void set(std::span<const float> policy, std::span<const float> value);
  /// Change parameters in place, and prepare computations with them. Both functions may run at the
  /// same time.
  /// @param change  called with policy_parameters() or value_parameters(), writable
  template <class Change>
  void change_policy(Change&& change) {
    change(std::span<float>{parameters_[0].data(), parameters_[0].size()});
    prepare_policy();
  }
  template <class Change>
  void change_value(Change&& change) {
    change(std::span<float>{parameters_[1].data(), parameters_[1].size()});
    prepare_value();
  }
  /// Clamps every logarithm of a deviation to these limits.
  void limit_log_std(double least, double largest);

  /// Passes the checkpointed arrays to `visitor` (state_blocks.h), and prepares computations with
  /// the values that it has written. @param self  const or not
  template <class Self, class Visitor>
  static void visit(Self& self, Visitor& visitor) {
    visitor("policy", self.parameters_[0].data(), self.parameters_[0].size());
    visitor("value", self.parameters_[1].data(), self.parameters_[1].size());
    if constexpr (!std::is_const_v<Self>) {
      self.prepare_policy();
      self.prepare_value();
    }
  }

  const PolicyNetwork& policy() const { return policy_; }
  const PolicyNetwork& value() const { return value_; }
  /// Policy weights and biases, then log_std, padded().
  std::span<const float> policy_parameters() const {
    return {parameters_[0].data(), parameters_[0].size()};
  }
  std::span<const float> value_parameters() const {
    return {parameters_[1].data(), parameters_[1].size()};
  }
  /// The policy's weights and biases only.
  std::span<const float> policy_weights() const {
    return policy_parameters().first(policy_.parameter_count());
  }
  /// The value function's weights and biases only.
  std::span<const float> value_weights() const {
    return value_parameters().first(value_.parameter_count());
  }
  /// Logarithm of each action's standard deviation.
  std::span<const float> log_std() const {
    return policy_parameters().subspan(log_std_at(), actions_);
  }
  std::size_t log_std_at() const { return policy_.parameter_count(); }
  const PolicyNetwork::Transposed& policy_transposed() const { return policy_transposed_; }
  const PolicyNetwork::Transposed& value_transposed() const { return value_transposed_; }

 private:
  void prepare_policy();
  void prepare_value();

  PolicyNetwork policy_, value_;
  std::size_t actions_;
  AlignedArray<float> parameters_[2];
  PolicyNetwork::Transposed policy_transposed_, value_transposed_;
};

}  // namespace skybody::learn
