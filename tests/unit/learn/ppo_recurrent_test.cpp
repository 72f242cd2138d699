// fast-ppo with a recurrent policy: an update sees the observations and memory of the rollout.
#include <gtest/gtest.h>

#include <cmath>

#include "core/assemble/compile_scenario.h"
#include "learn/common/slice_plan.h"
#include "learn/ppo/ppo.h"
#include "tests/unit/learn/isas.h"

namespace skybody::learn {
namespace {

/// Episodes of 17 steps, rollouts of 12: each begins and ends in the middle of the other.
LearnerOptions options(const Sizes& hidden = {32}) {
  LearnerOptions result;
  result.compiled = compile_scenario({"hover_learn", {"stepping.horizon=17"}, {}});
  result.seed = 3;
  result.total_steps = 100000;
  result.threads = 1;
  result.hyper.envs = 20;
  result.hyper.rollout_steps = 12;
  result.hyper.minibatch = 60;
  result.hyper.hidden = hidden;
  result.hyper.recurrent_units = 24;
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

/// Before the first step of an update the policy is the one that drew the actions. With the same
/// observations and memory, the ratio of probabilities is one. Means are floats near 1, from which
/// noise of deviation e^-1 makes logarithms: the divergence is of the order of 1e-13.
TEST(RecurrentPpo, RecallsInTheUpdateWhatItRememberedWhenItActed) {
  LearnerOptions how = options();
  how.hyper.minibatch = 12 * 20;  // one step per update
  how.hyper.learning_rate = 1e-2;
  Ppo ppo(how);
  for (int iteration = 0; iteration < 6; ++iteration) {
    EXPECT_LT(std::abs(loss_of(ppo.iterate(), "kl")), 1e-10) << iteration;
  }
}

TEST(RecurrentPpo, DivergesFromThePolicyThatDrewWhileItLearns) {
  LearnerOptions how = options();
  how.hyper.learning_rate = 1e-2;
  Ppo ppo(how);
  EXPECT_GT(loss_of(ppo.iterate(), "kl"), 1e-6);
}

TEST(RecurrentPpo, LearnsTheSameBitsOnAnyNumberOfThreads) {
  LearnerOptions how = options();
  const std::uint64_t one = hash_after(how, 3);
  for (const int threads : {2, 5}) {
    how.threads = threads;
    EXPECT_EQ(hash_after(how, 3), one) << threads;
  }
}

TEST(RecurrentPpo, LearnsTheSameBitsOnEverySetWithFusedMultiplyAdd) {
  const std::vector<Isa> sets = fused_isas();
  if (sets.size() < 2) GTEST_SKIP() << "this machine has " << machine_isas();
  std::vector<std::uint64_t> hashes;
  for (const Isa isa : sets) {
    const ChosenIsa chosen(isa);
    hashes.push_back(hash_after(options(), 3));
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(RecurrentPpo, GoesOnFromItsStateBitForBit) {
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

TEST(RecurrentPpo, GivesAPolicyWithARecurrentLayer) {
  Ppo ppo(options({}));
  ppo.iterate();
  const PolicyFile policy = ppo.policy();
  ASSERT_EQ(policy.layers.size(), 2u);
  EXPECT_EQ(policy.layers[0].kind, LayerKind::kGru);
  EXPECT_EQ(policy.layers[0].outputs, 24);
  EXPECT_EQ(policy.layers[1].inputs, 24);
}

TEST(SlicePlan, KeepsRowsOfASequenceTogetherAndLeavesNoMinibatchEmpty) {
  for (const int envs : {1, 7, 8, 20, 33}) {
    for (const int minibatch : {2, 60, 240}) {
      const SlicePlan plan(envs, 12 * 2, minibatch, 12);
      for (int m = 0; m < plan.minibatches(); ++m) {
        EXPECT_GT(plan.minibatch_rows(m), 0);
        for (int s = 0; s < plan.slices(); ++s) EXPECT_EQ(plan.first_row(s, m) % 12, 0);
      }
      for (int s = 0; s < plan.slices(); ++s) {
        EXPECT_EQ(plan.first_row(s, plan.minibatches()), plan.rows(s));
      }
    }
  }
}

}  // namespace
}  // namespace skybody::learn
