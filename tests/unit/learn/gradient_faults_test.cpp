// `gradient` beside flights that end in a fault or whose derivatives overflow. They contribute
// nothing to the gradient, and leave that of all other flights unchanged.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "learn/gradient/gradient.h"
#include "tests/unit/env/quadrotors_in_the_air.h"

namespace skybody::learn {
namespace {

using namespace skybody::test;

class SmoothDirect : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    setup.input(Signal::kRotorSpeed, {0, 0, 0, 0}, {3400, 3400, 3400, 3400});
    setup.output(Signal::kRotorSpeed, 4);
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> in, Values<Real> out) const {
    for (int i = 0; i < 4; ++i) out.set(i, in[i]);
  }
};

enum class Poison {
  kNone,
  kNaN,    ///< a NaN reward: a fault
  kSteep,  ///< a reward whose slope overflows a sum of floats
};

enum class Share { kHalf, kAll };

/// A robot flies to a random height. The episodes with the larger heights are poisoned from the
/// first transition on.
template <Poison kPoison, Share kShare>
class KeepPlace : public Task {
 public:
  static constexpr bool kSmooth = true;

  template <class Real>
  struct State {
    Real target;
  };

  void configure(const Setup& setup) override {
    setup.channel("error", "m", 3, -kInfinity, kInfinity);
    setup.channel("velocity", "m/s", 3, -kInfinity, kInfinity);
    setup.goal(0, 0);
  }
  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state) const {
    state.target = random(env).uniform(Real(0.5), Real(1.5));
  }
  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>& state, Evaluation<Real>& out) const {
    const BodyMotion<Real> body = env.body(0);
    const Vec3<Real> error{body.position.x, body.position.y, body.position.z - state.target};
    out.observation.set(0, error);
    out.observation.set(3, body.velocity);
    const Real distance = squared_norm(error);
    const bool is_steep = kPoison == Poison::kSteep;
    const Real poisoned = is_steep ? distance * -1e25 : Real(nan());
    const auto is_poisoned = state.target > kLeastPoisoned;
    out.set_reward(kPoison == Poison::kNone ? -distance : select(is_poisoned, poisoned, -distance));
  }
  template <class Real>
  void goal(const EnvView<Real>&, const State<Real>& state, Values<Real> goal) const {
    goal.set(0, Vec3<Real>{Real(0.0), Real(0.0), state.target});
    goal.set(3, Real(0.0));
  }

 private:
  static constexpr double kLeastPoisoned = kShare == Share::kAll ? 0.0 : 1.0;

  static double nan() { return std::numeric_limits<double>::quiet_NaN(); }
};

template <Poison kPoison, Share kShare = Share::kHalf>
std::shared_ptr<const CompiledScenario> place() {
  InProcessFactory factory;
  factory.add<SmoothDirect>("direct");
  factory.add<KeepPlace<kPoison, kShare>>("keep_place");
  Scenario s = empty_air("place");
  s.stepping.dt = 0.004;
  s.stepping.action_repeat = 5;
  s.robots.push_back(quadrotor_at(0.0, "quad", factory));
  s.task = factory.use("keep_place", "task");
  return std::make_shared<CompiledScenario>(s, factory);
}

struct Options : LearnerOptions {
  explicit Options(std::shared_ptr<const CompiledScenario> scenario) {
    compiled = std::move(scenario);
    seed = 5;
    total_steps = 100000;
    threads = 2;
    hyper.envs = 50;
    hyper.rollout_steps = 6;
    hyper.hidden = {16, 16};
    hyper.physics_steps = 0;
    hyper.reward_weight = 1.0;
  }
};

std::uint64_t hash_after(const LearnerOptions& options, int iterations) {
  AnalyticGradientLearner learner(options, options.compiled);
  for (int k = 0; k < iterations; ++k) learner.iterate();
  return learner.parameter_hash();
}

void expect_finite(const Report& report) {
  EXPECT_TRUE(std::isfinite(report.position_error));
  for (const float value : report.episode_returns) EXPECT_TRUE(std::isfinite(value));
  for (const auto& [name, value] : report.losses) EXPECT_TRUE(std::isfinite(value)) << name;
}

void expect_finite(const PolicyFile& policy) {
  const auto are_finite = [](const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
  };
  EXPECT_TRUE(are_finite(policy.mean) && are_finite(policy.scale));
  for (const PolicyLayer& layer : policy.layers) {
    EXPECT_TRUE(are_finite(layer.weight) && are_finite(layer.bias));
  }
}

/// Also with a value function, whose targets are sums of rewards.
TEST(GradientFaults, AreCountedAndLeaveEverythingFinite) {
  for (const double end_value_weight : {0.0, 0.5}) {
    Options options(place<Poison::kNaN>());
    options.hyper.end_value_weight = end_value_weight;
    AnalyticGradientLearner learner(options, options.compiled);
    std::int64_t faults = 0;
    for (int k = 0; k < 6; ++k) {
      const Report report = learner.iterate();
      faults += report.faults;
      expect_finite(report);
    }
    EXPECT_GT(faults, 6 * 10);
    EXPECT_LT(faults, 6 * 40);
    expect_finite(learner.policy());
  }
}

TEST(GradientFaults, TeachNothingWhereThereIsNothingElse) {
  const Options faulty(place<Poison::kNaN, Share::kAll>()),
      steep(place<Poison::kSteep, Share::kAll>());
  const std::uint64_t before = hash_after(faulty, 0);
  EXPECT_EQ(hash_after(faulty, 3), before);
  EXPECT_EQ(hash_after(steep, 3), before);
  EXPECT_NE(hash_after(Options(place<Poison::kNone, Share::kAll>()), 3), before);
}

/// Half of the flights are poisoned in one way or the other. The gradient of the other half is the
/// same, bit for bit: the observations of the first gradient are not normalised yet.
TEST(GradientFaults, SpoilNoOtherFlightsLesson) {
  const std::uint64_t faulty = hash_after(Options(place<Poison::kNaN>()), 1);
  const std::uint64_t steep = hash_after(Options(place<Poison::kSteep>()), 1);
  EXPECT_EQ(faulty, steep);
  EXPECT_NE(faulty, hash_after(Options(place<Poison::kNone>()), 1));
  EXPECT_NE(faulty, hash_after(Options(place<Poison::kNone>()), 0));
}

/// A flight with a steep reward continues and is part of later updates: its values stay finite.
TEST(GradientFaults, OfDerivativesAloneLeaveEverythingFinite) {
  Options options(place<Poison::kSteep>());
  AnalyticGradientLearner learner(options, options.compiled);
  for (int k = 0; k < 6; ++k) {
    const Report report = learner.iterate();
    EXPECT_EQ(report.faults, 0);
    expect_finite(report);
  }
  expect_finite(learner.policy());
}

}  // namespace
}  // namespace skybody::learn
