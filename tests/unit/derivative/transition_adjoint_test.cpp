// Derivatives of transitions against differences of the engine's own.
#include "core/derivative/transition_adjoint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/assemble/compile_scenario.h"
#include "core/base/simd/fp_environment.h"

namespace skybody {
namespace {

constexpr int kSteps = 4;

std::shared_ptr<const CompiledScenario> load(const std::string& scenario,
                                             const std::vector<std::string>& overrides = {}) {
  LoadOptions options;
  options.scenario = scenario;
  options.overrides = overrides;
  return compile_scenario(options);
}

/// 32 flights of a few transitions, with a weighted sum at their end.
class Flights {
 public:
  explicit Flights(std::shared_ptr<const CompiledScenario> scenario, bool with_reward = true)
      : compiled(std::move(scenario)),
        actions(compiled->action_size()),
        seen(compiled->observation_size()),
        state(compiled->make_state(kGroupLanes)),
        work(compiled->make_workspace(kGroupLanes)),
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
    const double* x = adjoint.goal_motion(kSteps - 1);
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

  /// Derivatives of either sum with respect to all actions, in the layout of `chosen`.
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
      set(adjoint.goal_motion_row() + k, weights[static_cast<std::size_t>(seen + k)]);
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
  std::unique_ptr<GroupWorkspace> work;
  TransitionAdjoint adjoint;
  std::vector<float> observation, reward, chosen;
  std::vector<std::uint64_t> status;
  std::vector<double> weights;
};

/// @param step       of the differences
/// @param tolerance  relative to the largest derivative, as is `kink`
/// @param kink       largest distance of one-sided differences at smooth points
void expect_derivatives(const std::string& scenario, const std::vector<std::string>& overrides,
                        bool of_motion, float step, double tolerance, double kink) {
  const FpEnvironment guard;
  Flights flights(load(scenario, overrides));
  flights.fly();
  flights.adjoint.look(flights.state, ~0u, kSteps);
  flights.adjoint.color_columns();
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
        // A rotor that switches from speeding up to slowing down: there is no derivative to compare
        // with.
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

// Differences of doubles: their own error is of second order in a step of 2^-10.
TEST(TransitionAdjoint, GivesDifferencesOfTheMotion) {
  expect_derivatives("hover_learn", {}, true, 0x1p-10f, 1e-5, 1e-3);
}
TEST(TransitionAdjoint, GivesDifferencesOfTheMotionWithLongSteps) {
  expect_derivatives("hover_learn", {"stepping.dt=0.005", "stepping.action_repeat=4"}, true,
                     0x1p-10f, 1e-5, 1e-3);
}
// Rows are floats: their differences have an error of 1e-7 of values of about 10, over 2^-8.
TEST(TransitionAdjoint, GivesDifferencesOfObservationsAndReward) {
  expect_derivatives("hover_learn", {}, false, 0x1p-8f, 2e-3, 0.01);
}

/// Differences of doubles, as above. With effects a few lanes have kinks too small to distinguish
/// from a curve, and the difference contains half of such a kink.
void expect_motion(const std::string& scenario, const std::vector<std::string>& overrides) {
  expect_derivatives(scenario, overrides, true, 0x1p-10f, 1e-4, 1e-3);
}
void expect_observations(const std::string& scenario, const std::vector<std::string>& overrides) {
  expect_derivatives(scenario, overrides, false, 0x1p-8f, 6e-3, 0.012);
}

// --- other rules of integration ----------------------------------------------------------------

TEST(TransitionAdjoint, GivesDifferencesOfEveryFixedRule) {
  expect_motion("hover_learn", {"stepping.integrator=rk4"});
  expect_motion("hover_learn", {"stepping.integrator=semi_implicit_euler"});
}

// --- effects -----------------------------------------------------------------------------------

TEST(TransitionAdjoint, GivesDifferencesInTurbulentAirWithDrag) {
  expect_motion("windy_hover", {});
  expect_observations("windy_hover", {});
}

/// Wind is computed in every second step; its held value applies in the others.
TEST(TransitionAdjoint, GivesDifferencesOfEffectsWithPeriods) {
  expect_motion("windy_hover",
                {"effects=[{plugin: wind, parameters: {velocity: [60, 0, 0], profile: power, "
                 "exponent: 1, reference_height: 3, period: 2}}, {plugin: dryden, parameters: "
                 "{wind_at_20_feet: 5, airspeed: 4, period: 3}}, {plugin: body_drag, parameters: "
                 "{linear: [0.5, 0.5, 0.8]}}]",
                 "randomization=[]"});
}

TEST(TransitionAdjoint, GivesDifferencesOnALowBattery) { expect_motion("low_battery", {}); }

const std::string kRotorEffects =
    "effects=[{plugin: thrust_curve, parameters: {thrust: [0, 1e-4, 1.2e-6], diameter: 0.2, "
    "thrust_by_advance: [-0.5]}}, {plugin: ground_effect, parameters: {radius: 0.1}}, "
    "{plugin: blade_flapping, parameters: {axial_drag: 1e-5, flapping: 1e-6, "
    "translational_lift: 1e-3}}]";

/// Two effects scale the same thrusts.
TEST(TransitionAdjoint, GivesDifferencesWithEffectsOnRotors) {
  expect_motion("hover_learn", {kRotorEffects});
}

TEST(TransitionAdjoint, GivesDifferencesWithMotors) {
  expect_motion("hover_learn",
                {"effects=[{plugin: motor, parameters: {torque_constant: 0.0055, resistance: 0.1, "
                 "max_current: 200, voltage: 16}}]"});
}

// --- trees -------------------------------------------------------------------------------------

TEST(TransitionAdjoint, GivesDifferencesOfAPayloadOnARod) {
  expect_motion("payload", {});
  expect_observations("payload", {});
}

/// Joints with drives that the policy commands.
TEST(TransitionAdjoint, GivesDifferencesOfAnArm) { expect_motion("arm", {"randomization=[]"}); }

/// Tilting arms under feedback controllers. Their allocation has many limits, so the tolerance is
/// half of the largest kink accepted as smooth.
TEST(TransitionAdjoint, GivesDifferencesOfTiltedRotors) {
  expect_derivatives("omav", {}, true, 0x1p-10f, 5e-4, 1e-3);
}

/// Rotors whose speeds change sign; longer steps give them the time to do so.
TEST(TransitionAdjoint, GivesDifferencesOfReversibleRotors) {
  const std::string rotors = SKYBODY_SOURCE_DIR "/tests/unit/derivative/reversible_rotors.yaml";
  expect_derivatives("hover_learn", {"robots.quad.rotors=" + rotors, "stepping.action_repeat=20"},
                     true, 0x1p-10f, 1e-4, 1e-3);
}

TEST(TransitionAdjoint, NeedsOneDirectionForEachValueOfATree) {
  const auto compiled = load("payload");
  const FpEnvironment guard;
  Flights flights(compiled, false);
  flights.fly();
  flights.adjoint.look(flights.state, ~0u, kSteps);
  flights.adjoint.color_columns();
  const StateLayout& l = compiled->layout();
  EXPECT_EQ(flights.adjoint.evaluations().physics,
            l.q.size + l.u.size + l.rotor_speed.size + l.rotor_command.size);
}

// --- exclusions --------------------------------------------------------------------------------

void expect_refusal(const std::string& scenario, const std::vector<std::string>& overrides,
                    const std::string& word) {
  const auto compiled = load(scenario, overrides);
  try {
    const TransitionAdjoint adjoint(*compiled, 1, false);
    FAIL() << "no error";
  } catch (const Error& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find(word), std::string::npos) << text;
    EXPECT_NE(text.find("fast-ppo"), std::string::npos) << text;
  }
}

TEST(TransitionAdjoint, RefusesByNameWhatHasNoDerivatives) {
  expect_refusal("formation_2", {}, "`formation`");
  expect_refusal("hover_learn", {"stepping.integrator=cvode"}, "integrator");
  expect_refusal("payload", {"observe=[imu.angular_rate]"}, "`imu`");
  expect_refusal("arm", {}, "`draw`");
}

/// Observations of `hover` are the values themselves, except the heading, which depends on all four
/// of the quaternion; the controller passes its inputs on.
TEST(TransitionAdjoint, AsksPluginsAsSeldomAsTheirDependencesAllow) {
  const FpEnvironment guard;
  Flights flights(load("hover_learn"), false);
  flights.fly();
  flights.adjoint.look(flights.state, ~0u, kSteps);
  flights.adjoint.color_columns();
  const auto count = flights.adjoint.evaluations();
  EXPECT_EQ(count.task, 4);
  EXPECT_EQ(count.controllers, 1);
  EXPECT_EQ(count.effects + count.physics, 0);
}

}  // namespace
}  // namespace skybody
