// The interface between a driver and its slices, and the results of a slice.
#include "learn/ppo/ppo_slices.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "learn/ppo/ppo.h"
#include "learn/ppo/ppo_driver.h"
#include "tests/unit/learn/small_team.h"

namespace skybody::learn {
namespace {

using test::small_options;
using test::small_team;

/// A driver, and slices held by two others, as by workers on two machines.
class TwoWorkers {
 public:
  explicit TwoWorkers(const LearnerOptions& options)
      : setup_(std::make_shared<const PpoSetup>(options)),
        driver_(setup_),
        threads_(1, kSlices),
        first_(setup_, 0, 3, threads_),
        second_(setup_, 3, setup_->plan.slices() - 3, threads_),
        networks_(setup_->agents, setup_->images, setup_->hyper, setup_->isa) {}

  void iterate() {
    const RolloutInputs inputs = driver_.begin_rollout();
    each([&](PpoSlices& s) { s.collect(inputs, networks_); });
    const double scale = driver_.take_rollout(sums(&PpoSlice::rollout_sums));
    each([&](PpoSlices& s) { s.find_advantages(scale, networks_); });
    driver_.take_advantages(sums(&PpoSlice::advantage_sums));
    policy_steps_ = value_steps_ = 0;
    for (Minibatch m; driver_.next(m);) {
      each([&](PpoSlices& s) { s.find_gradients(m, networks_); });
      policy_steps_ += m.policy ? 1 : 0;
      value_steps_ += m.value ? 1 : 0;
      if (m.policy) driver_.step_policy(gradients(&PpoSlice::policy_gradient));
      if (m.value) driver_.step_value(gradients(&PpoSlice::value_gradient));
      driver_.take_figures(m, sums(&PpoSlice::minibatch_sums));
    }
    driver_.finish();
    each([&](PpoSlices& s) { s.stagger_resets(driver_.iteration()); });
  }
  int policy_steps() const { return policy_steps_; }  // of the last iteration
  int value_steps() const { return value_steps_; }
  std::uint64_t parameter_hash() const { return driver_.parameter_hash(); }

  template <class Work>
  void each(Work&& work) {
    networks_.set(driver_.networks().policy_parameters(), driver_.networks().value_parameters());
    work(second_);  // in any order
    work(first_);
  }
  const PpoSlice& slice(int k) const { return k < 3 ? first_.slice(k) : second_.slice(k - 3); }
  int count() const { return first_.count() + second_.count(); }
  PpoDriver& driver() { return driver_; }
  const PpoSetup& setup() const { return *setup_; }

  SliceSums sums(std::span<const double> (PpoSlice::*of)() const) {
    sums_.clear();
    for (int k = 0; k < count(); ++k) sums_.push_back((slice(k).*of)());
    return sums_;
  }
  SliceGradients gradients(std::span<const float> (PpoSlice::*of)() const) {
    gradients_.clear();
    for (int k = 0; k < count(); ++k) gradients_.push_back((slice(k).*of)().data());
    return gradients_;
  }

 private:
  std::shared_ptr<const PpoSetup> setup_;
  PpoDriver driver_;
  LearnerThreads threads_;
  PpoSlices first_, second_;
  PpoNetworks networks_;
  int policy_steps_ = 0, value_steps_ = 0;
  std::vector<std::span<const double>> sums_;
  std::vector<const float*> gradients_;
};

TEST(PpoSlices, GiveTheSameBitsWhoeverHoldsThem) {
  const LearnerOptions options = small_options(small_team());
  Ppo ppo(options);
  TwoWorkers workers(options);
  for (int k = 0; k < 3; ++k) {
    ppo.iterate();
    workers.iterate();
    ASSERT_EQ(workers.parameter_hash(), ppo.parameter_hash()) << "iteration " << k;
  }
}

TEST(PpoSlices, AdvantagesAreThoseOfAPlainLoop) {
  LearnerOptions options = small_options(small_team());
  options.hyper.discount = 0.9;
  TwoWorkers workers(options);
  workers.iterate();
  const RolloutInputs inputs = workers.driver().begin_rollout();
  constexpr double kScale = 0.7;
  const PpoNetworks& networks = workers.driver().networks();
  workers.each([&](PpoSlices& s) {
    s.collect(inputs, networks);
    s.find_advantages(kScale, networks);
  });
  const RowLayout& layout = workers.setup().row;
  int cut = 0, ended = 0;
  for (int k = 0; k < workers.count(); ++k) {
    const PpoSlice::LastRollout rollout = workers.slice(k).rollout();
    const int n = rollout.rows_of_step;
    for (int r = 0; r < n; ++r) {
      double after = 0.0,
             value_after = rollout.value[static_cast<std::size_t>(rollout.steps * n + r)];
      for (int t = rollout.steps - 1; t >= 0; --t) {
        const auto i = static_cast<std::size_t>(t * n + r);
        double reward = kScale * static_cast<double>(rollout.reward[i]);
        const bool goes_on = rollout.goes_on[i] != 0.0f;
        ended += goes_on ? 0 : 1;
        cut += rollout.bootstrap[i] != 0.0f ? 1 : 0;
        reward += 0.9 * static_cast<double>(rollout.bootstrap[i]);
        const double value = rollout.value[i];
        const double delta = reward + (goes_on ? 0.9 * value_after : 0.0) - value;
        const double advantage = delta + (goes_on ? 0.9 * 0.95 * after : 0.0);
        const float* row = rollout.rows.data() + i * static_cast<std::size_t>(layout.stride());
        // Ten steps of float arithmetic on numbers of about 1.
        ASSERT_NEAR(row[layout.advantage()], advantage, 2e-5) << "slice " << k << " row " << i;
        ASSERT_NEAR(row[layout.value_target()], advantage + value, 2e-5);
        after = advantage;
        value_after = value;
      }
    }
  }
  EXPECT_GT(cut, 0) << "no episode was cut off";
  EXPECT_GT(ended, cut / 2);
}

TEST(PpoSlices, OrderOfAnEpochHasEachRowOnce) {
  TwoWorkers workers(small_options(small_team()));
  workers.iterate();
  for (int k = 0; k < workers.count(); ++k) {
    const auto order = workers.slice(k).rollout().order;
    std::vector<int> sorted(order.begin(), order.end()), wanted(order.size());
    EXPECT_FALSE(std::is_sorted(order.begin(), order.end()));
    std::sort(sorted.begin(), sorted.end());
    std::iota(wanted.begin(), wanted.end(), 0);
    EXPECT_EQ(sorted, wanted);
  }
}

TEST(PpoSlices, ValueFunctionAloneSeesPrivilegedColumns) {
  const LearnerOptions options = small_options(small_team());
  TwoWorkers workers(options);
  workers.iterate();
  const PpoSetup& setup = workers.setup();
  EXPECT_EQ(workers.driver().networks().policy().shape().inputs, 5);
  EXPECT_EQ(workers.driver().networks().value().shape().inputs, 11);
  EXPECT_EQ(workers.driver().policy().observation_size, 5);
  EXPECT_EQ(workers.driver().policy().mean.size(), 5u);
  // Normalized: mean 0 and deviation 1 after the statistics have settled, for any unit.
  const PpoSlice::LastRollout rollout = workers.slice(0).rollout();
  for (int column = 5; column < 11; ++column) {
    double largest = 0.0;
    for (std::size_t i = 0; i < rollout.reward.size(); ++i) {
      largest = std::max(
          largest, std::abs(static_cast<double>(rollout.rows[i * setup.row.stride() + column])));
    }
    EXPECT_LE(largest, 10.0);
  }
}

TEST(PpoSlices, RowsAreRobotsWhereThePolicyIsShared) {
  LearnerOptions options = small_options(small_team());
  options.hyper.shared_policy = true;
  TwoWorkers workers(options);
  const RolloutInputs inputs = workers.driver().begin_rollout();
  workers.each([&](PpoSlices& s) { s.collect(inputs, workers.driver().networks()); });
  const PpoSetup& setup = workers.setup();
  EXPECT_EQ(setup.agents.rows(), 2);
  EXPECT_THAT(setup.agents.observation,
              testing::ElementsAre(testing::ElementsAre(1, 2, 0), testing::ElementsAre(3, 4, 0)));
  EXPECT_THAT(setup.agents.privileged,
              testing::ElementsAre(testing::ElementsAre(0, 1, 2), testing::ElementsAre(3, 4, 5)));
  EXPECT_THAT(setup.agents.action, testing::ElementsAre(testing::ElementsAre(0, 1, 2, 3),
                                                        testing::ElementsAre(4, 5, 6, 7)));
  // Both robots begin at one height with one target. Before any statistics, and except for noise,
  // their rewards differ by the factor on the second robot's reward.
  const PpoSlice::LastRollout rollout = workers.slice(0).rollout();
  EXPECT_EQ(rollout.rows_of_step, 4);
  EXPECT_NEAR(rollout.reward[1] / rollout.reward[0], 2.0f, 0.3f);
}

TEST(PpoSlices, SharedPolicyIsLearnedTheSameBitsOnAnyNumberOfThreads) {
  LearnerOptions options = small_options(small_team());
  options.hyper.shared_policy = true;
  std::uint64_t hashes[2];
  for (const int k : {0, 1}) {
    options.threads = 1 + 2 * k;
    Ppo ppo(options);
    for (int i = 0; i < 3; ++i) ppo.iterate();
    hashes[k] = ppo.parameter_hash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(PpoDriver, StopsThePolicysPassesBeyondTheKlLimitAlone) {
  LearnerOptions options = small_options(small_team());
  options.hyper.epochs = 8;
  for (const double target : {0.0, 1e-9, 100.0}) {
    options.hyper.target_kl = target;
    TwoWorkers workers(options);
    workers.iterate();
    constexpr int kMinibatches = 4;  // 190 rows, 48 each
    EXPECT_EQ(workers.policy_steps(), (target == 1e-9 ? 1 : 8) * kMinibatches) << target;
    EXPECT_EQ(workers.value_steps(), 2 * kMinibatches);
  }
}

TEST(PpoDriver, SaysThatItDivergedAndWhatToDo) {
  TwoWorkers workers(small_options(small_team()));
  workers.iterate();
  const std::uint64_t before = workers.parameter_hash();
  std::vector<float> bad(workers.driver().networks().policy_parameters().size(), std::nanf(""));
  const float* gradient = bad.data();
  try {
    workers.driver().step_policy(std::span(&gradient, 1));
    FAIL() << "accepted";
  } catch (const Diverged& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("gradient of the policy"),
                                             testing::HasSubstr("after 190 steps"),
                                             testing::HasSubstr("smaller learning_rate")));
  }
  EXPECT_EQ(workers.parameter_hash(), before) << "a bad gradient was stepped along";
}

TEST(SlicePlan, GivesEachRowToOneMinibatch) {
  for (const int envs : {1, 7, 8, 15, 256}) {
    for (const int minibatch : {2, 31, 1000}) {
      const SlicePlan plan(envs, 6, minibatch);
      int rows = 0, of_envs = 0;
      for (int m = 0; m < plan.minibatches(); ++m) {
        rows += plan.minibatch_rows(m);
        EXPECT_GE(plan.minibatch_rows(m), plan.slices()) << "a slice has no share";
        if (6 * (envs / plan.slices()) >= plan.minibatches() + 1) {
          EXPECT_LE(plan.minibatch_rows(m), minibatch + plan.slices());
        }
      }
      for (int s = 0; s < plan.slices(); ++s) {
        EXPECT_GE(plan.envs(s), 1);
        EXPECT_EQ(plan.first_row(s, 0), 0);
        EXPECT_EQ(plan.first_row(s, plan.minibatches()), plan.rows(s));
        of_envs += plan.envs(s);
      }
      EXPECT_EQ(rows, envs * 6);
      EXPECT_EQ(of_envs, envs);
    }
  }
}

}  // namespace
}  // namespace skybody::learn
