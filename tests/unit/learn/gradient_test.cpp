// Derivatives of transitions against differences of the engine's own, and the learner's promises.
#include "learn/gradient/gradient.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/assemble/load.h"
#include "core/base/fp_environment.h"

namespace skybody::learn {
namespace {

constexpr int kSteps = 4;

std::shared_ptr<const CompiledScenario> load(const std::vector<std::string>& overrides = {}) {
  LoadOptions options;
  options.scenario = "hover_learn";
  options.overrides = overrides;
  return compile_scenario(options);
}

/// 32 flights of a few transitions, with something to weigh at their end.
class Flights {
 public:
  explicit Flights(std::shared_ptr<const CompiledScenario> scenario, bool with_reward = true)
      : compiled(std::move(scenario)),
        actions(compiled->action_size()),
        seen(compiled->observation_size()),
        state(compiled->make_state(kGroupLanes)),
        work(compiled->make_work(kGroupLanes)),
        adjoint(*compiled, kSteps, with_reward),
        observation(static_cast<std::size_t>(kGroupLanes * seen)),
        reward(kGroupLanes),
        status(kGroupLanes) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<float> action(-0.5f, 0.9f);
    std::normal_distribution<double> normal;
    chosen.resize(static_cast<std::size_t>(kSteps * kGroupLanes * actions));
    for (float& a : chosen) a = action(random);
    weights.resize(static_cast<std::size_t>(seen) + 14);
    for (double& w : weights) w = normal(random);
  }

  Rows rows() { return {observation.data(), reward.data(), status.data()}; }

  void fly() {
    for (int l = 0; l < kGroupLanes; ++l) {
      compiled->initialize(state, l, 5, static_cast<std::uint64_t>(l));
    }
    compiled->reset(state, *work, ~0u, rows());
    for (int t = 0; t < kSteps; ++t) {
      adjoint.step(state, *work, ~0u, &chosen[static_cast<std::size_t>(t * kGroupLanes * actions)],
                   actions, rows(), t);
    }
  }

  /// Weighted sums, per lane: of coordinates, in double; of observations and the reward, in float.
  double motion(int lane) const {
    double sum = 0.0;
    const double* x = adjoint.coordinates(kSteps - 1);
    for (int k = 0; k < 13; ++k) {
      sum += weights[static_cast<std::size_t>(seen + k)] * x[k * kGroupLanes + lane];
    }
    return sum;
  }
  double seen_sum(int lane) const {
    double sum = weights.back() * static_cast<double>(reward[static_cast<std::size_t>(lane)]);
    for (int k = 0; k < seen; ++k) {
      sum += weights[static_cast<std::size_t>(k)] *
             static_cast<double>(observation[static_cast<std::size_t>(lane * seen + k)]);
    }
    return sum;
  }

  /// Derivatives of either sum by all actions, as `chosen` lies.
  std::vector<double> derivatives(bool of_motion) {
    adjoint.begin(state, ~0u);
    AlignedArray<double> adjoints(static_cast<std::size_t>(adjoint.rows() * kGroupLanes));
    AlignedArray<double> action(static_cast<std::size_t>(actions * kGroupLanes));
    const auto set = [&](int row, double value) {
      for (int l = 0; l < kGroupLanes; ++l) {
        adjoints[static_cast<std::size_t>(row * kGroupLanes + l)] = value;
      }
    };
    for (int k = 0; of_motion && k < 13; ++k) {
      set(compiled->layout().q.offset + k, weights[static_cast<std::size_t>(seen + k)]);
    }
    for (int k = 0; !of_motion && k < seen; ++k) {
      set(adjoint.observation_row() + k, weights[static_cast<std::size_t>(k)]);
    }
    if (!of_motion) set(adjoint.reward_row(), weights.back());
    std::vector<double> result(chosen.size());
    for (int t = kSteps; t-- > 0;) {
      adjoint.pull_back(state, t, ~0u, adjoints.data(), action.data());
      for (int l = 0; l < kGroupLanes; ++l) {
        for (int k = 0; k < actions; ++k) {
          result[static_cast<std::size_t>((t * kGroupLanes + l) * actions + k)] =
              action[static_cast<std::size_t>(k * kGroupLanes + l)];
        }
      }
    }
    return result;
  }

  std::shared_ptr<const CompiledScenario> compiled;
  int actions, seen;
  StateGroup state;
  std::unique_ptr<GroupWork> work;
  TransitionAdjoint adjoint;
  std::vector<float> observation, reward, chosen;
  std::vector<std::uint64_t> status;
  std::vector<double> weights;
};

/// @param step  of the differences
/// @param tolerance  relative to the largest derivative, as is
/// @param kink       by how much differences to both sides are apart where there is none
void expect_derivatives(const std::vector<std::string>& overrides, bool of_motion, float step,
                        double tolerance, double kink) {
  const FpEnvironment guard;
  Flights flights(load(overrides));
  flights.fly();
  flights.adjoint.look(flights.state, ~0u, kSteps);
  flights.adjoint.arrange();
  const std::vector<double> derived = flights.derivatives(of_motion);
  double largest = 0.0;
  for (const double d : derived) largest = std::max(largest, std::abs(d));
  const auto sums = [&] {
    flights.fly();
    std::vector<double> s;
    for (int l = 0; l < kGroupLanes; ++l) {
      s.push_back(of_motion ? flights.motion(l) : flights.seen_sum(l));
    }
    return s;
  };
  const std::vector<double> here = sums();
  int kinks = 0;
  for (int t = 0; t < kSteps; ++t) {
    for (int k = 0; k < flights.actions; ++k) {
      const auto nudge = [&](float by) {
        for (int l = 0; l < kGroupLanes; ++l) {
          flights.chosen[static_cast<std::size_t>((t * kGroupLanes + l) * flights.actions + k)] +=
              by;
        }
      };
      nudge(step);
      const std::vector<double> above = sums();
      nudge(-2.0f * step);
      const std::vector<double> below = sums();
      nudge(step);
      for (int l = 0; l < kGroupLanes; ++l) {
        const auto lane = static_cast<std::size_t>(l);
        const double width = static_cast<double>(step);
        const double right = (above[lane] - here[lane]) / width;
        const double left = (here[lane] - below[lane]) / width;
        // A rotor that stops rising in between and falls: there is no derivative to compare with.
        if (std::abs(right - left) > kink * largest) {
          ++kinks;
          continue;
        }
        const double difference = 0.5 * (left + right);
        EXPECT_NEAR(derived[static_cast<std::size_t>((t * kGroupLanes + l) * flights.actions + k)],
                    difference, tolerance * largest)
            << "step " << t << ", action " << k << ", lane " << l;
      }
    }
  }
  EXPECT_LT(kinks, kSteps * flights.actions * kGroupLanes / 20);
}

// Differences of doubles: their own error, of the second order in a step of 2^-10.
TEST(TransitionAdjoint, GivesDifferencesOfTheMotion) {
  expect_derivatives({}, true, 0x1p-10f, 1e-5, 1e-3);
}
TEST(TransitionAdjoint, GivesDifferencesOfTheMotionWithLongSteps) {
  expect_derivatives({"stepping.dt=0.005", "stepping.action_repeat=4"}, true, 0x1p-10f, 1e-5, 1e-3);
}
// Rows are floats: differences of theirs are good to 1e-7 of values of about 10, over 2^-8.
TEST(TransitionAdjoint, GivesDifferencesOfObservationsAndReward) {
  expect_derivatives({}, false, 0x1p-8f, 2e-3, 0.01);
}

/// Observations of `hover` are the values themselves, but for four of the quaternion that meet in
/// the heading; the controller hands on what it gets.
TEST(TransitionAdjoint, AsksPluginsAsSeldomAsTheirDependencesAllow) {
  const FpEnvironment guard;
  Flights flights(load(), false);
  flights.fly();
  flights.adjoint.look(flights.state, ~0u, kSteps);
  flights.adjoint.arrange();
  EXPECT_EQ(flights.adjoint.evaluations(), std::make_pair(4, 1));
}

LearnerOptions options(int threads) {
  LearnerOptions o;
  o.compiled = load();
  o.hyper.envs = 40;  // slices of five
  o.hyper.rollout_steps = 8;
  o.hyper.hidden = {16, 16};
  o.training = load(training_overrides(*o.compiled, o.hyper));
  o.seed = 3;
  o.total_steps = 40 * 8 * 40;
  o.threads = threads;
  return o;
}

std::uint64_t hash_after(Learner& learner, int iterations) {
  for (int i = 0; i < iterations; ++i) learner.iterate();
  return learner.parameter_hash();
}

TEST(Gradient, GivesTheSameBitsOnAnyNumberOfThreads) {
  Gradient one(options(1));
  Gradient three(options(3));
  EXPECT_EQ(hash_after(one, 12), hash_after(three, 12));
  EXPECT_EQ(one.state().environments, three.state().environments);
}

TEST(Gradient, GivesTheSameBitsOnEveryProcessorWithFusedMultiplyAdd) {
  if (best_isa() == kIsas[0]) GTEST_SKIP() << "v2 has other last bits";
  Gradient learner(options(2));
  EXPECT_EQ(hash_after(learner, 12), 13363219139739832116ull);
}

TEST(Gradient, GoesOnFromItsStateWithTheSameBits) {
  Gradient whole(options(2));
  whole.iterate();
  hash_after(whole, 4);
  const LearnerState middle = whole.state();
  Gradient resumed(options(1));
  resumed.restore(middle);
  EXPECT_EQ(resumed.steps(), whole.steps());
  EXPECT_EQ(hash_after(resumed, 6), hash_after(whole, 6));
}

TEST(Gradient, WithAValueFunctionHasTheSameBitsOnAnyNumberOfThreadsAndAfterARestore) {
  const auto with_value = [](int threads) {
    LearnerOptions o = options(threads);
    o.hyper.reward_weight = 0.5;
    o.hyper.end_value_weight = 1.0;
    o.hyper.value_epochs = 2;
    o.hyper.averaging_steps = 1000;
    return o;
  };
  Gradient one(with_value(1)), three(with_value(3)), resumed(with_value(2));
  EXPECT_EQ(hash_after(one, 6), hash_after(three, 6));
  resumed.restore(three.state());
  EXPECT_EQ(hash_after(resumed, 5), hash_after(one, 5));
  EXPECT_EQ(resumed.policy().layers[0].weight, one.policy().layers[0].weight);
  Gradient without(options(1));
  EXPECT_NE(hash_after(without, 11), one.parameter_hash());
}

TEST(Gradient, RefusesAnotherLearnersState) {
  Gradient learner(options(1));
  LearnerState state = learner.state();
  state.environments.pop_back();
  EXPECT_THROW(learner.restore(state), Error);
  state = learner.state();
  state.blocks.pop_back();
  EXPECT_THROW(learner.restore(state), Error);
}

TEST(Gradient, BringsTheVehicleNearerToItsTarget) {
  LearnerOptions o = options(2);
  o.hyper.envs = 64;
  o.hyper.rollout_steps = 24;
  o.hyper.learning_rate = 6e-3;
  o.hyper.max_grad_norm = 1.0;
  o.hyper.hidden = {32, 32};
  o.total_steps = 64 * 24 * 120;
  Gradient learner(o);
  const double before = learner.iterate().position_error;
  for (int i = 0; i < 118; ++i) learner.iterate();
  EXPECT_LT(learner.iterate().position_error, 0.6 * before);
}

TEST(Gradient, LengthensPhysicsStepsAndKeepsAnActionsTime) {
  Hyperparameters hyper;
  hyper.physics_steps = 4;
  const std::vector<std::string> expected = {"stepping.dt=0.005", "stepping.action_repeat=4"};
  EXPECT_EQ(training_overrides(*load(), hyper), expected);
  hyper.physics_steps = 0;
  EXPECT_TRUE(training_overrides(*load(), hyper).empty());
}

}  // namespace
}  // namespace skybody::learn
