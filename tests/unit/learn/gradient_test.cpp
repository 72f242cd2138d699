// Guarantees of the learner `gradient`.
#include "learn/gradient/gradient.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/assemble/compile_scenario.h"
#include "core/base/system/error.h"
#include "learn/make_learner.h"
#include "tests/unit/learn/isas.h"

namespace skybody::learn {
namespace {

std::shared_ptr<const CompiledScenario> load(const std::vector<std::string>& overrides = {}) {
  LoadOptions options;
  options.scenario = "hover_learn";
  options.overrides = overrides;
  return compile_scenario(options);
}

LearnerOptions options(int threads) {
  LearnerOptions o;
  o.compiled = load();
  o.hyper.envs = 40;  // slices of five
  o.hyper.rollout_steps = 8;
  o.hyper.hidden = {16, 16};
  o.seed = 3;
  o.total_steps = 40 * 8 * 40;
  o.threads = threads;
  return o;
}

AnalyticGradientLearner gradient(const LearnerOptions& o) {
  return AnalyticGradientLearner(o, load(training_overrides(*o.compiled, o.hyper)));
}

std::uint64_t hash_after(Learner& learner, int iterations) {
  for (int i = 0; i < iterations; ++i) learner.iterate();
  return learner.parameter_hash();
}

TEST(AnalyticGradientLearner, GivesTheSameBitsOnAnyNumberOfThreads) {
  AnalyticGradientLearner one = gradient(options(1));
  AnalyticGradientLearner three = gradient(options(3));
  EXPECT_EQ(hash_after(one, 12), hash_after(three, 12));
  EXPECT_EQ(one.state().environments, three.state().environments);
}

/// A change of these hashes changes the training result of every seed: docs/golden_log.md lists it.
TEST(AnalyticGradientLearner, LearnsTheGoldenBitsOfHoverOnEverySetWithFusedMultiplyAdd) {
  if (fused_isas().empty()) GTEST_SKIP() << "without fused multiply-add the last bits are others";
  for (const Isa isa : fused_isas()) {
    const ChosenIsa chosen(isa);
    AnalyticGradientLearner learner = gradient(options(2));
    EXPECT_EQ(hash_after(learner, 12), 1789269190563457361ull) << name(isa);
  }
}

TEST(AnalyticGradientLearner, WithAValueFunctionLearnsTheSameBitsOnEverySetWithFusedMultiplyAdd) {
  const std::vector<Isa> sets = fused_isas();
  if (sets.size() < 2) GTEST_SKIP() << "this machine has " << machine_isas();
  std::set<std::uint64_t> hashes;
  for (const Isa isa : sets) {
    const ChosenIsa chosen(isa);
    LearnerOptions o = options(2);
    o.hyper.reward_weight = 0.5;
    o.hyper.end_value_weight = 1.0;
    o.hyper.activation = Activation::kElu;
    AnalyticGradientLearner learner = gradient(o);
    hashes.insert(hash_after(learner, 6));
  }
  EXPECT_EQ(hashes.size(), 1u);
}

TEST(AnalyticGradientLearner, GoesOnFromItsStateWithTheSameBits) {
  AnalyticGradientLearner whole = gradient(options(2));
  whole.iterate();
  hash_after(whole, 4);
  const LearnerState middle = whole.state();
  AnalyticGradientLearner resumed = gradient(options(1));
  resumed.restore(middle);
  EXPECT_EQ(resumed.steps(), whole.steps());
  EXPECT_EQ(hash_after(resumed, 6), hash_after(whole, 6));
}

TEST(AnalyticGradientLearner,
     WithAValueFunctionHasTheSameBitsOnAnyNumberOfThreadsAndAfterARestore) {
  const auto with_value = [](int threads) {
    LearnerOptions o = options(threads);
    o.hyper.reward_weight = 0.5;
    o.hyper.end_value_weight = 1.0;
    o.hyper.value_epochs = 2;
    o.hyper.averaging_steps = 1000;
    return o;
  };
  AnalyticGradientLearner one = gradient(with_value(1)), three = gradient(with_value(3));
  AnalyticGradientLearner resumed = gradient(with_value(2));
  EXPECT_EQ(hash_after(one, 6), hash_after(three, 6));
  resumed.restore(three.state());
  EXPECT_EQ(hash_after(resumed, 5), hash_after(one, 5));
  EXPECT_EQ(resumed.policy().layers[0].weight, one.policy().layers[0].weight);
  AnalyticGradientLearner without = gradient(options(1));
  EXPECT_NE(hash_after(without, 11), one.parameter_hash());
}

TEST(AnalyticGradientLearner, RefusesAnotherLearnersState) {
  AnalyticGradientLearner learner = gradient(options(1));
  LearnerState state = learner.state();
  state.environments.pop_back();
  EXPECT_THROW(learner.restore(state), Error);
  state = learner.state();
  state.blocks.pop_back();
  EXPECT_THROW(learner.restore(state), Error);
}

TEST(AnalyticGradientLearner, BringsTheVehicleNearerToItsTarget) {
  LearnerOptions o = options(2);
  o.hyper.envs = 64;
  o.hyper.rollout_steps = 24;
  o.hyper.learning_rate = 6e-3;
  o.hyper.max_grad_norm = 1.0;
  o.hyper.hidden = {32, 32};
  o.total_steps = 64 * 24 * 120;
  AnalyticGradientLearner learner = gradient(o);
  const double before = learner.iterate().position_error;
  for (int i = 0; i < 118; ++i) learner.iterate();
  EXPECT_LT(learner.iterate().position_error, 0.6 * before);
}

/// A different number of `physics_steps` would otherwise be trained with silently.
TEST(AnalyticGradientLearner, RefusesAScenarioThatIsNotTheOneToTrainIn) {
  const LearnerOptions o = options(1);
  try {
    AnalyticGradientLearner(o, o.compiled);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(),
                 "`hover_learn` is to be trained in with 20 physics steps of 0.001 s an action, "
                 "and physics_steps = 4 asks for 4 of 0.005 s: compile it with "
                 "training_overrides(), as make_learner() does");
  }
}

TEST(MakeLearner, TrainsInTheLongerPhysicsStepsThatGradientAsksFor) {
  const LearnerOptions o = options(1);
  AnalyticGradientLearner by_hand = gradient(o);
  LoadOptions scenario;
  scenario.scenario = "hover_learn";
  const auto made = make_learner(Algorithm::kGradient, scenario, o);
  EXPECT_EQ(hash_after(*made, 2), hash_after(by_hand, 2));
  LearnerOptions own_steps = o;
  own_steps.hyper.physics_steps = 0;
  const auto other = make_learner(Algorithm::kGradient, scenario, own_steps);
  EXPECT_NE(hash_after(*other, 2), by_hand.parameter_hash());
}

TEST(MakeLearner, CompilesAScenarioThatItIsNotGivenAndKeepsItsOverrides) {
  LoadOptions scenario;
  scenario.scenario = "hover_learn";
  scenario.overrides = {"stepping.horizon=77"};
  LearnerOptions o = options(1);
  o.compiled = load(scenario.overrides);
  for (const Algorithm algorithm : {Algorithm::kFastPpo, Algorithm::kGradient}) {
    o.hyper.minibatch = 64;
    const auto given = make_learner(algorithm, scenario, o);
    LearnerOptions alone = o;
    alone.compiled = nullptr;
    const auto compiled = make_learner(algorithm, scenario, alone);
    EXPECT_EQ(hash_after(*compiled, 1), hash_after(*given, 1));
    EXPECT_EQ(compiled->policy().scenario_hash, given->policy().scenario_hash);
    EXPECT_EQ(compiled->policy().algorithm, given->policy().algorithm);
  }
  o.hyper.rollout_steps = 0;
  EXPECT_THROW(make_learner(Algorithm::kGradient, scenario, o), Error);
}

TEST(AnalyticGradientLearner, LengthensPhysicsStepsAndKeepsAnActionsTime) {
  Hyperparameters hyper;
  hyper.physics_steps = 4;
  const std::vector<std::string> expected = {"stepping.dt=0.005", "stepping.action_repeat=4"};
  EXPECT_EQ(training_overrides(*load(), hyper), expected);
  hyper.physics_steps = 0;
  EXPECT_TRUE(training_overrides(*load(), hyper).empty());
}

}  // namespace
}  // namespace skybody::learn
