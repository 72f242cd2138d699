// Forms of allocation other than priority, on quadrotors, hexacopters, coaxial octocopters and
// tilted rotors. tests/oracle/test_allocation.py compares qp with SciPy.
#include <cmath>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;

/// Thrust and torque per newton of each rotor, by hand.
using Effects = std::vector<std::array<double, 4>>;

struct Robot {
  std::string name;
  PluginWorld world;

  Effects effects() const {
    Effects out;
    for (const SkybodyRotorInfo& r : world.rotors) {
      const double* c = world.bodies[0].com;
      const double arm[3] = {r.position[0] - c[0], r.position[1] - c[1], r.position[2] - c[2]};
      const double k = -r.direction * r.constants[SKYBODY_ROTOR_MOMENT_CONSTANT] /
                       r.constants[SKYBODY_ROTOR_THRUST_CONSTANT];
      const double* a = r.axis;
      out.push_back({a[2], arm[1] * a[2] - arm[2] * a[1] + k * a[0],
                     arm[2] * a[0] - arm[0] * a[2] + k * a[1],
                     arm[0] * a[1] - arm[1] * a[0] + k * a[2]});
    }
    return out;
  }
};

/// Rotors on a circle in `layers` layers, tilted about their arms by alternating +-`tilt`.
Robot ring(const std::string& name, int arms, int layers, double tilt) {
  Robot robot{name, {}};
  robot.world.add_robot(name, 0, 0, 1);
  robot.world.add_body(0, "base", -1, 1, 2.0, {0.03, 0.04, 0.06});
  robot.world.bodies[0].com[0] = 0.01;  // breaks the symmetry
  for (int i = 0; i < arms * layers; ++i) {
    const double angle = kTwoPi * (i % arms + 0.5) / arms, side = i % 2 == 0 ? 1.0 : -1.0;
    const double turn = layers > 1 && i >= arms ? -side : side;
    robot.world.add_rotor(0, {0.25 * std::cos(angle), 0.25 * std::sin(angle), i < arms ? 0.0 : 0.1},
                          turn);
    double* axis = robot.world.rotors.back().axis;
    axis[0] = -side * std::sin(tilt) * std::sin(angle);
    axis[1] = side * std::sin(tilt) * std::cos(angle);
    axis[2] = std::cos(tilt);
  }
  return robot;
}

Robot quad() {
  Robot robot{"quad", {}};
  robot.world.add_quad("quad");
  return robot;
}

std::vector<Robot> robots() {
  std::vector<Robot> all;
  all.push_back(quad());
  all.push_back(ring("hexa", 6, 1, 0.0));
  all.push_back(ring("coaxial_octo", 4, 2, 0.0));
  all.push_back(ring("tilted_hexa", 6, 1, 0.3));
  return all;
}

std::vector<double> thrusts(const Robot& robot, const Instance& instance,
                            const std::vector<double>& command) {
  Group g = instance.group(1);
  g.input = command;
  instance.call(Call::kControl, g);
  std::vector<double> out;
  for (std::size_t i = 0; i < g.output.size(); ++i) {
    out.push_back(robot.world.rotors[i].constants[SKYBODY_ROTOR_THRUST_CONSTANT] * g.output[i] *
                  g.output[i]);
  }
  return out;
}

std::array<double, 4> sum(const Effects& effects, const std::vector<double>& f) {
  std::array<double, 4> total{};
  for (std::size_t i = 0; i < f.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k) total[k] += effects[i][k] * f[i];
  }
  return total;
}

double full_of(const Robot& robot) {
  const double* c = robot.world.rotors[0].constants;
  return c[SKYBODY_ROTOR_THRUST_CONSTANT] * c[SKYBODY_ROTOR_MAX_SPEED] * c[SKYBODY_ROTOR_MAX_SPEED];
}

/// A random command of up to `size` times each limit.
std::vector<double> random_command(const Instance& instance, std::mt19937_64& generator,
                                   double size) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<double> u = {instance.declared.controller.high[0] * std::fabs(uniform(generator))};
  for (std::size_t k = 1; k < 4; ++k) {
    u.push_back(size * instance.declared.controller.high[k] * uniform(generator));
  }
  return u;
}

TEST(AllocationForms, MeetWhatRotorsCanMeetWithTheSameBits) {
  for (Robot& robot : robots()) {
    PluginWorld cut = robot.world, nearest = robot.world;
    const Instance priority("ctbt", robot.world);
    const Instance pseudo_inverse("ctbt", cut, {{"allocation", "pseudo_inverse"}});
    const Instance qp("ctbt", nearest, {{"allocation", "qp"}});
    std::mt19937_64 generator(1);
    int met = 0;
    for (int n = 0; n < 300; ++n) {
      const std::vector<double> u = random_command(priority, generator, 0.3);
      const std::vector<double> f = thrusts(robot, priority, u);
      const auto got = sum(robot.effects(), f);
      bool is_met = true;
      for (std::size_t k = 0; k < 4; ++k) is_met = is_met && std::fabs(got[k] - u[k]) < 1e-11;
      if (!is_met) continue;
      ++met;
      EXPECT_EQ(thrusts(robot, pseudo_inverse, u), f) << robot.name;
      EXPECT_EQ(thrusts(robot, qp, u), f) << robot.name;
    }
    EXPECT_GT(met, 50) << robot.name;
  }
}

TEST(AllocationForms, PseudoInverseCutsEachRotorByItself) {
  Robot robot = quad();
  PluginWorld own = robot.world;
  const Instance instance("ctbt", own, {{"allocation", "pseudo_inverse"}});
  const double full = full_of(robot);
  // 20 N and a roll torque that takes 5 - 2.5/0.508 ... of each pair: left up, right down.
  const std::vector<double> f = thrusts(robot, instance, {20.0, 3.0, 0.0, 0.0});
  const double share = 3.0 / (4.0 * 0.127);
  EXPECT_NEAR(f[0], std::fmin(full, 5.0 + share), 1e-12);
  EXPECT_NEAR(f[1], 0.0, 1e-12);
}

/// |w (A f - u) / scale|^2 + g |(f - P u) / full|^2 decreases in no direction that the limits
/// allow.
TEST(AllocationForms, QpIsTheMinimumWithinLimits) {
  const double weights[4] = {0.1, 1.0, 1.0, 0.01};
  for (Robot& robot : robots()) {
    PluginWorld plain = robot.world;
    const Instance instance("ctbt", robot.world, {{"allocation", "qp"}});
    const Instance priority("ctbt", plain);
    const Effects effects = robot.effects();
    const double full = full_of(robot);
    std::mt19937_64 generator(2);
    for (int n = 0; n < 500; ++n) {
      const std::vector<double> u = random_command(instance, generator, 1.5);
      const std::vector<double> f = thrusts(robot, instance, u);
      const auto got = sum(effects, f);
      for (std::size_t i = 0; i < f.size(); ++i) {
        double slope = 0.0;
        for (std::size_t k = 0; k < 4; ++k) {
          const double scale = weights[k] / instance.declared.controller.high[k];
          slope += scale * scale * effects[i][k] * full * (got[k] - u[k]);
        }
        ASSERT_GE(f[i], 0.0);
        ASSERT_LE(f[i], full * (1.0 + 1e-12));
        // The tie-break term of 1e-8 tilts slopes by the same factor, times a setpoint of a few
        // times the limit.
        if (f[i] > 1e-9 * full) {
          ASSERT_LT(slope, 1e-6) << robot.name << " " << n;
        }
        if (f[i] < full * (1.0 - 1e-9)) {
          ASSERT_GT(slope, -1e-6) << robot.name << " " << n;
        }
      }
    }
  }
}

TEST(AllocationForms, OfQpTheLeastWeightGivesWayFirst) {
  Robot robot = quad();
  PluginWorld first = robot.world, second = robot.world;
  const Instance yaw_first("ctbt", first, {{"allocation", "qp"}});
  const Instance thrust_first(
      "ctbt", second,
      {{"allocation", "qp"}, {"allocation_weights", std::vector<double>{1, 100, 100, 10}}});
  const std::vector<double> u = {15.0, 0.3, -0.2, 0.25};  // yaw takes 4.3 N more from each pair
  const auto a = sum(robot.effects(), thrusts(robot, yaw_first, u));
  const auto b = sum(robot.effects(), thrusts(robot, thrust_first, u));
  // Each priority has 1e-2 of the cost of the next: the others deviate by a fraction of that.
  EXPECT_NEAR(a[0], 15.0, 0.3);
  EXPECT_NEAR(a[1], 0.3, 0.01);
  EXPECT_LT(a[3], 0.23);
  EXPECT_GT(b[0], 16.0);
  EXPECT_NEAR(b[3], 0.25, 0.01);
}

TEST(AllocationForms, GiveTheBitsOfDouble) {
  for (const char* form : {"pseudo_inverse", "qp"}) {
    for (const char* name : {"ctbt", "ctbr", "indi"}) {
      PluginWorld world = ring("hexa", 6, 1, 0.2).world;
      Parameters given{{"allocation", form}};
      if (name == std::string("indi")) given.emplace("signal", "ctbr");
      expect_same_bits(name, world, given);
    }
  }
}

TEST(AllocationForms, ANaNCommandStaysOne) {
  Robot robot = quad();
  const Instance instance("ctbt", robot.world, {{"allocation", "qp"}});
  for (const double f : thrusts(robot, instance, {kNan, 1.0, 0.0, 0.0})) EXPECT_TRUE(is_nan(f));
}

TEST(AllocationForms, BadConfigurationNamesValueAndRemedy) {
  PluginWorld world = quad().world;
  const std::vector<double> weights = {1, 1, 1, 1};
  EXPECT_THAT(refusal("ctbt", world, {{"allocation_weights", weights}}),
              HasSubstr("`allocation_weights` are given, but `allocation` is `priority`"));
  EXPECT_THAT(refusal("ctbr", world, {{"apply", "body"}, {"allocation", "qp"}}),
              HasSubstr("`allocation` is given, but `apply` is `body`"));
  EXPECT_THAT(
      refusal("indi", world,
              {{"allocation", "qp"}, {"allocation_weights", std::vector<double>{1e-3, 1e4, 1, 1}}}),
      HasSubstr("`allocation_weights` are from 0.001 to 10000, a ratio of more than 1000"));
  PluginWorld many = ring("many", 18, 1, 0.0).world;
  EXPECT_THAT(refusal("ctbt", many, {{"allocation", "qp"}}),
              HasSubstr("has 18 rotors; `allocation: qp` takes 16 at most"));
}

/// A ring of four rotors upwards and one of four downwards, tilted so that either gives all
/// torques.
Robot both_ways(double min_speed) {
  Robot robot = ring("both_ways", 4, 2, 0.3);
  for (std::size_t i = 4; i < 8; ++i) robot.world.rotors[i].axis[2] *= -1.0;
  for (SkybodyRotorInfo& rotor : robot.world.rotors) rotor.min_speed = min_speed;
  return robot;
}

TEST(AllocationForms, RotorsThatPushDownwardsTakeNoPart) {
  for (const char* form : {"priority", "pseudo_inverse"}) {
    Robot robot = both_ways(0.0);
    const Instance instance("ctbt", robot.world, {{"allocation", form}});
    const std::vector<double> u = {19.62, 0.1, -0.05, 0.02};
    const std::vector<double> f = thrusts(robot, instance, u);
    for (std::size_t i = 4; i < 8; ++i) EXPECT_EQ(f[i], 0.0) << form;
    const auto got = sum(robot.effects(), f);
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(got[k], u[k], 1e-12) << form;
  }
}

TEST(AllocationForms, ReversibleRotorsMeetCommandsByThrustsOfBothSigns) {
  for (const char* form : {"priority", "pseudo_inverse", "qp"}) {
    Robot robot = both_ways(-2246.0);
    const Instance instance("ctbt", robot.world, {{"allocation", form}});
    Group g = instance.group(1);
    g.input = {19.62, 0.1, -0.05, 0.02};
    instance.call(Call::kControl, g);
    std::vector<double> f;
    for (const double w : g.output) f.push_back(1.9533e-6 * w * std::fabs(w));
    for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(f[i] > 0.0, i < 4) << form;
    const auto got = sum(robot.effects(), f);
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(got[k], g.input[k], 1e-12) << form;
  }
}

TEST(AllocationForms, ReversibleRotorsStayWithinTheirLimits) {
  for (const char* form : {"priority", "pseudo_inverse", "qp"}) {
    Robot robot = both_ways(-1000.0);
    const Instance instance("ctbt", robot.world, {{"allocation", form}});
    std::mt19937_64 generator(5);
    for (int n = 0; n < 200; ++n) {
      Group g = instance.group(1);
      g.input = random_command(instance, generator, 2.0);
      instance.call(Call::kControl, g);
      for (const double w : g.output) {
        EXPECT_GE(w, -1000.0 * (1.0 + 1e-12)) << form;
        EXPECT_LE(w, 2246.0 * (1.0 + 1e-12)) << form;
      }
    }
  }
}

}  // namespace
}  // namespace skybody::testing
