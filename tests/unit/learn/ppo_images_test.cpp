// fast-ppo with images: an update sees the images of the rollout.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "core/assemble/compile_scenario.h"
#include "core/io/files/policy_writer.h"
#include "core/policy/network_policy.h"
#include "learn/ppo/ppo.h"
#include "tests/unit/learn/isas.h"

namespace skybody::learn {
namespace {

using ::testing::HasSubstr;

std::shared_ptr<const CompiledScenario> seeing(const std::string& observe) {
  return compile_scenario(
      {"hover_learn",
       {"stepping.horizon=17", "sensors=[{plugin: image_sensor, name: eye}]", "observe=" + observe},
       {SKYBODY_BINARY_DIR "/tests/plugins/images"}});
}

/// Images of all three types. Episodes of 17 steps, rollouts of 12: each begins and ends in the
/// middle of the other.
LearnerOptions options(const std::string& observe = "[eye.grey, eye.depth, eye.range]") {
  LearnerOptions result;
  result.compiled = seeing(observe);
  result.seed = 3;
  result.total_steps = 100000;
  result.threads = 1;
  result.hyper.envs = 20;
  result.hyper.rollout_steps = 12;
  result.hyper.minibatch = 60;
  result.hyper.hidden = {32};
  result.hyper.cnn_channels = {8};
  result.hyper.cnn_kernels = {2};
  result.hyper.cnn_strides = {3};
  result.hyper.cnn_features = 10;
  return result;
}

std::uint64_t hash_after(const LearnerOptions& how, int iterations) {
  Ppo ppo(how);
  for (int k = 0; k < iterations; ++k) ppo.iterate();
  return ppo.parameter_hash();
}

double loss_of(const Report& report, const std::string& name) {
  for (const auto& [key, value] : report.losses) {
    if (key == name) return value;
  }
  ADD_FAILURE() << "no loss " << name;
  return std::nan("");
}

std::string message_of(const LearnerOptions& how) {
  try {
    const Ppo ppo(how);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// Before the first step of an update the policy is the one that drew the actions. With the same
/// images the ratio of probabilities is one, up to the rounding of logarithms (1e-13).
TEST(ImagePpo, SeesInTheUpdateTheImagesThatItSawWhenItActed) {
  for (const int units : {0, 24}) {
    LearnerOptions how = options();
    how.hyper.recurrent_units = units;
    how.hyper.minibatch = 12 * 20;  // one step per update
    how.hyper.learning_rate = 1e-2;
    Ppo ppo(how);
    for (int iteration = 0; iteration < 5; ++iteration) {
      EXPECT_LT(std::abs(loss_of(ppo.iterate(), "kl")), 1e-10) << iteration;
    }
  }
}

TEST(ImagePpo, LearnsTheSameBitsOnAnyNumberOfThreads) {
  LearnerOptions how = options();
  const std::uint64_t one = hash_after(how, 3);
  for (const int threads : {2, 5}) {
    how.threads = threads;
    EXPECT_EQ(hash_after(how, 3), one) << threads;
  }
}

TEST(ImagePpo, LearnsTheSameBitsOnEverySetWithFusedMultiplyAdd) {
  const std::vector<Isa> sets = fused_isas();
  if (sets.size() < 2) GTEST_SKIP() << "this machine has " << machine_isas();
  std::vector<std::uint64_t> hashes;
  for (const Isa isa : sets) {
    const ChosenIsa chosen(isa);
    hashes.push_back(hash_after(options(), 3));
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(ImagePpo, GoesOnFromItsStateBitForBit) {
  Ppo whole(options());
  for (int k = 0; k < 2; ++k) whole.iterate();
  const LearnerState state = whole.state();
  for (int k = 0; k < 2; ++k) whole.iterate();
  Ppo resumed(options());
  resumed.iterate();  // after any history
  resumed.restore(state);
  for (int k = 0; k < 2; ++k) resumed.iterate();
  EXPECT_EQ(resumed.parameter_hash(), whole.parameter_hash());
}

TEST(ImagePpo, LearnsOtherwiseFromOtherImages) {
  EXPECT_NE(hash_after(options("[eye.grey]"), 2), hash_after(options("[eye.range]"), 2));
}

TEST(ImagePpo, HasAValueFunctionWithoutImagesIfAsked) {
  LearnerOptions how = options();
  how.hyper.value_images = false;
  Ppo ppo(how);
  EXPECT_TRUE(std::isfinite(loss_of(ppo.iterate(), "value_loss")));
  const PpoSetup setup(how);
  const PpoNetworks blind(setup.agents, setup.images, how.hyper, best_isa());
  how.hyper.value_images = true;
  const PpoNetworks seeing(setup.agents, setup.images, how.hyper, best_isa());
  EXPECT_LT(blind.value_weights().size(), seeing.value_weights().size());
  EXPECT_EQ(blind.policy_weights().size(), seeing.policy_weights().size());
}

TEST(ImagePpo, GivesAPolicyThatSeesTheImagesOfASimulation) {
  LearnerOptions how = options();
  Ppo ppo(how);
  ppo.iterate();
  const PolicyFile policy = ppo.policy();
  ASSERT_EQ(policy.images.size(), 3u);
  EXPECT_EQ(policy.images[0].column, "eye.grey");
  EXPECT_EQ(policy.images[1].layers.back().outputs, 10);
  EXPECT_EQ(policy.images[2].high, 100.0);
  EXPECT_EQ(policy.layers[0].inputs, policy.observation_size + 30);

  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "seeing.h5";
  write_policy(file, policy, 3);
  NetworkPolicy flown(file), in_memory(policy);
  EXPECT_EQ(flown.check_fits(*how.compiled), "");
  Simulation simulation(how.compiled, 3, 0);
  simulation.reset();
  std::vector<float> action(static_cast<std::size_t>(policy.action_size)), other(action);
  for (int step = 0; step < 3; ++step) {
    flown.act(simulation, action);
    in_memory.act(simulation, other);
    EXPECT_EQ(action, other) << "the file keeps every weight";
    simulation.step(action);
  }
  EXPECT_THROW(flown.check_fits(*seeing("[eye.depth, eye.range]")), Error);
}

TEST(ImagePpo, RefusesWhatItCannotLearnFromWithARemedy) {
  LearnerOptions how = options();
  how.hyper.cnn_kernels = {30};
  EXPECT_THAT(message_of(how), HasSubstr("eye.depth, too small or large for its network"));
  how = options();
  how.hyper.shared_policy = true;
  EXPECT_THAT(message_of(how), HasSubstr("set shared_policy=false"));
  how = options();
  how.hyper.envs = 1 << 20;
  how.hyper.rollout_steps = 1000;
  EXPECT_THAT(message_of(how), HasSubstr("take fewer envs or rollout_steps"));
  how = options();
  how.hyper.cnn_strides = {};
  EXPECT_THAT(message_of(how),
              HasSubstr("cnn_channels, cnn_kernels and cnn_strides have 1, 1 and 0"));
}

}  // namespace
}  // namespace skybody::learn
