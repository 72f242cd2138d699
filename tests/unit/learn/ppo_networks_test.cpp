// The networks of PPO: after every change of parameters, the data that backward() reads are up to
// date.
#include "learn/ppo/ppo_networks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "learn/common/state_blocks.h"
#include "tests/unit/learn/small_team.h"

namespace skybody::learn {
namespace {

using test::small_team;

PpoNetworks small_networks(std::uint64_t seed) {
  Hyperparameters hyper;
  hyper.hidden = {24, 8};
  PpoNetworks networks(make_agent_table(*small_team(), false), {}, hyper, best_isa());
  networks.initialize(seed, -1.0);
  return networks;
}

std::vector<std::vector<float>> values_of(const TransposedWeights& weights) {
  std::vector<std::vector<float>> values;
  for (const AlignedArray<float>& layer : weights.layers) {
    values.emplace_back(layer.data(), layer.data() + layer.size());
  }
  return values;
}

void expect_ready(const PpoNetworks& networks, const char* after) {
  PolicyNetwork::Transposed fresh, value;
  networks.policy().transpose(networks.policy_weights(), fresh);
  networks.value().transpose(networks.value_weights(), value);
  EXPECT_EQ(values_of(networks.policy_transposed().dense), values_of(fresh.dense)) << after;
  EXPECT_EQ(values_of(networks.value_transposed().dense), values_of(value.dense)) << after;
}

TEST(PpoNetworks, AreReadyToComputeAfterEveryChangeOfTheirParameters) {
  PpoNetworks networks = small_networks(1);
  expect_ready(networks, "a beginning");
  const auto halve = [](std::span<float> parameters) {
    for (float& x : parameters) x *= 0.5f;
  };
  networks.change_policy(halve);
  expect_ready(networks, "a step of the policy");
  networks.change_value(halve);
  expect_ready(networks, "a step of the value function");
  const PpoNetworks other = small_networks(2);
  networks.set(other.policy_parameters(), other.value_parameters());
  expect_ready(networks, "another's parameters");
  StateBlocks blocks;
  StateWriter writer(blocks);
  const PpoNetworks third = small_networks(3);
  PpoNetworks::visit(third, writer);
  StateReader reader(blocks, StateReader::Mode::kCopy);
  PpoNetworks::visit(networks, reader);
  EXPECT_TRUE(std::ranges::equal(networks.policy_parameters(), third.policy_parameters()));
  EXPECT_TRUE(std::ranges::equal(networks.value_parameters(), third.value_parameters()));
  expect_ready(networks, "a checkpoint");
}

TEST(PpoNetworks, HoldDeviationsToTheirLimitsAndNothingElse) {
  PpoNetworks networks = small_networks(1);
  networks.change_policy([&](std::span<float> parameters) {
    const std::span<float> logs =
        parameters.subspan(networks.log_std_at(), networks.log_std().size());
    logs[0] = -3.0f;
    logs[1] = -1.5f;
    logs[2] = 0.5f;
  });
  const std::vector<float> weights(networks.policy_weights().begin(),
                                   networks.policy_weights().end());
  networks.limit_log_std(-2.0, -1.25);
  EXPECT_EQ(networks.log_std()[0], -2.0f);
  EXPECT_EQ(networks.log_std()[1], -1.5f);
  EXPECT_EQ(networks.log_std()[2], -1.25f);
  EXPECT_TRUE(std::ranges::equal(networks.policy_weights(), weights));
}

}  // namespace
}  // namespace skybody::learn
