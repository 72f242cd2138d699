#include "learn/ppo/ppo_networks.h"

#include <algorithm>
#include <string>

#include "core/base/math/random.h"
#include "core/base/system/error.h"

namespace skybody::learn {
namespace {

constexpr double kPolicyGain = 0.01;  // the first actions are close to the middle
constexpr double kValueGain = 1.0;

void copy(std::span<const float> from, std::span<float> to, const char* what) {
  if (from.size() != to.size()) {
    throw Error(std::string(what) + " parameters are " + std::to_string(from.size()) +
                " floats; these networks have " + std::to_string(to.size()));
  }
  std::copy(from.begin(), from.end(), to.begin());
}

}  // namespace

PpoNetworks::PpoNetworks(const AgentTable& agents, const std::vector<SeenImage>& images,
                         const Hyperparameters& hyper, Isa isa)
    : policy_({agents.observation_size(), formats_of(images)}, agents.action_size(), hyper,
              hyper.recurrent_units, isa),
      value_({agents.observation_size() + agents.privileged_size(),
              hyper.value_images ? formats_of(images) : std::vector<ImageFormat>()},
             1, hyper, 0, isa),
      actions_(static_cast<std::size_t>(agents.action_size())),
      parameters_{AlignedArray<float>(padded(policy_.parameter_count() + actions_)),
                  AlignedArray<float>(padded(value_.parameter_count()))} {}

void PpoNetworks::initialize(std::uint64_t seed, double log_std_now) {
  change_policy([&](std::span<float> parameters) {
    policy_.initialize(parameters.first(policy_.parameter_count()), kPolicyGain, seed,
                       derive_stream("learn.policy"));
    const std::span<float> logs = parameters.subspan(log_std_at(), actions_);
    std::fill(logs.begin(), logs.end(), static_cast<float>(log_std_now));
  });
  change_value([&](std::span<float> parameters) {
    value_.initialize(parameters.first(value_.parameter_count()), kValueGain, seed,
                      derive_stream("learn.value"));
  });
}

void PpoNetworks::set(std::span<const float> policy, std::span<const float> value) {
  change_policy([&](std::span<float> parameters) { copy(policy, parameters, "the policy's"); });
  change_value(
      [&](std::span<float> parameters) { copy(value, parameters, "the value function's"); });
}

void PpoNetworks::limit_log_std(double least, double largest) {
  change_policy([&](std::span<float> parameters) {
    for (float& value : parameters.subspan(log_std_at(), actions_)) {
      value = static_cast<float>(std::min(std::max(static_cast<double>(value), least), largest));
    }
  });
}

void PpoNetworks::prepare_policy() { policy_.transpose(policy_weights(), policy_transposed_); }

void PpoNetworks::prepare_value() { value_.transpose(value_weights(), value_transposed_); }

}  // namespace skybody::learn
