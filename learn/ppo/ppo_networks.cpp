#include "learn/ppo/ppo_networks.h"

#include <algorithm>
#include <string>

#include "core/base/error.h"
#include "core/base/random.h"

namespace skybody::learn {
namespace {

constexpr double kPolicyGain = 0.01;  // the first actions are close to the middle
constexpr double kValueGain = 1.0;

std::size_t padded(std::size_t count) {
  return (count + Network::kPad - 1) / Network::kPad * Network::kPad;
}

void copy(std::span<const float> from, std::span<float> to, const char* what) {
  if (from.size() != to.size()) {
    throw Error(std::string(what) + " parameters are " + std::to_string(from.size()) +
                " floats; these networks have " + std::to_string(to.size()));
  }
  std::copy(from.begin(), from.end(), to.begin());
}

}  // namespace

PpoNetworks::PpoNetworks(const AgentTable& agents, const Hyperparameters& hyper, Isa isa)
    : policy_(agents.observation_size(), agents.action_size(), hyper, isa),
      value_(
          {agents.observation_size() + agents.privileged_size(), hyper.hidden, 1, hyper.activation},
          isa),
      actions_(static_cast<std::size_t>(agents.action_size())),
      parameters_{AlignedArray<float>(padded(policy_.parameter_count() + actions_)),
                  AlignedArray<float>(padded(value_.parameter_count()))} {}

void PpoNetworks::initialize(std::uint64_t seed, double log_std_now) {
  policy_.initialize(policy_parameters().first(policy_.parameter_count()), kPolicyGain, seed,
                     derive_stream("learn.policy"));
  value_.initialize(value_parameters().first(value_.parameter_count()), kValueGain, seed,
                    derive_stream("learn.value"));
  const std::span<float> logs = log_std();
  std::fill(logs.begin(), logs.end(), static_cast<float>(log_std_now));
  policy_changed();
  value_changed();
}

void PpoNetworks::set(std::span<const float> policy, std::span<const float> value) {
  copy(policy, policy_parameters(), "the policy's");
  copy(value, value_parameters(), "the value function's");
  policy_changed();
  value_changed();
}

void PpoNetworks::policy_changed() { policy_.transpose(policy_weights(), policy_transposed_); }

void PpoNetworks::value_changed() { value_.transpose(value_weights(), value_transposed_); }

}  // namespace skybody::learn
