// `gradient` with images: the gradient of their networks, and learning from pixels alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <set>

#include "core/assemble/compile_scenario.h"
#include "core/io/files/policy_writer.h"
#include "core/policy/network_policy.h"
#include "learn/gradient/gradient.h"
#include "learn/make_learner.h"
#include "tests/unit/learn/isas.h"

namespace skybody::learn {
namespace {

using ::testing::HasSubstr;
using Overrides = std::vector<std::string>;

const Overrides kEye = {"sensors=[{plugin: image_sensor, name: eye}]"};

LoadOptions scenario(const std::string& observe, const Overrides& more = {}) {
  LoadOptions options = {"hover_learn", kEye, {SKYBODY_BINARY_DIR "/tests/plugins/images"}};
  options.overrides.push_back("observe=" + observe);
  options.overrides.insert(options.overrides.end(), more.begin(), more.end());
  return options;
}

/// Grey levels follow the physics step alone, depths and ranges the height.
constexpr const char* kAll =
    "[eye.grey, eye.depth, eye.range, {channel: eye.height, privileged: true}]";

LearnerOptions options(int threads = 1) {
  LearnerOptions o;
  o.seed = 3;
  o.total_steps = 100000;
  o.threads = threads;
  o.hyper.envs = 20;
  o.hyper.rollout_steps = 6;
  o.hyper.hidden = {16};
  o.hyper.reward_weight = 0.5;
  o.hyper.end_value_weight = 0.5;
  o.hyper.value_epochs = 2;
  o.hyper.cnn_channels = {8};
  o.hyper.cnn_kernels = {2};
  o.hyper.cnn_strides = {3};
  o.hyper.cnn_features = 10;
  return o;
}

std::unique_ptr<Learner> learner(const LearnerOptions& o, const LoadOptions& of = scenario(kAll)) {
  return make_learner(Algorithm::kGradient, of, o);
}

std::uint64_t hash_after(Learner& learner, int iterations) {
  for (int k = 0; k < iterations; ++k) learner.iterate();
  return learner.parameter_hash();
}

std::string message_of(const LearnerOptions& o, const LoadOptions& of) {
  try {
    learner(o, of);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(ImageGradient, HasTheSameBitsOnAnyNumberOfThreads) {
  const std::uint64_t one = hash_after(*learner(options(1)), 3);
  EXPECT_EQ(hash_after(*learner(options(2)), 3), one);
  EXPECT_EQ(hash_after(*learner(options(4)), 3), one);
}

TEST(ImageGradient, HasTheSameBitsOnEverySetWithFusedMultiplyAdd) {
  const std::vector<Isa> sets = fused_isas();
  if (sets.size() < 2) GTEST_SKIP() << "this machine has " << machine_isas();
  std::set<std::uint64_t> hashes;
  for (const Isa isa : sets) {
    const ChosenIsa chosen(isa);
    hashes.insert(hash_after(*learner(options()), 3));
  }
  EXPECT_EQ(hashes.size(), 1u);
}

TEST(ImageGradient, GoesOnFromItsStateWithTheSameBits) {
  const auto whole = learner(options(2)), resumed = learner(options(1));
  hash_after(*whole, 2);
  resumed->iterate();  // after any history
  resumed->restore(whole->state());
  EXPECT_EQ(hash_after(*resumed, 3), hash_after(*whole, 3));
}

TEST(ImageGradient, GivesAPolicyThatSeesTheImagesOfASimulation) {
  const auto trained = learner(options());
  trained->iterate();
  const PolicyFile policy = trained->policy();
  ASSERT_EQ(policy.images.size(), 3u);
  EXPECT_EQ(policy.images[0].column, "eye.grey");
  EXPECT_EQ(policy.layers[0].inputs, policy.observation_size + 30);
  EXPECT_EQ(policy.mean.size(), static_cast<std::size_t>(policy.observation_size));

  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "seen.h5";
  write_policy(file, policy, 3);
  NetworkPolicy flown(file), in_memory(policy);
  const auto compiled = compile_scenario(scenario(kAll));
  EXPECT_EQ(flown.check_fits(*compiled), "");
  Simulation simulation(compiled, 3, 0);
  simulation.reset();
  std::vector<float> action(static_cast<std::size_t>(policy.action_size)), other(action);
  for (int step = 0; step < 3; ++step) {
    flown.act(simulation, action);
    in_memory.act(simulation, other);
    EXPECT_EQ(action, other) << "the file keeps every weight";
    simulation.step(action);
  }
}

// --- finite differences -------------------------------------------------------------------------

/// Cost of some flights whose images do not depend on the motion: with pixels that count as given,
/// the gradient is then that of the whole cost. The policy does not see a column in the middle of
/// the task's, so that its inputs are not the task's values in order.
class FrozenImages : public ::testing::Test {
 protected:
  static constexpr int kEnvs = 5;

  FrozenImages()
      : compiled(compile_scenario(scenario("[eye.grey, {channel: task.velocity, privileged: true}]",
                                           {"stepping.dt=0.005", "stepping.action_repeat=4"}))),
        seen(static_cast<std::size_t>(compiled->observation_size())),
        network({compiled->observation_size(), {kGrey}}, compiled->action_size(), hyper(), 0,
                best_isa()),
        parameters(network.parameter_count()),
        mean(seen, 0.1),
        scale(seen, 0.8),
        slice(compiled, hyper(), network, 2, 0, kEnvs, nullptr, nullptr) {
    network.initialize(parameters, 0.3, 1, 0);
  }
  static Hyperparameters hyper() {
    Hyperparameters h = options().hyper;
    h.envs = kEnvs;
    h.rollout_steps = 4;
    h.goal_weight = 0.0;
    h.reward_weight = 1.0;
    h.end_value_weight = 0.0;
    h.cnn_channels = {4, 6};
    h.cnn_kernels = {6, 3};
    h.cnn_strides = {4, 2};
    return h;
  }
  /// Flies from the start again. @returns the negative mean reward
  double objective() {
    GradientSlice again(compiled, hyper(), network, 2, 0, kEnvs, nullptr, &slice);
    fly(again);
    double sum = 0.0;
    const auto take = [&](const std::string& name, const auto* values, std::size_t count) {
      if (name == "slice.returns") sum = std::accumulate(values, values + count, 0.0);
    };
    GradientSlice::visit(again, "slice", take);
    return -sum / (kEnvs * 4);
  }
  void fly(GradientSlice& flown) {
    PolicyNetwork::Transposed transposed;
    network.transpose(parameters, transposed);
    flown.run({parameters, &transposed, mean, scale, 1000});
  }

  static constexpr ImageFormat kGrey = {PixelType::kUint8, 36, 40, 1, 0.0f, 255.0f};
  std::shared_ptr<const CompiledScenario> compiled;
  std::size_t seen;
  PolicyNetwork network;
  std::vector<float> parameters;
  std::vector<double> mean, scale;
  GradientSlice slice;
};

TEST_F(FrozenImages, GiveTheirNetworkTheDifferencesOfTheCost) {
  fly(slice);
  const std::vector<float> gradient(slice.gradient().begin(), slice.gradient().end());
  const ImageEncoder encoder(kGrey, encoder_shape(hyper()), best_isa());
  int compared = 0;
  std::size_t first = 0;
  for (const std::size_t end : {encoder.parameter_count() / 8, encoder.parameter_count()}) {
    double largest = 0.0;
    for (std::size_t k = first; k < end; ++k) {
      largest = std::max(largest, std::abs(static_cast<double>(gradient[k])));
    }
    ASSERT_GT(largest, 0.0);
    int here = 0;
    for (std::size_t k = first; k < end && here < 5; ++k) {
      if (std::abs(static_cast<double>(gradient[k])) < 0.5 * largest) continue;
      const float value = parameters[k];
      parameters[k] = value + 0x1p-7f;
      const double above = objective();
      parameters[k] = value - 0x1p-7f;
      const double below = objective();
      parameters[k] = value;
      EXPECT_NEAR(gradient[k], (above - below) / 0x1p-6, 0.03 * largest) << k;
      ++here;
    }
    compared += here;
    first = end;
  }
  EXPECT_GT(compared, 4);
}

// --- learning -----------------------------------------------------------------------------------

/// The height of the target is seen in the image alone: no column tells the height, and starts
/// differ in nothing else.
TEST(ImageGradient, LearnsToFlyToAHeightThatOnlyPixelsTell) {
  const Overrides starts = {"randomization.start.parameters.position_min=[0, 0, 0.5]",
                            "randomization.start.parameters.position_max=[0, 0, 2.5]",
                            "randomization.start.parameters.yaw_min=0",
                            "randomization.start.parameters.yaw_max=0",
                            "task.parameters.target=[0, 0, 1.5, 0]",
                            "stepping.horizon=96"};
  LearnerOptions o = options(2);
  o.hyper.envs = 64;
  o.hyper.rollout_steps = 24;
  o.hyper.learning_rate = 6e-3;
  o.hyper.max_grad_norm = 1.0;
  o.hyper.hidden = {32, 32};
  o.hyper.reward_weight = o.hyper.end_value_weight = 0.0;
  o.hyper.cnn_range = 3.0;
  o.hyper.cnn_strides = {1};
  o.total_steps = 64 * 24 * 150;
  const auto error_after = [&](const std::string& observe) {
    const auto trained = learner(o, scenario(observe, starts));
    double error = 0.0;
    for (int k = 0; k < 150; ++k) error = trained->iterate().position_error;
    return error;
  };
  const double seeing =
      error_after("[eye.range, {channel: task.position_error, privileged: true}]");
  const double blind = error_after("[{channel: task.position_error, privileged: true}]");
  EXPECT_LT(seeing, 0.5 * blind);
}

// --- bad input ----------------------------------------------------------------------------------

TEST(ImageGradient, RefusesImagesThatDoNotFitWithARemedy) {
  LearnerOptions o = options();
  o.hyper.cnn_kernels = {30};
  EXPECT_THAT(message_of(o, scenario(kAll)), HasSubstr("too small or large for its network"));
  o.hyper.cnn_kernels = {};
  EXPECT_THAT(message_of(o, scenario(kAll)),
              HasSubstr("cnn_channels, cnn_kernels and cnn_strides have 1, 0 and 1"));
  o = options();
  o.hyper.rollout_steps = 1000000;
  EXPECT_THAT(message_of(o, scenario(kAll, {"sensors.eye.parameters.width=512"})),
              HasSubstr("take fewer envs or rollout_steps"));
  o = options();
  EXPECT_THAT(message_of(o, scenario("[eye.grey, eye.height]")),
              HasSubstr("observe the task's own values"));
}

TEST(TrainingSteps, KeepTheSecondsOfObservedSensors) {
  const LearnerOptions o = options();
  const auto overrides = [&](const std::string& period) {
    const std::string given = "sensors=[{plugin: image_sensor, name: eye, parameters: {period: ";
    return training_overrides(*compile_scenario(scenario("[eye.grey]", {given + period + "}}]"})),
                              o.hyper);
  };
  EXPECT_THAT(overrides("10"), ::testing::Contains("sensors.eye.parameters.period=2"));
  try {
    overrides("7");
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(),
                 "`hover_learn`: `period` of the sensor `eye` is 7 physics steps of 0.001 s, which "
                 "are no whole number of the steps of 0.005 s in training: take another "
                 "hyper-parameter physics_steps, such as 0, the scenario's own steps");
  }
}

}  // namespace
}  // namespace skybody::learn
