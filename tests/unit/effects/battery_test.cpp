// A battery against its equations: duration, voltage sag, limits of the rotor speeds.
#include <cmath>
#include <numeric>

#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using ::testing::HasSubstr;

class BatteryTest : public ::testing::Test {
 protected:
  BatteryTest() { world.add_quad("quad"); }

  /// One physics step with all rotors at this speed, from the engine's neutral values.
  static void step(const Instance& battery, Group& g, double speed) {
    std::fill(g.rotor_speed.begin(), g.rotor_speed.end(), speed);
    g.held = battery.group(g.lanes).held;
    battery.call(Call::kApply, g);
    ++g.physics_step[0];
  }
  static double greatest(const Group& g, int rotor) {
    return g.held[SKYBODY_HELD_ROTOR_LIMIT][static_cast<std::size_t>(2 * rotor + 1)];
  }
  /// Power of the quad's four rotors at this speed [W]; QDrone2's k_m.
  static double power(double speed, double efficiency, double hotel) {
    return 4.0 * 2.8401e-8 * speed * speed * speed / efficiency + hotel;
  }
  static double current(double open, double resistance, double power) {
    const double root = std::sqrt(open * open - 4.0 * resistance * power);
    return (open - root) / (2.0 * resistance);
  }
  PluginWorld world;
  Parameters flat{{"open_circuit", Numbers{3.7, 3.7}},
                  {"internal_resistance", 0.03},
                  {"capacity", 0.01},
                  {"initial_charge", 0.8},
                  {"hotel_power", 5.0}};
};

TEST_F(BatteryTest, GivesTheBitsOfDouble) {
  expect_same_bits("battery", world);
  expect_same_bits("battery", world, {{"capacity", 1e-4}});  // runs empty within a few steps
}

TEST_F(BatteryTest, OfAFlatCurveIsEmptyAtTheTimeOfTheClosedForm) {
  const Instance battery("battery", world, flat);
  Group g = battery.group(1);
  battery.call(Call::kReset, g);
  const double open = 4 * 3.7, amperes = current(open, 0.03, power(1400.0, 0.7, 5.0));
  int steps = 0;
  while (g.buffer[0] > 0.0 && steps < 100000) {
    step(battery, g, 1400.0);
    ++steps;
    ASSERT_NEAR(g.buffer[1], open - 0.03 * amperes, 1e-11);  // rounding of two forms of the root
    ASSERT_NEAR(g.buffer[2], amperes, 1e-11);
  }
  EXPECT_NEAR(steps * 0.001, 0.8 * 3600.0 * 0.01 / amperes,
              0.001);  // the step in which it becomes empty
  step(battery, g, 1400.0);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(greatest(g, i), 0.0);
  EXPECT_EQ(g.buffer, (Numbers{0.0, open, 0.0}));
}

TEST_F(BatteryTest, GivesTheEnergyThatTheRotorsTake) {
  const Instance battery("battery", world, {{"capacity", 0.02}, {"hotel_power", 2.0}});
  Group g = battery.group(1);
  battery.call(Call::kReset, g);
  double taken = 0.0, given = 0.0, charge = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double speed = 1200.0 + 0.4 * i;
    step(battery, g, speed);
    taken += power(speed, 0.7, 2.0) * 0.001;
    given += g.buffer[1] * g.buffer[2] * 0.001;
    charge += g.buffer[2] * 0.001;
  }
  EXPECT_NEAR(given, taken, 1e-11 * taken);  // rounding of a thousand sums
  EXPECT_NEAR(1.0 - g.buffer[0], charge / (3600.0 * 0.02), 1e-12);
  EXPECT_GT(1.0 - g.buffer[0], 0.3);
}

TEST_F(BatteryTest, SagsAndLimitsTheSpeedByTheVoltage) {
  const Instance nominal("battery", world, {{"internal_resistance", 0.05}});
  const Instance by_volt("battery", world,
                         {{"internal_resistance", 0.05}, {"speed_per_volt", 130.0}});
  const double amperes = current(16.8, 0.05, power(1500.0, 0.7, 0.0));
  const double voltage = 16.8 - 0.05 * amperes;
  for (const Instance* battery : {&nominal, &by_volt}) {
    Group g = battery->group(1);
    battery->call(Call::kReset, g);
    step(*battery, g, 1500.0);
    const double per_volt = battery == &nominal ? 2246.0 / 16.8 : 130.0;
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(greatest(g, i), per_volt * voltage, 1e-9);
    EXPECT_EQ(g.held[SKYBODY_HELD_ROTOR_LIMIT][0], 0.0);
  }
}

TEST_F(BatteryTest, WithoutCurrentHasTheVoltageOfItsCharge) {
  const std::pair<double, double> known[] = {{1e-15, 3.27}, {0.05, 3.48},  {0.1, 3.69},
                                             {0.5, 3.84},   {0.75, 3.985}, {1.0, 4.2}};
  for (const auto& [charge, volts] : known) {
    const Instance battery("battery", world, {{"initial_charge", charge}, {"cells", 6}});
    Group g = battery.group(1);
    battery.call(Call::kReset, g);
    EXPECT_NEAR(g.buffer[1], 6 * volts, 1e-13);
    step(battery, g, 0.0);
    EXPECT_EQ(g.buffer[0], charge);
    EXPECT_NEAR(g.buffer[1], 6 * volts, 1e-13);
  }
}

TEST_F(BatteryTest, GivesNoMoreThanItsGreatestPower) {
  const Instance battery("battery", world, {{"internal_resistance", 0.1}});
  Group g = battery.group(1);
  battery.call(Call::kReset, g);
  step(battery, g, 2200.0);  // draws 1728 W of 706
  EXPECT_NEAR(g.buffer[1], 8.4, 1e-12);
  EXPECT_NEAR(g.buffer[2], 84.0, 1e-10);
  EXPECT_NEAR(greatest(g, 0), 1123.0, 1e-9);
}

TEST_F(BatteryTest, WithoutResistanceDoesNotSag) {
  const Instance battery("battery", world, {{"internal_resistance", 0.0}});
  Group g = battery.group(1);
  battery.call(Call::kReset, g);
  step(battery, g, 2000.0);
  EXPECT_NEAR(g.buffer[1], 16.8, 1e-13);
  EXPECT_NEAR(g.buffer[2], power(2000.0, 0.7, 0.0) / 16.8, 1e-10);
}

TEST_F(BatteryTest, IsOnePackARobot) {
  world.add_quad("other");
  const Instance all("battery", world);
  EXPECT_EQ(all.declared.memory.buffer_words, 6);
  const Instance one("battery", world, {{"robots", std::vector<std::string>{"other"}}});
  Group g = one.group(1);
  one.call(Call::kReset, g);
  step(one, g, 1000.0);
  EXPECT_EQ(greatest(g, 0), kInfinity);
  EXPECT_LT(greatest(g, 4), 2246.0);
}

TEST_F(BatteryTest, ReportsChargeVoltageAndCurrent) {
  const Instance battery("battery", world);
  ASSERT_EQ(battery.declared.reports.size(), 3u);
  const char* names[] = {"charge", "voltage", "current"};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(battery.declared.reports[i].info.name, names[i]);
    EXPECT_EQ(battery.declared.reports[i].word, static_cast<int>(i));
  }
}

TEST_F(BatteryTest, DerivativesAreThoseOfItsDifferences) {
  expect_derivatives({"battery", world, {{"initial_charge", 0.55}}, Call::kApply, {}},
                     {"buffer", "params", "rotor_speed"});
}

TEST_F(BatteryTest, SaysWhatDoesNotFit) {
  const auto refused = [&](const Parameters& given) { return refusal("battery", world, given); };
  EXPECT_THAT(refused({{"open_circuit", Numbers{3.7}}}), HasSubstr("`open_circuit` has 1 values"));
  EXPECT_THAT(refused({{"open_circuit", Numbers{4.2, 3.7, 3.2}}}),
              HasSubstr("`open_circuit[1]` is 3.7 V, below the 4.2 V before it"));
  EXPECT_THAT(refused({{"initial_charge", 0.0}}),
              HasSubstr("`initial_charge` is 0, an empty pack"));
  EXPECT_THAT(refused({{"internal_resistance", 20.0}}),
              HasSubstr("a full pack gives 3.528 W at most (16.8 V, `internal_resistance` 20 ohm), "
                        "and robot `quad` takes 436"));
  EXPECT_THAT(refused({{"robots", std::vector<std::string>{"quda"}}}),
              HasSubstr("no robot `quda`: there are quad"));
  EXPECT_THAT(refused({{"robots", std::vector<std::string>{"quad", "quad"}}}),
              HasSubstr("`robots` names `quad` twice"));
  world.robots[0].rotor_count = 0;
  EXPECT_THAT(refused({}), HasSubstr("no robot has rotors, which `battery` acts on"));
  EXPECT_THAT(refused({{"robots", std::vector<std::string>{"quad"}}}),
              HasSubstr("robot `quad` has no rotors, which `battery` acts on"));
}

}  // namespace
}  // namespace skybody::testing
