// Sensors in the engine, against loads that are known: the weight of a vehicle that stands or
// hangs, an accelerated frame, the pack of the effect `battery`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/base/system/error.h"
#include "core/simulation/simulation.h"

namespace skybody {
namespace {

using testing::HasSubstr;
constexpr double kGravity = 9.81;

/// A shipped scenario without draws, with these sensors.
Simulation flight(const std::string& name, const std::string& sensors,
                  std::vector<std::string> more = {}) {
  more.push_back("randomization=[]");
  more.push_back("sensors=" + sensors);
  Simulation simulation({.scenario = name, .overrides = more});
  simulation.reset();
  return simulation;
}

TEST(SensedLoads, AVehicleAtRestIsCarriedByItsContacts) {
  Simulation world = flight("hover",
                            "[{plugin: contact, name: all}, {plugin: contact, name: ground, "
                            "parameters: {partner: ground}}]",
                            {"robots[0].rotor_speed=0", "robots[0].pose.position=[0, 0, 0.2]"});
  EXPECT_EQ(world.sensors()[6], 0.0) << "it starts in the air";
  ASSERT_TRUE(world.advance(4000));
  const double weight = kGravity * world.mass_properties("quad", "base_link").mass;
  const std::vector<double> seen = world.sensors();
  for (const std::size_t first : {0u, 7u}) {
    // It has come to rest but for what the contact's damping leaves after 4 s.
    EXPECT_NEAR(seen[first + 2], weight, 1e-3 * weight);
    EXPECT_NEAR(seen[first], 0.0, 1e-3 * weight);
    EXPECT_NEAR(seen[first + 1], 0.0, 1e-3 * weight);
    EXPECT_EQ(seen[first + 6], 1.0);
  }
}

/// Mass below the joint of the rod [kg].
double hanging(const Simulation& world) {
  return world.mass_properties("quad", "rod").mass + world.mass_properties("quad", "bob").mass;
}

TEST(SensedLoads, AHangingPayloadPullsWithItsWeightInAnAcceleratedFrameToo) {
  Simulation world = flight("payload", "[{plugin: force_torque, parameters: {joint: rod_joint}}]",
                            {"robots[0].controllers=[{plugin: wrench}]"});
  const double below = hanging(world);
  const double all = below + world.mass_properties("quad", "base_link").mass;
  for (const double acceleration : {0.0, 3.0, -kGravity}) {
    world.command("quad", std::vector<double>{0, 0, all * (kGravity + acceleration), 0, 0, 0});
    ASSERT_TRUE(world.advance(20));
    const std::vector<double> seen = world.sensors();
    // The force of the joint on the rod points up; no rounding is worse than 1e-9 N.
    EXPECT_NEAR(seen[2], below * (kGravity + acceleration), 1e-9) << acceleration;
    for (const std::size_t i : {0u, 1u, 3u, 4u, 5u}) EXPECT_NEAR(seen[i], 0.0, 1e-9) << i;
  }
}

TEST(SensedLoads, TheBatteryMonitorReadsTheEffect) {
  Simulation world = flight("hover", "[{plugin: battery, name: monitor}]",
                            {"effects=[{plugin: battery, parameters: {capacity: 0.5}}]"});
  EXPECT_NEAR(world.sensors()[0], 4 * 4.2, 1e-12) << "no load yet";
  EXPECT_EQ(world.sensors()[2], 1.0);
  world.command("quad", std::vector<double>(4, 1200.0));
  double charge = 1.0;
  for (int n = 0; n < 500; ++n) {
    ASSERT_TRUE(world.advance(1));
    const std::vector<double> seen = world.sensors();
    EXPECT_GT(seen[1], 1.0) << "the rotors take current";
    charge -= seen[1] * 0.001 / 3600.0 / 0.5;
    EXPECT_NEAR(seen[2], charge, 1e-12) << "500 roundings";
    // The open voltage of four cells above 90 % of the charge, less 0.02 ohm.
    const double open = seen[0] + 0.02 * seen[1];
    EXPECT_LE(open, 4 * 4.2);
    EXPECT_GT(open, 4 * 4.11);
  }
}

TEST(SensedLoads, AMonitorWithoutAPackIsRefused) {
  try {
    flight("hover", "[{plugin: battery, name: monitor}]");
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("sensor `monitor` reads `battery.voltage` of robot `quad`, and no effect "
                          "gives it: add the effect `battery`, or remove the sensor"));
  }
}

TEST(SensedLoads, AnErrorWithItsDefaultCannotBeDrawn) {
  try {
    Simulation world({.scenario = "hover",
                      .overrides = {"sensors=[{plugin: gnss}]",
                                    "randomization=[{plugin: draw, parameters: {what: "
                                    "[sensors.gnss.vertical_noise], range: [0, 1]}}]"}});
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("`vertical_noise` has its default; set it in the scenario"));
  }
}

TEST(SensedLoads, AGivenErrorIsDrawnInEveryEpisode) {
  Simulation world({.scenario = "hover",
                    .overrides = {"sensors=[{plugin: gnss, parameters: {vertical_noise: 0.1}}]",
                                  "randomization=[{plugin: draw, parameters: {what: "
                                  "[sensors.gnss.vertical_noise], range: [1, 2]}}]"}});
  world.reset();
  const double first = world.param("sensors.gnss.vertical_noise");
  world.reset();
  const double second = world.param("sensors.gnss.vertical_noise");
  EXPECT_GE(first, 1.0);
  EXPECT_LE(first, 2.0);
  EXPECT_NE(first, second);
}

}  // namespace
}  // namespace skybody
