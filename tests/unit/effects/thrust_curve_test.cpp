// Thrust and moment by polynomials of speed and advance ratio, against these polynomials.
#include <cmath>

#include "core/base/math/quat.h"
#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using ::testing::HasSubstr;

constexpr double kThrust = 1.9533e-6, kMoment = 2.8401e-8, kMaxSpeed = 2246.0;  // QDrone2

class ThrustCurveTest : public ::testing::Test {
 protected:
  ThrustCurveTest() { world.add_quad("quad"); }

  static double polynomial(const Numbers& c, double x) {
    double sum = 0.0;
    for (std::size_t k = 0; k < c.size(); ++k) sum += c[k] * std::pow(x, static_cast<double>(k));
    return sum;
  }
  static void apply(const Instance& curve, Group& g) {
    g.held = curve.group(1).held;
    curve.call(Call::kApply, g);
  }
  static double gain(const Group& g, int rotor, int place) {
    return g.held[SKYBODY_HELD_ROTOR_GAIN][static_cast<std::size_t>(4 * rotor + place)];
  }
  PluginWorld world;
  const Numbers thrust{-0.05, 1.2e-3, 1.4e-6}, moment{0.0, 2e-5, 2e-8, 1e-12};
};

TEST_F(ThrustCurveTest, GivesTheBitsOfDouble) {
  expect_same_bits("thrust_curve", world, {{"thrust", thrust}, {"moment", moment}});
  expect_same_bits("thrust_curve", world,
                   {{"thrust", thrust},
                    {"thrust_by_advance", Numbers{-0.3, -1.0}},
                    {"moment_by_advance", Numbers{0.1, -0.7}},
                    {"diameter", 0.25}});
}

TEST_F(ThrustCurveTest, ThrustAndMomentAreThePolynomialsOfTheSpeed) {
  const Instance curve("thrust_curve", world, {{"thrust", thrust}, {"moment", moment}});
  Group g = curve.group(1);
  for (const double w : {200.0, 900.0, 1500.0, 2246.0}) {
    std::fill(g.rotor_speed.begin(), g.rotor_speed.end(), w);
    apply(curve, g);
    for (int i = 0; i < 4; ++i) {
      const double newtons = gain(g, i, SKYBODY_GAIN_THRUST) * kThrust * w * w;
      const double newton_metres = gain(g, i, SKYBODY_GAIN_MOMENT) * kMoment * w * w;
      EXPECT_NEAR(newtons, polynomial(thrust, w), 1e-14 * std::abs(newtons) + 1e-15);
      EXPECT_NEAR(newton_metres, polynomial(moment, w), 1e-14 * newton_metres);
      EXPECT_EQ(gain(g, i, SKYBODY_GAIN_DRAG), 1.0);
      EXPECT_EQ(gain(g, i, SKYBODY_GAIN_ROLLING), 1.0);
    }
  }
}

TEST_F(ThrustCurveTest, ASlowRotorHasTheFactorsOfTheLeastSpeed) {
  const Instance curve("thrust_curve", world, {{"thrust", thrust}, {"least_share", 0.1}});
  Group g = curve.group(1);
  const double least = 0.1 * kMaxSpeed;
  const double bound = polynomial(thrust, least) / (kThrust * least * least);
  for (const double w : {0.0, 1e-9, 100.0, least}) {
    g.rotor_speed[0] = w;
    apply(curve, g);
    EXPECT_NEAR(gain(g, 0, SKYBODY_GAIN_THRUST), bound, 1e-13 * std::abs(bound));
    EXPECT_EQ(gain(g, 0, SKYBODY_GAIN_MOMENT), 1.0);
  }
}

TEST_F(ThrustCurveTest, ADrawnThrustConstantScalesTheCurve) {
  const Instance curve("thrust_curve", world, {{"thrust", thrust}});
  Group g = curve.group(1);
  g.rotor_speed[0] = 1000.0;
  apply(curve, g);
  const double nominal = gain(g, 0, SKYBODY_GAIN_THRUST);
  g.params[static_cast<std::size_t>(world.rotors[0].first_param) + SKYBODY_ROTOR_THRUST_CONSTANT] *=
      1.1;
  apply(curve, g);
  EXPECT_EQ(gain(g, 0, SKYBODY_GAIN_THRUST), nominal);
}

TEST_F(ThrustCurveTest, ThrustFallsWithTheAdvanceRatio) {
  const Numbers by_thrust{-0.4, -0.9}, by_moment{0.2, -0.8, -0.1};
  const Instance curve("thrust_curve", world,
                       {{"thrust_by_advance", by_thrust},
                        {"moment_by_advance", by_moment},
                        {"diameter", 0.2},
                        {"least_advance", -0.1}});
  Group g = curve.group(1);
  const Quat<double> turn = from_rpy(0.3, -0.5, 1.1);
  const Vec3<double> spin{2.0, -1.0, 4.0};
  for (const double along : {-20.0, -2.0, 0.0, 4.0, 15.0, 60.0}) {
    // Along the axis, and across it; the latter has no effect.
    const Vec3<double> velocity = rotate(turn, Vec3<double>{3.0, -2.0, along});
    const double motion[13] = {0,          0,          1,          turn.w, turn.x, turn.y, turn.z,
                               velocity.x, velocity.y, velocity.z, spin.x, spin.y, spin.z};
    std::copy(motion, motion + 13, g.bodies.begin());
    std::fill(g.rotor_speed.begin(), g.rotor_speed.end(), 1500.0);
    apply(curve, g);
    for (int i = 0; i < 4; ++i) {
      const SkybodyRotorInfo& rotor = world.rotors[static_cast<std::size_t>(i)];
      const double hub = along + spin.x * rotor.position[1] - spin.y * rotor.position[0];
      const double raw = hub / (1500.0 / (2.0 * kPi) * 0.2);
      const double advance = std::min(std::max(raw, -0.1), 1.0);
      const double t = 1.0 + advance * polynomial(by_thrust, advance);
      const double q = 1.0 + advance * polynomial(by_moment, advance);
      EXPECT_NEAR(gain(g, i, SKYBODY_GAIN_THRUST), t, 1e-13);  // rounding of the rotation
      EXPECT_NEAR(gain(g, i, SKYBODY_GAIN_MOMENT), q, 1e-13);
    }
  }
}

/// Impulse of the thrust over a spin-up from 1000 to 1500 rad/s in 0.1 s with QDrone2's lag and
/// factors from the start of each step, against the integral of the polynomial.
double impulse_error(const Instance& curve, Group g, double dt, const Numbers& thrust) {
  const auto speed = [](double t) { return 1500.0 - 500.0 * std::exp(-t / 0.0125); };
  const auto integral = [&](double from, double to, const Numbers& c) {
    double sum = 0.0;
    constexpr int kParts = 16;  // Simpson's rule: exact to 1e-12 here
    for (int i = 0; i <= kParts; ++i) {
      const double t = from + (to - from) * i / kParts;
      sum += (i == 0 || i == kParts ? 1.0
              : i % 2 == 1          ? 4.0
                                    : 2.0) *
             (c[0] + c[1] * speed(t) + c[2] * speed(t) * speed(t));
    }
    return sum * (to - from) / (3.0 * kParts);
  };
  double got = 0.0, want = 0.0;
  const int steps = static_cast<int>(std::lround(0.1 / dt));
  for (int k = 0; k < steps; ++k) {
    g.rotor_speed[0] = speed(k * dt);
    g.held = curve.group(1).held;
    curve.call(Call::kApply, g);
    got += g.held[SKYBODY_HELD_ROTOR_GAIN][0] * integral(k * dt, (k + 1) * dt, {0, 0, kThrust});
    want += integral(k * dt, (k + 1) * dt, thrust);
  }
  return std::abs(got / want - 1.0);
}

TEST_F(ThrustCurveTest, IsOfFirstOrderInTheStep) {
  const Instance curve("thrust_curve", world, {{"thrust", thrust}});
  const Group g = curve.group(1);
  const double coarse = impulse_error(curve, g, 0.001, thrust);
  const double fine = impulse_error(curve, g, 0.0005, thrust);
  RecordProperty("coarse", std::to_string(coarse));
  EXPECT_LT(coarse, 7e-4);  // the README states 0.063 %
  EXPECT_NEAR(coarse / fine, 2.0, 0.1);
}

TEST_F(ThrustCurveTest, DerivativesAreThoseOfItsDifferences) {
  expect_derivatives({"thrust_curve",
                      world,
                      {{"thrust", thrust},
                       {"moment", moment},
                       {"thrust_by_advance", Numbers{-0.3, -1.0}},
                       {"diameter", 0.25}},
                      Call::kApply,
                      {}},
                     {"bodies", "params", "rotor_speed"});
}

TEST_F(ThrustCurveTest, SaysWhatDoesNotFit) {
  const auto refused = [&](const Parameters& given) {
    return refusal("thrust_curve", world, given);
  };
  EXPECT_THAT(refused({}), HasSubstr("are all empty: give one of them coefficients"));
  EXPECT_THAT(refused({{"thrust_by_advance", Numbers{-0.3}}}),
              HasSubstr("`diameter` is 0, but the advance ratio is v / (n D)"));
  EXPECT_THAT(
      refused({{"thrust_by_advance", Numbers{-0.3}}, {"diameter", 0.2}, {"least_advance", 0.1}}),
      HasSubstr("`least_advance` 0.1 and `greatest_advance` 1 leave out 0"));
  EXPECT_THAT(refused({{"thrust", thrust}, {"robots", std::vector<std::string>{"quda"}}}),
              HasSubstr("no robot `quda`: there are quad"));
  EXPECT_THAT(refused({{"thrust", Numbers{-5.0}}}),
              HasSubstr("`thrust` is -5 N at the `max_speed` of rotor `rotor0`, 2246 rad/s"));
  EXPECT_THAT(refused({{"thrust", Numbers{0.0, 0.0, 1e-9}}}),
              HasSubstr("by `thrust` all rotors of robot `quad` give 0.0201"));
  EXPECT_THAT(refused({{"moment", Numbers{0.0, -1e-5}}}), HasSubstr("`moment` is -0.02246 N m"));
  world.robots[0].fixed_base = 1;  // on a test bench there is no weight to carry
  EXPECT_EQ(refused({{"thrust", Numbers{0.0, 0.0, 1e-9}}}), "");
  world.rotors[2].constants[SKYBODY_ROTOR_MOMENT_CONSTANT] = 0.0;
  EXPECT_THAT(refused({{"moment", moment}}),
              HasSubstr("rotor `rotor2` has a `moment_constant` of 0"));
}

}  // namespace
}  // namespace skybody::testing
