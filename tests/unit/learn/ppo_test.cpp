// fast-ppo as a whole: changes that must not affect the training result, and refused settings.
#include "learn/ppo/ppo.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/assemble/compile_scenario.h"
#include "core/base/math/hash.h"
#include "core/policy/network_policy.h"
#include "tests/unit/learn/isas.h"
#include "tests/unit/learn/small_team.h"

namespace skybody::learn {
namespace {

using test::small_options;
using test::small_team;

std::uint64_t hash_after(const LearnerOptions& options, int iterations) {
  Ppo ppo(options);
  for (int k = 0; k < iterations; ++k) ppo.iterate();
  return ppo.parameter_hash();
}

std::vector<double> numbers_of(const PolicyFile& policy) {
  std::vector<double> all = policy.mean;
  all.insert(all.end(), policy.scale.begin(), policy.scale.end());
  for (const PolicyLayer& layer : policy.layers) {
    all.insert(all.end(), layer.weight.begin(), layer.weight.end());
    all.insert(all.end(), layer.bias.begin(), layer.bias.end());
  }
  return all;
}

TEST(Ppo, LearnsTheSameBitsOnAnyNumberOfThreads) {
  LearnerOptions options = small_options(small_team());
  const std::uint64_t one = hash_after(options, 4);
  for (const int threads : {2, 3, 8}) {
    options.threads = threads;
    EXPECT_EQ(hash_after(options, 4), one) << threads << " threads";
  }
}

TEST(Ppo, LearnsOtherBitsFromAnotherSeed) {
  LearnerOptions options = small_options(small_team());
  const std::uint64_t one = hash_after(options, 1);
  options.seed = 8;
  EXPECT_NE(hash_after(options, 1), one);
}

TEST(Ppo, LearnsTheSameBitsOnEverySetWithFusedMultiplyAdd) {
  const std::vector<Isa> sets = fused_isas();
  if (sets.size() < 2) GTEST_SKIP() << "this machine has " << machine_isas();
  std::set<std::uint64_t> hashes;
  for (const Isa isa : sets) {
    const ChosenIsa chosen(isa);
    hashes.insert(hash_after(small_options(small_team()), 4));
  }
  EXPECT_EQ(hashes.size(), 1u);
}

/// A short training of hover_learn: two rollouts.
std::uint64_t hash_of_hover(const Sizes& hidden, Isa isa) {
  const ChosenIsa chosen(isa);
  LearnerOptions options;
  options.compiled = compile_scenario({"hover_learn", {}, {}});
  options.seed = 1;
  options.total_steps = 100000;
  options.threads = 2;
  options.hyper.envs = 40;
  options.hyper.rollout_steps = 12;
  options.hyper.minibatch = 160;
  options.hyper.bounded_mean = true;
  options.hyper.final_log_std = -2.7;
  options.hyper.hidden = hidden;
  return hash_after(options, 2);
}

/// A change of these hashes changes the training result of every seed: docs/golden_log.md lists it.
TEST(Ppo, LearnsTheGoldenBitsOfHoverOnEverySetWithFusedMultiplyAdd) {
  if (fused_isas().empty()) GTEST_SKIP() << "without fused multiply-add the last bits are others";
  for (const Isa isa : fused_isas()) {
    EXPECT_EQ(to_hex(hash_of_hover({64, 64}, isa)), "5244f2751896ea2f") << name(isa);
    EXPECT_EQ(to_hex(hash_of_hover({512, 512}, isa)), "884b5adb6ad461af") << name(isa);
  }
}

TEST(Ppo, GoesOnFromItsStateBitForBit) {
  const LearnerOptions options = small_options(small_team());
  Ppo whole(options);
  for (int k = 0; k < 3; ++k) whole.iterate();
  const LearnerState state = whole.state();
  for (int k = 0; k < 3; ++k) whole.iterate();

  Ppo resumed(options);
  resumed.iterate();  // after any history
  resumed.restore(state);
  EXPECT_EQ(resumed.steps(), 3 * 190);
  Report last;
  for (int k = 0; k < 3; ++k) last = resumed.iterate();
  EXPECT_EQ(last.steps, 6 * 190);
  EXPECT_EQ(resumed.parameter_hash(), whole.parameter_hash());
  EXPECT_EQ(numbers_of(resumed.policy()), numbers_of(whole.policy()));
  EXPECT_EQ(resumed.state().environments, whole.state().environments);
}

TEST(Ppo, RefusesTheStateOfAnotherLearnerAndStaysAsItWas) {
  const LearnerOptions options = small_options(small_team());
  LearnerOptions wider = options;
  wider.hyper.hidden = {24, 16};
  LearnerState state = Ppo(wider).state();
  Ppo ppo(options);
  ppo.iterate();
  const std::uint64_t before = ppo.parameter_hash();
  try {
    ppo.restore(state);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("another scenario's"));
  }
  state.blocks.clear();
  EXPECT_THROW(ppo.restore(state), Error);
  EXPECT_EQ(ppo.parameter_hash(), before);
}

TEST(Ppo, RefusesDamagedEnvironmentsOfAnySliceAndStaysAsItWas) {
  const LearnerOptions options = small_options(small_team());
  Ppo ppo(options), twin(options);
  ppo.iterate();
  const LearnerState good = ppo.state();
  twin.iterate();
  ppo.iterate();
  twin.iterate();
  const auto refuses = [&](const std::vector<std::uint64_t>& environments) {
    LearnerState state = good;
    state.environments = environments;
    EXPECT_THROW(ppo.restore(state), Error);
  };
  std::vector<std::uint64_t> damaged = good.environments;
  damaged.back() ^= 1;  // the last slice's checksum: the preceding slices are valid
  refuses(damaged);
  damaged = good.environments;
  damaged.pop_back();
  refuses(damaged);
  damaged = good.environments;
  damaged.push_back(0);
  refuses(damaged);
  ppo.iterate();
  twin.iterate();
  EXPECT_EQ(ppo.parameter_hash(), twin.parameter_hash());
  EXPECT_EQ(ppo.state().environments, twin.state().environments);
}

class Sizes15 : public testing::TestWithParam<int> {};

TEST_P(Sizes15, AnyNumberOfEnvironmentsWillDo) {
  LearnerOptions options = small_options(small_team());
  options.hyper.envs = GetParam();
  options.hyper.minibatch = std::min(48, 10 * GetParam());
  const std::uint64_t one = hash_after(options, 2);
  options.threads = 3;
  EXPECT_EQ(hash_after(options, 2), one);
}

INSTANTIATE_TEST_SUITE_P(Ppo, Sizes15, testing::Values(1, 3, 8, 15, 33),
                         testing::PrintToStringParamName());

TEST(Ppo, TellsOfARolloutWhatHappenedInIt) {
  Ppo ppo(small_options(small_team()));
  Report report = ppo.iterate();
  EXPECT_EQ(report.steps, 190);
  EXPECT_GT(report.position_error, 0.0);
  EXPECT_LT(report.position_error, 1.2);
  EXPECT_EQ(report.faults, 0);
  report = ppo.iterate();  // 20 steps: every episode of 12 has ended once
  EXPECT_GE(report.episode_returns.size(), 10u);
  for (const float value : report.episode_returns) EXPECT_LT(value, 0.0f);
  for (const auto& [name, value] : report.losses) EXPECT_TRUE(std::isfinite(value)) << name;
}

TEST(Ppo, LearnsNothingFromFaults) {
  LearnerOptions options = small_options(small_team<true>());
  Ppo ppo(options);
  std::int64_t faults = 0;
  for (int k = 0; k < 6; ++k) {
    const Report report = ppo.iterate();
    faults += report.faults;
    EXPECT_TRUE(std::isfinite(report.position_error));
    for (const float value : report.episode_returns) EXPECT_TRUE(std::isfinite(value));
    for (const auto& [name, value] : report.losses) EXPECT_TRUE(std::isfinite(value)) << name;
  }
  EXPECT_GT(faults, 0);
  for (const double x : numbers_of(ppo.policy())) ASSERT_TRUE(std::isfinite(x));
}

TEST(Ppo, BringsTheRewardUp) {
  LearnerOptions options = small_options(small_team());
  options.hyper.envs = 64;
  options.hyper.rollout_steps = 16;
  options.hyper.minibatch = 256;
  options.hyper.learning_rate = 3e-3;
  options.hyper.value_epochs = 5;
  options.hyper.epochs = 3;
  options.total_steps = 60 * 64 * 16;
  Ppo ppo(options);
  const auto mean_return = [&](int iterations) {
    double sum = 0.0, count = 0.0;
    for (int k = 0; k < iterations; ++k) {
      for (const float r : ppo.iterate().episode_returns) sum += static_cast<double>(r), count += 1;
    }
    return sum / count;
  };
  const double first = mean_return(4);
  mean_return(50);
  EXPECT_GT(mean_return(6), 0.8 * first) << "from " << first;  // returns are negative
}

TEST(Ppo, AveragesThePolicyThatItGives) {
  LearnerOptions options = small_options(small_team());
  options.hyper.averaging_steps = 1e9;  // the plain mean
  Ppo averaged(options);
  options.hyper.averaging_steps = 0.0;
  Ppo last(options);
  std::vector<double> mean;
  constexpr int kIterations = 3;
  for (int k = 0; k < kIterations; ++k) {
    averaged.iterate();
    last.iterate();
    const std::vector<double> bias = last.policy().layers.back().bias;
    mean.resize(bias.size());
    for (std::size_t i = 0; i < bias.size(); ++i) mean[i] += bias[i] / kIterations;
  }
  EXPECT_EQ(averaged.parameter_hash(), last.parameter_hash());
  const std::vector<double> bias = averaged.policy().layers.back().bias;
  for (std::size_t i = 0; i < bias.size(); ++i) {
    EXPECT_NEAR(bias[i], mean[i], 1e-8) << i;  // float rounding of values below 0.1
  }
}

TEST(Ppo, RefusesWhatDoesNotFitTogether) {
  const auto refusal = [](auto change) {
    LearnerOptions options = small_options(small_team());
    change(options.hyper);
    try {
      Ppo ppo(options);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(refusal([](Hyperparameters& h) { h.minibatch = 191; }),
              testing::HasSubstr("minibatch = 191: allowed is 2 to the rows of a rollout, 190"));
  EXPECT_THAT(refusal([](Hyperparameters& h) { h.squashed = h.bounded_mean = true; }),
              testing::HasSubstr("squashed and bounded_mean exclude one another"));
}

TEST(Ppo, GivesASharedPolicyThatFliesEachRobotByItsOwnColumns) {
  LearnerOptions options = small_options(small_team());
  options.hyper.shared_policy = true;
  Ppo ppo(options);
  ppo.iterate();
  NetworkPolicy policy(ppo.policy());
  EXPECT_EQ(policy.check_fits(*options.compiled), "");
  // Target, then height and speed of each robot.
  const std::vector<float> seen = {1.2f, 0.8f, 0.1f, 1.4f, -0.3f};
  const std::vector<float> swapped = {1.2f, 1.4f, -0.3f, 0.8f, 0.1f};
  std::vector<float> action(8), after_swap(8);
  policy.act(seen, action);
  policy.act(swapped, after_swap);
  std::rotate(after_swap.begin(), after_swap.begin() + 4, after_swap.end());
  EXPECT_EQ(action, after_swap);
  EXPECT_NE(std::vector(action.begin(), action.begin() + 4),
            std::vector(action.begin() + 4, action.end()));
}

TEST(Ppo, KeepsActionsWithinBoundsWhereTheyAreSquashed) {
  LearnerOptions options = small_options(small_team());
  options.hyper.squashed = true;
  options.hyper.log_std = 1.0;  // most draws are beyond 1
  Ppo ppo(options);
  ppo.iterate();
  EXPECT_EQ(ppo.policy().squash, ActionSquash::kTanh);
  options.hyper.squashed = false;
  options.hyper.bounded_mean = true;
  Ppo bounded(options);
  bounded.iterate();
  EXPECT_EQ(bounded.policy().squash, ActionSquash::kClip);
  EXPECT_EQ(bounded.policy().layers.back().activation, Activation::kTanh);
}

}  // namespace
}  // namespace skybody::learn
