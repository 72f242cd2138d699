// Randomizer `vehicle`: each quantity has its distribution, related quantities are correlated, and
// no draw is unphysical.
#include <algorithm>
#include <cmath>
#include <functional>

#include "core/base/math/inertia.h"
#include "core/base/math/math_normal.h"
#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;
using Numbers = std::vector<double>;

constexpr int kDraws = 10000;
constexpr double kGravity = 9.81, kDensity = 1.225;

/// The quantities of one draw, computed back from the EnvParams.
struct Drawn {
  double mass, arm, azimuth;
  double inertia[3];
  double rotor[SKYBODY_ROTOR_CONSTANT_COUNT];  ///< of the first rotor

  double full_thrust() const {
    const double w = rotor[SKYBODY_ROTOR_MAX_SPEED];
    return rotor[SKYBODY_ROTOR_THRUST_CONSTANT] * w * w;
  }
  double thrust_to_weight() const { return 4.0 * full_thrust() / (mass * kGravity); }
  double gyration() const { return std::sqrt(inertia[0] / mass) / arm; }
  double moment_arm() const {
    return rotor[SKYBODY_ROTOR_MOMENT_CONSTANT] / rotor[SKYBODY_ROTOR_THRUST_CONSTANT];
  }
  double torque_to_inertia() const { return std::sqrt(2.0) * arm * full_thrust() / inertia[0]; }
};

class VehicleDraws : public ::testing::Test {
 protected:
  VehicleDraws() { world.add_quad("quad"); }

  std::vector<Drawn> draw(const Parameters& given, int count = kDraws) {
    const Instance r("vehicle", world, given);
    Group g = r.group(1);
    std::vector<Drawn> drawn;
    for (int n = 0; n < count; ++n) {
      ++g.episode[0];
      r.call(Call::kRandomize, g);
      drawn.push_back(read(g));
    }
    return drawn;
  }

  Drawn read(const Group& g) const {
    const auto at = [&](int k) { return g.params[static_cast<std::size_t>(k)]; };
    const SkybodyBodyInfo& base = world.bodies[0];
    Drawn d{};
    d.mass = at(base.first_param + SKYBODY_BODY_MASS);
    for (int k = 0; k < 3; ++k) {
      d.inertia[k] = at(base.first_param + SKYBODY_BODY_INERTIA + k);
      EXPECT_EQ(at(base.first_param + SKYBODY_BODY_INERTIA + 3 + k), 0.0);
    }
    const int first = world.rotors[0].first_param;
    for (int k = 0; k < SKYBODY_ROTOR_CONSTANT_COUNT; ++k) d.rotor[k] = at(first + k);
    const double* hub = d.rotor + SKYBODY_ROTOR_POSITION;
    d.arm = std::hypot(hub[0], hub[1]);
    d.azimuth = std::atan2(hub[1], hub[0]);
    return d;
  }

  PluginWorld world;
};

using Quantity = std::function<double(const Drawn&)>;

Numbers values_of(const std::vector<Drawn>& drawn, const Quantity& quantity) {
  Numbers values;
  for (const Drawn& d : drawn) values.push_back(quantity(d));
  return values;
}

/// Largest difference between the empirical distribution and F (Kolmogorov-Smirnov), times the
/// square root of the count: above 1.95 with probability 1e-3.
double kolmogorov(Numbers values, const std::function<double(double)>& share_below) {
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  double most = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double f = share_below(values[i]);
    most = std::max({most, std::abs(f - static_cast<double>(i) / n),
                     std::abs(static_cast<double>(i + 1) / n - f)});
  }
  return most * std::sqrt(n);
}
constexpr double kRare = 1.95;

std::function<double(double)> uniform(double low, double high) {
  return [=](double x) { return std::clamp((x - low) / (high - low), 0.0, 1.0); };
}
/// Of the logarithm: normal about the middle, with the ends two deviations away.
std::function<double(double)> normal_between(double low, double high) {
  const double mean = 0.5 * (low + high), deviation = 0.25 * (high - low);
  const double below = normal_cdf(-2.0), between = normal_cdf(2.0) - below;
  return [=](double x) {
    return std::clamp((normal_cdf((x - mean) / deviation) - below) / between, 0.0, 1.0);
  };
}

/// Correlation and slope of y over x.
struct Line {
  double correlation, slope;
};
Line line_of(const Numbers& x, const Numbers& y) {
  const auto n = static_cast<double>(x.size());
  double mx = 0, my = 0, xx = 0, yy = 0, xy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) mx += x[i] / n, my += y[i] / n;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mx) * (x[i] - mx);
    yy += (y[i] - my) * (y[i] - my);
    xy += (x[i] - mx) * (y[i] - my);
  }
  return {xy / std::sqrt(xx * yy), xy / xx};
}

const Quantity kLogMass = [](const Drawn& d) { return std::log(d.mass); };

TEST_F(VehicleDraws, GivesTheBitsOfDouble) {
  for (const char* preset : {"scaling", "l2f", "raptor"}) {
    expect_same_bits("vehicle", world, {{"preset", preset}});
  }
  expect_same_bits("vehicle", world, {{"every", 3}, {"fleet", 7}});
}

TEST_F(VehicleDraws, EachQuantityHasItsDistribution) {
  const std::vector<Drawn> drawn = draw({});
  const auto expect = [&](const char* what, const Quantity& of,
                          const std::function<double(double)>& share_below) {
    EXPECT_LT(kolmogorov(values_of(drawn, of), share_below), kRare) << what;
  };
  const double third = 1.0 / 3.0, sixth = 1.0 / 6.0;
  expect("mass", kLogMass, uniform(std::log(0.03), std::log(30.0)));
  expect(
      "thrust_to_weight", [](auto& d) { return d.thrust_to_weight(); }, uniform(1.5, 4.0));
  expect(
      "arm", [=](auto& d) { return std::log(d.arm / std::pow(d.mass, third)); },
      normal_between(std::log(0.114), std::log(0.254)));
  const double nominal = std::atan2(0.127, 0.1016);
  expect(
      "sweep", [=](auto& d) { return d.azimuth - nominal; }, uniform(-0.12, 0.12));
  expect(
      "gyration", [](auto& d) { return d.gyration(); }, uniform(0.4, 0.65));
  expect(
      "pitch", [](auto& d) { return d.inertia[1] / d.inertia[0]; }, uniform(0.87, 1.15));
  expect(
      "yaw", [](auto& d) { return d.inertia[2] / (d.inertia[0] + d.inertia[1]); },
      uniform(0.75, 0.97));
  expect(
      "rolling moment",
      [](auto& d) {
        return d.rotor[SKYBODY_ROTOR_ROLLING_MOMENT_CONSTANT] /
               d.rotor[SKYBODY_ROTOR_THRUST_CONSTANT];
      },
      uniform(0.0, 0.12));
  expect(
      "spin_down",
      [=](auto& d) {
        const double hover =
            std::sqrt(d.mass * kGravity / 4.0 / d.rotor[SKYBODY_ROTOR_THRUST_CONSTANT]);
        return d.rotor[SKYBODY_ROTOR_INERTIA] /
               (2.0 * d.rotor[SKYBODY_ROTOR_MOMENT_CONSTANT] * hover) / std::pow(d.mass, sixth);
      },
      uniform(0.04, 0.15));
  expect(
      "tau_up", [=](auto& d) { return d.rotor[SKYBODY_ROTOR_TAU_UP] / std::pow(d.mass, sixth); },
      uniform(0.012, 0.06));
  expect(
      "tau_down",
      [](auto& d) { return d.rotor[SKYBODY_ROTOR_TAU_DOWN] / d.rotor[SKYBODY_ROTOR_TAU_UP]; },
      uniform(1.0, 2.0));
}

TEST_F(VehicleDraws, SizeRunsThroughAllThatFollowsFromIt) {
  const std::vector<Drawn> drawn = draw({});
  const Numbers mass = values_of(drawn, kLogMass);
  const auto against_mass = [&](const Quantity& of) {
    return line_of(mass, values_of(drawn, [&](const Drawn& d) { return std::log(of(d)); }));
  };
  // Slopes of laws, with about three of their standard errors: spread / (2 sqrt(n)).
  const Line arm = against_mass([](auto& d) { return d.arm; });
  EXPECT_NEAR(arm.slope, 1.0 / 3.0, 0.003);
  // sqrt(v / (v + s^2)), with v = (log(1000) / 3)^2 / 12 of the law, s = 0.176 of the residue.
  EXPECT_NEAR(arm.correlation, 0.967, 0.003);
  EXPECT_NEAR(against_mass([](auto& d) { return d.inertia[0]; }).slope, 5.0 / 3.0, 0.008);
  EXPECT_NEAR(against_mass([](auto& d) { return d.rotor[SKYBODY_ROTOR_TAU_UP]; }).slope, 1.0 / 6.0,
              0.008);
  // w_max^2 = T / k_f: m / m^(4/3).
  EXPECT_NEAR(against_mass([](auto& d) { return d.rotor[SKYBODY_ROTOR_MAX_SPEED]; }).slope,
              -1.0 / 6.0, 0.008);
  EXPECT_NEAR(against_mass([](auto& d) { return d.moment_arm(); }).slope, 1.0 / 3.0, 0.006);
  // Independent quantities: 4 / sqrt(n) is exceeded with probability 1 / 15,000.
  const double none = 4.0 / std::sqrt(kDraws);
  EXPECT_LT(std::abs(against_mass([](auto& d) { return d.thrust_to_weight(); }).correlation), none);
  EXPECT_LT(std::abs(against_mass([](auto& d) { return d.gyration(); }).correlation), none);
}

TEST_F(VehicleDraws, ThrustIsThatOfAPropellerOfTheDrawnRadius) {
  const Drawn d = draw({{"rotor_radius", Numbers{0.5, 0.5}},
                        {"thrust_coefficient", Numbers{0.1, 0.1}},
                        {"moment_by_radius", Numbers{0.2, 0.2}},
                        {"rotor_drag", Numbers{0.9, 0.9}}},
                       1)[0];
  const double radius = 0.5 * d.arm, w = 1000.0, turns = w / kTwoPi;
  const double thrust = 0.1 * kDensity * turns * turns * std::pow(2.0 * radius, 4.0);
  const double k = d.rotor[SKYBODY_ROTOR_THRUST_CONSTANT];
  EXPECT_NEAR(k * w * w, thrust, 1e-12 * thrust);
  EXPECT_NEAR(d.moment_arm(), 0.2 * radius, 1e-12 * radius);
  // At v = 0.1 w R across the axis: 0.9 times 0.1 of the thrust.
  EXPECT_NEAR(d.rotor[SKYBODY_ROTOR_DRAG_CONSTANT] * w * (0.1 * w * radius), 0.09 * thrust,
              1e-12 * thrust);
}

TEST_F(VehicleDraws, PresetsHaveTheRangesOfTheirSources) {
  for (const char* preset : {"l2f", "raptor"}) {
    const bool is_raptor = std::string(preset) == "raptor";
    const std::vector<Drawn> drawn = draw({{"preset", preset}});
    const auto expect = [&](const char* what, const Quantity& of,
                            const std::function<double(double)>& share_below) {
      EXPECT_LT(kolmogorov(values_of(drawn, of), share_below), kRare) << preset << " " << what;
    };
    expect(
        "size", [](auto& d) { return std::cbrt(d.mass); },
        uniform(std::cbrt(0.02), std::cbrt(5.0)));
    expect(
        "thrust_to_weight", [](auto& d) { return d.thrust_to_weight(); }, uniform(1.5, 5.0));
    expect(
        "moment arm", [](auto& d) { return d.moment_arm(); }, uniform(0.005, 0.05));
    if (is_raptor) {
      expect(
          "torque_to_inertia", [](auto& d) { return d.torque_to_inertia(); },
          uniform(40.0, 1200.0));
      expect(
          "tau_up", [](auto& d) { return d.rotor[SKYBODY_ROTOR_TAU_UP]; }, uniform(0.03, 0.1));
      expect(
          "tau_down", [](auto& d) { return d.rotor[SKYBODY_ROTOR_TAU_DOWN]; }, uniform(0.03, 0.3));
    } else {
      expect(
          "weight_by_turn", [](auto& d) { return d.thrust_to_weight() / d.torque_to_inertia(); },
          uniform(0.001, 0.1));
      EXPECT_NEAR(drawn[0].rotor[SKYBODY_ROTOR_TAU_UP], 0.0690909, 1e-12);
    }
  }
}

TEST_F(VehicleDraws, NoInertiaIsUnphysicalAndHubsStayInRows) {
  for (const char* preset : {"scaling", "l2f", "raptor"}) {
    const Instance r("vehicle", world, {{"preset", preset}});
    Group g = r.group(1);
    for (int n = 0; n < kDraws; ++n) {
      ++g.episode[0];
      r.call(Call::kRandomize, g);
      const Drawn d = read(g);
      ASSERT_TRUE(is_physical_inertia(
          SymMat3<double>{d.inertia[0], d.inertia[1], d.inertia[2], 0.0, 0.0, 0.0}));
      for (const SkybodyRotorInfo& rotor : world.rotors) {
        const double* hub = g.params.data() + rotor.first_param + SKYBODY_ROTOR_POSITION;
        const double* first = d.rotor + SKYBODY_ROTOR_POSITION;
        ASSERT_EQ(hub[0], std::copysign(first[0], rotor.position[0]));
        ASSERT_EQ(hub[1], std::copysign(first[1], rotor.position[1]));
        ASSERT_EQ(hub[2], first[2]);
      }
    }
  }
}

TEST_F(VehicleDraws, DrawsByItsScheduleAndEachRobotForItself) {
  world.add_quad("other", 3.0);
  const Instance r("vehicle", world, {{"every", 2}});
  EXPECT_EQ(r.declared.writes.size(), 2u * (1 + 6 + 4 * SKYBODY_ROTOR_CONSTANT_COUNT));
  Group g = r.group(1);
  const auto mass = [&](int robot) {
    return g.params[static_cast<std::size_t>(
        world.bodies[static_cast<std::size_t>(robot)].first_param)];
  };
  double last = 0.0;
  for (int n = 0; n < 6; ++n) {
    ++g.episode[0];
    r.call(Call::kRandomize, g);
    EXPECT_EQ(mass(0) != last, n % 2 == 0);
    EXPECT_NE(mass(0), mass(1));
    last = mass(0);
  }
  r.call(Call::kRequest, g);
  EXPECT_NE(mass(0), last);
  const Instance one("vehicle", world, {{"robot", "other"}});
  Group h = one.group(1);
  one.call(Call::kRandomize, h);
  EXPECT_EQ(h.params[static_cast<std::size_t>(world.bodies[0].first_param)], 1.54);
}

TEST_F(VehicleDraws, AFleetHasItsNumberOfVehiclesWhoeverDraws) {
  const Instance r("vehicle", world, {{"fleet", 5}});
  std::map<double, int> met;
  for (const std::uint64_t env : {0, 1}) {
    Group g = r.group(1);
    g.key[1] = env;
    for (int n = 0; n < 500; ++n) {
      ++g.episode[0];
      r.call(Call::kRandomize, g);
      ++met[read(g).mass];
    }
  }
  EXPECT_EQ(met.size(), 5u);
  for (const auto& [mass, count] : met) EXPECT_NEAR(count, 200, 65) << "five deviations";
}

TEST_F(VehicleDraws, BadConfigurationNamesValueAndRemedy) {
  const auto refused = [&](const Parameters& given) { return refusal("vehicle", world, given); };
  EXPECT_THAT(refused({{"mass", Numbers{2.0, 1.0}}}),
              HasSubstr("`mass` [2, 1] runs backwards: write [low, high]"));
  EXPECT_THAT(refused({{"mass", Numbers{2.0}}}), HasSubstr("`mass` has 1 values"));
  EXPECT_THAT(refused({{"gyration", Numbers{0.5, 0.6}}, {"torque_to_inertia", Numbers{100, 200}}}),
              HasSubstr("`gyration` and `torque_to_inertia` stand for one another: leave one"));
  EXPECT_THAT(
      refused({{"pitch_inertia", Numbers{0.1, 1.0}}}),
      HasSubstr("`pitch_inertia` [0.1, 1] and `yaw_inertia` [0.75, 0.97] include moments of "
                "inertia that no rigid body has"));
  EXPECT_THAT(refused({{"robot", "q"}}), HasSubstr("no robot `q`"));
  PluginWorld loaded;
  loaded.add_quad("quad");
  loaded.add_payload("bob");
  EXPECT_THAT(refusal("vehicle", loaded, {}), HasSubstr("robot `quad` has joints"));
  PluginWorld fixed;
  fixed.add_quad("quad");
  fixed.robots[0].fixed_base = 1;
  EXPECT_THAT(refusal("vehicle", fixed, {}), HasSubstr("robot `quad` has a fixed base"));
  PluginWorld turning;
  turning.add_quad("quad");
  turning.rotors[0].direction = 1.0;
  EXPECT_THAT(refusal("vehicle", turning, {}), HasSubstr("let two be ccw and two cw"));
  PluginWorld tilted;
  tilted.add_quad("quad");
  tilted.rotors[1].axis[0] = 0.1;
  EXPECT_THAT(refusal("vehicle", tilted, {}), HasSubstr("does not push along the body's z"));
  PluginWorld central;
  central.add_quad("quad");
  for (double& p : central.rotors[2].position) p = 0.0;
  EXPECT_THAT(refusal("vehicle", central, {}), HasSubstr("sits on the body's z axis"));
  PluginWorld few;
  few.add_quad("quad");
  few.robots[0].rotor_count = 3;
  EXPECT_THAT(refusal("vehicle", few, {}), HasSubstr("has 3 rotors: a vehicle has 4"));
}

}  // namespace
}  // namespace skybody::testing
