// One world under direct control, over shipped scenarios: commands, physics steps, teleporting,
// accelerations, contacts, mass properties.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/base/system/error.h"
#include "core/simulation/simulation.h"

namespace skybody {
namespace {

using testing::HasSubstr;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Hover at (0, 0, 2) with a chain of controllers, without random starts.
Simulation hover(const std::string& controllers = "[{plugin: rotor_speed}]",
                 std::vector<std::string> more = {}) {
  more.push_back("robots[0].controllers=" + controllers);
  more.push_back("randomization=[]");
  more.push_back("robots[0].pose.position=[0, 0, 2]");
  Simulation simulation({.scenario = "hover", .overrides = more});
  simulation.reset();
  return simulation;
}

/// The message of the exception that `call` throws.
template <class Call>
std::string refusal(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

/// Sends a command, advances `n` steps, and returns the position.
Vec3<double> fly(Simulation& world, const std::vector<double>& command, int n) {
  world.command("quad", command);
  EXPECT_TRUE(world.advance(n));
  return world.bodies()[0].position;
}

TEST(DirectControl, EveryModeFlies) {
  const double weight = 9.81 * hover().mass_properties("quad", "base_link").mass;
  {
    Simulation world = hover();
    EXPECT_GT(fly(world, {2000, 2000, 2000, 2000}, 500).z, 2.05);
  }
  {
    Simulation world = hover("[{plugin: srt}]");
    EXPECT_GT(fly(world, std::vector<double>(4, 0.3 * weight), 500).z, 2.05);
  }
  for (const char* chain : {"[{plugin: ctbt}]", "[{plugin: ctbr}]"}) {
    Simulation world = hover(chain);
    EXPECT_GT(fly(world, {1.2 * weight, 0, 0, 0}, 500).z, 2.05) << chain;
  }
  {
    Simulation world = hover("[{plugin: wrench}]");
    EXPECT_GT(fly(world, {0.1 * weight, 0, weight, 0, 0, 0}, 500).x, 0.05);
  }
  {
    Simulation world = hover("[{plugin: velocity}]");
    // A driven base follows its command exactly: 1 m/s for 0.5 s; sums of 500 steps round to 1e-12.
    EXPECT_NEAR(fly(world, {1, 0, 0, 0, 0, 0}, 500).x, 0.5, 1e-12);
  }
  {
    Simulation world = hover("[{plugin: attitude}, {plugin: ctbr}]");
    const double half = std::sin(0.05);  // pitched forwards by 0.1 rad
    EXPECT_GT(fly(world, {weight, std::cos(0.05), 0, half, 0}, 500).x, 0.02);
  }
  {
    Simulation world = hover("[{plugin: position}, {plugin: attitude}, {plugin: ctbr}]");
    const Vec3<double> end = fly(world, {1, -1, 1.5, 0}, 8000);
    // The chain has no error at rest; after 8 s the slowest mode (about 1.6 rad/s) has decayed.
    EXPECT_NEAR(end.x, 1.0, 1e-3);
    EXPECT_NEAR(end.y, -1.0, 1e-3);
    EXPECT_NEAR(end.z, 1.5, 1e-3);
  }
}

TEST(DirectControl, AnActionAndItsCommandDoTheSameBitForBit) {
  Simulation by_action = hover(), by_command = hover();
  const std::vector<float> action = {0.25f, 0.5f, 0.25f, 0.5f};
  const double full = by_action.rotor_parameter("quad", 0, "max_speed");
  std::vector<double> command;
  for (const float a : action) command.push_back(0.5 * (static_cast<double>(a) + 1.0) * full);
  for (int k = 0; k < 20; ++k) {
    by_action.step(action);
    by_command.command("", command);
    EXPECT_TRUE(by_command.advance(by_command.scenario().stepping.action_repeat));
    by_command.evaluate();
  }
  EXPECT_EQ(by_command.physics_steps(), by_action.physics_steps());
  EXPECT_EQ(by_command.steps(), by_action.steps());
  // 14 values of motion; then the last action, and here there was none.
  for (std::size_t k = 0; k < 14; ++k) {
    EXPECT_EQ(by_command.observation()[k], by_action.observation()[k]) << k;
  }
  EXPECT_EQ(by_command.bodies()[0].position.z, by_action.bodies()[0].position.z);
}

TEST(DirectControl, AdvancingInPartsIsAdvancingAtOnce) {
  Simulation whole = hover("[{plugin: ctbr}]"), parts = hover("[{plugin: ctbr}]");
  const std::vector<double> command = {12.0, 0.5, -0.5, 0.2};
  for (Simulation* world : {&whole, &parts}) world->command("", command);
  EXPECT_TRUE(whole.advance(300));
  for (int k = 0; k < 300; k += 50) EXPECT_TRUE(parts.advance(50));
  EXPECT_TRUE(parts.advance(0));
  EXPECT_EQ(whole.save().words, parts.save().words);
  EXPECT_EQ(whole.physics_steps(), 300u);
  EXPECT_EQ(whole.steps(), 0u);  // the task was not evaluated
}

TEST(DirectControl, EvaluateEndsATransitionAndTheHorizonCounts) {
  Simulation world = hover("[{plugin: ctbr}]", {"stepping.horizon=3"});
  for (int k = 1; k <= 3; ++k) {
    EXPECT_TRUE(world.advance(1));
    world.evaluate();
    EXPECT_EQ(world.steps(), static_cast<std::uint64_t>(k));
    EXPECT_EQ(world.truncated(), k == 3);
  }
}

TEST(DirectControl, PhysicsThatGivesUpEndsTheEpisodeAsAFaultUntilAReset) {
  Simulation world = hover();
  BodyState fast = world.bodies()[0];
  fast.velocity.x = 1e308;  // position overflows after some steps
  fast.velocity.y = 1e308;
  fast.angular_velocity = {1e200, 1e200, 0};  // w x J w overflows at once
  world.teleport("", fast);
  EXPECT_FALSE(world.advance(10));
  EXPECT_FALSE(world.advance(10));
  EXPECT_TRUE(world.fault());
  EXPECT_TRUE(world.truncated());
  EXPECT_EQ(world.physics_steps(), 0u);
  EXPECT_EQ(world.bodies()[0].angular_velocity.x, 1e200);  // the last finite state
  world.evaluate();
  EXPECT_TRUE(world.fault());
  EXPECT_EQ(world.reward(), 0.0f);
  world.reset();
  EXPECT_FALSE(world.fault());
  EXPECT_TRUE(world.advance(10));
}

TEST(DirectControl, RefusesCommandsThatCannotBe) {
  Simulation world = hover();
  const std::vector<double> three(3), four(4), bad = {1, 2, kNone, 4};
  EXPECT_THAT(refusal([&] { world.command("", three); }),
              HasSubstr("command has 3 values; expected 4"));
  EXPECT_THAT(refusal([&] { world.command("", bad); }), HasSubstr("value 2 is nan"));
  EXPECT_THAT(refusal([&] { world.command("nobody", four); }), HasSubstr("there are quad"));
  EXPECT_THAT(refusal([&] { world.advance(-1); }), HasSubstr("-1"));
  Simulation idle({.scenario = "hover"});
  EXPECT_THAT(refusal([&] { idle.command("", four); }), HasSubstr("before reset()"));
  EXPECT_THAT(refusal([&] { idle.advance(1); }), HasSubstr("before reset()"));
  EXPECT_THAT(refusal([&] { idle.evaluate(); }), HasSubstr("before reset()"));
}

TEST(DirectControl, TeleportMovesTheBaseAndKeepsTheRest) {
  Simulation world({.scenario = "payload", .seed = 3});
  world.reset();
  world.advance(200);
  const std::vector<double> rotors = world.rotor_speeds();
  const Snapshot before = world.save();
  const BodyState bob = world.body("quad", "bob"), base = world.body("quad", "base_link");
  BodyState to = base;
  to.position = {1, 2, 7};
  to.rotation = {2 * base.rotation.w, 2 * base.rotation.x, 2 * base.rotation.y,
                 2 * base.rotation.z};  // the same rotation
  world.teleport("quad", to);
  EXPECT_EQ(world.body("quad", "base_link").position.x, 1.0);
  EXPECT_EQ(world.rotor_speeds(), rotors);
  // The bob moves with the base: its relative position is unchanged, up to rounding at 10 m.
  const Vec3<double> was = bob.position - base.position;
  const Vec3<double> is = world.body("quad", "bob").position - to.position;
  EXPECT_NEAR(norm(is - was), 0.0, 1e-14);
  world.restore(before);
  EXPECT_EQ(world.save().words, before.words);
}

TEST(DirectControl, RefusesToTeleportWhereNobodyCanBe) {
  Simulation world = hover();
  BodyState to;
  to.position.y = kNone;
  EXPECT_THAT(refusal([&] { world.teleport("", to); }), HasSubstr("value 1 is nan"));
  to.position.y = 0;
  to.rotation = {0, 0, 0, 0};
  EXPECT_THAT(refusal([&] { world.teleport("", to); }), HasSubstr("zero quaternion"));
}

TEST(DirectControl, AccelerationsAreTheDerivativeOfTheBodiesMotion) {
  // Chains of joints, with rotors whose thrust is unbalanced.
  Simulation world(
      {.scenario = "payload", .overrides = {"sensors=[]", "stepping.dt=1e-6"}, .seed = 8});
  world.reset();
  BodyState turning = world.body("quad", "base_link");
  turning.angular_velocity = {1.5, -2.0, 0.7};
  turning.velocity = {1, 2, -1};
  world.teleport("", turning);
  world.command("", std::vector<double>{900, 1000, 1100, 1200});
  ASSERT_TRUE(world.advance(1000));  // 1 ms: joints move as well
  // A central difference over one microsecond to either side of the middle. Truncation: h^2 times
  // the third derivative (some 1e4 1/s^4) is below 1e-7; rounding 1e-15 / 1e-6 is 1e-9. The rotors'
  // lag and the integrator's order give the step itself an error of O(h): 1e-6 of 1e2.
  const std::vector<BodyState> before = world.bodies();
  ASSERT_TRUE(world.advance(1));
  const Accelerations now = world.accelerations();
  ASSERT_TRUE(world.advance(1));
  const std::vector<BodyState> after = world.bodies();
  ASSERT_EQ(now.bodies.size(), before.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Vec3<double> linear = (after[i].velocity - before[i].velocity) / 2e-6;
    const Vec3<double> angular = (after[i].angular_velocity - before[i].angular_velocity) / 2e-6;
    EXPECT_NEAR(norm(linear - now.bodies[i].linear), 0.0, 2e-3) << i;
    EXPECT_NEAR(norm(angular - now.bodies[i].angular), 0.0, 2e-3 * (1 + norm(angular))) << i;
    largest = std::max(largest, norm(angular));
  }
  EXPECT_GT(largest, 1.0);  // otherwise the test is void
}

TEST(DirectControl, AFreeFallHasTheAccelerationOfGravity) {
  Simulation world = hover();
  const Accelerations a = world.accelerations();
  // Rotors begin at hover speed: no acceleration. Without them, gravity's.
  EXPECT_NEAR(a.bodies[0].linear.z, 0.0, 1e-9);
  for (int r = 0; r < 4; ++r) world.set_rotor_parameter("", r, "thrust_constant", 0.0);
  EXPECT_NEAR(world.accelerations().bodies[0].linear.z, -9.81, 0.02);  // 9.80665 or 9.81
  EXPECT_EQ(world.accelerations().udot.size(), 6u);
}

TEST(DirectControl, GroundContactsCarryTheWeightOfARestingRobot) {
  Simulation world = hover();
  EXPECT_TRUE(world.contacts().empty());
  BodyState low = world.bodies()[0];
  low.position.z = 0.1;
  low.velocity = {0, 0, 0};
  world.teleport("", low);
  world.command("", std::vector<double>(4, 0.0));
  ASSERT_TRUE(world.advance(5000));
  const std::vector<Contact> contacts = world.contacts();
  ASSERT_GE(contacts.size(), 3u);
  double sum = 0.0;
  for (const Contact& contact : contacts) {
    EXPECT_EQ(contact.other, kGround);
    EXPECT_EQ(contact.normal.z, 1.0);
    EXPECT_NEAR(contact.point.z, -contact.depth, 0.0);
    EXPECT_GT(contact.depth, 0.0);
    sum += contact.force.z;
  }
  const double weight = world.mass_properties("", "base_link").mass * -world.scenario().gravity().z;
  // At rest after 5 s: forces of the remaining motion are far below a millinewton.
  EXPECT_NEAR(sum, weight, 1e-3 * weight);
}

TEST(DirectControl, AnObstacleCarriesTheWeightOfWhatRestsOnIt) {
  Simulation world =
      hover("[{plugin: rotor_speed}]",
            {"obstacles=[{name: table, box: [0.8, 0.8, 0.2], position: [0, 0, 1]}]"});
  BodyState low = world.bodies()[0];
  low.position.z = 1.2;
  world.teleport("", low);
  world.command("", std::vector<double>(4, 0.0));
  ASSERT_TRUE(world.advance(1200));
  double sum = 0.0;
  for (const Contact& contact : world.contacts()) {
    EXPECT_EQ(contact.other, kFirstObstacle);
    EXPECT_GT(contact.normal.z, 0.9);  // pushed upwards
    EXPECT_GT(contact.depth, 0.0);
    EXPECT_NEAR(contact.point.z, 1.1, 0.01);  // the table's top
    sum += contact.force.z;
  }
  const double weight = world.mass_properties("", "base_link").mass * -world.scenario().gravity().z;
  EXPECT_NEAR(sum, weight, 0.02 * weight);  // meshes creep slightly
}

TEST(DirectControl, ContactsOfRobotsAreTheForcesThatMoveThem) {
  Simulation world({.scenario = "formation_2", .overrides = {"randomization=[]"}});
  world.reset();
  EXPECT_TRUE(world.contacts().empty());
  const auto& robots = world.scenario().robots;
  BodyState beside = world.base(robots[0].name);
  beside.position.x += 0.2;  // less than the width of a vehicle
  world.teleport(robots[1].name, beside);
  const std::vector<Contact> contacts = world.contacts();
  ASSERT_FALSE(contacts.empty());
  std::vector<Vec3<double>> sum(world.bodies().size(), Vec3<double>{0, 0, 0});
  for (const Contact& contact : contacts) {
    ASSERT_GE(contact.other, 0);
    EXPECT_NEAR(norm(contact.normal), 1.0, 1e-12);
    EXPECT_GT(contact.depth, 0.0);
    EXPECT_GT(dot(contact.force, contact.normal), 0.0);
    sum[static_cast<std::size_t>(contact.body)] += contact.force;
    sum[static_cast<std::size_t>(contact.other)] -= contact.force;
  }
  // Rotors carry the weight, so no other force moves them.
  const Accelerations now = world.accelerations();
  for (std::size_t r = 0; r < robots.size(); ++r) {
    const std::string& base = robots[r].model.bodies[0].name;
    const MassProperties mass = world.mass_properties(robots[r].name, base);
    const auto i = static_cast<std::size_t>(world.compiled().layout().robots[r].first_body);
    const Vec3<double> of_com = now.bodies[i].linear + cross(now.bodies[i].angular, mass.com);
    EXPECT_GT(norm(sum[i]), 1.0);
    // Sums of hundreds of elements' forces of up to 1e3 N: rounding stays below 1e-10 of them.
    EXPECT_NEAR(norm(of_com * mass.mass - sum[i]), 0.0, 1e-9 * norm(sum[i])) << r;
  }
}

TEST(DirectControl, MassAndInertiaAreReadSetAndFelt) {
  Simulation world = hover();
  MassProperties mass = world.mass_properties("quad", "base_link");
  EXPECT_GT(mass.mass, 0.1);
  mass.mass *= 2.0;
  mass.inertia.xx *= 1.1;
  world.set_mass_properties("", "base_link", mass);
  EXPECT_EQ(world.mass_properties("", "base_link").mass, mass.mass);
  EXPECT_EQ(world.param("robots.quad.links.base_link.inertia[0]"), mass.inertia.xx);
  // Hover thrust carries half of it.
  EXPECT_NEAR(world.accelerations().bodies[0].linear.z, 0.5 * world.scenario().gravity().z, 1e-9);
  mass.inertia.xx = 1e3;  // larger than the sum of the two others: not a rigid body
  EXPECT_THAT(refusal([&] { world.set_mass_properties("", "base_link", mass); }),
              HasSubstr("inertia"));
  mass.mass = kNone;
  EXPECT_THROW(world.set_mass_properties("", "base_link", mass), Error);
  EXPECT_THAT(refusal([&] { world.mass_properties("", "wing"); }), HasSubstr("base_link"));
}

TEST(DirectControl, RotorConstantsAreReadSetAndHeldToTheirBounds) {
  Simulation world = hover();
  world.set_rotor_parameter("quad", 2, "max_speed", 500.0);
  EXPECT_EQ(world.rotor_parameter("quad", 2, "max_speed"), 500.0);
  EXPECT_EQ(world.param("robots.quad.rotors[2].max_speed"), 500.0);
  EXPECT_THROW(world.set_rotor_parameter("quad", 2, "max_speed", -1.0), Error);
  EXPECT_THAT(refusal([&] { world.rotor_parameter("", 4, "tau_up"); }), HasSubstr("it has 4"));
  EXPECT_THROW(world.rotor_parameter("", 0, "colour"), Error);
}

// Its feet end 60 mm below its origin, its arms reach 0.22 m.
TEST(DirectControl, WhatHoversLowIsNotNearTheGroundUntilItMayTouchIt) {
  for (const double height : {0.2, 0.0605, 0.06005}) {
    Simulation world = hover();
    BodyState base = world.bodies()[0];
    base.position.z = height;
    world.teleport("quad", base);
    const std::uint64_t before = world.step_counts().near;
    EXPECT_TRUE(world.advance(1));
    EXPECT_EQ(world.step_counts().near - before, height < 0.0601 ? 1u : 0u) << height;
  }
}

}  // namespace
}  // namespace skybody
