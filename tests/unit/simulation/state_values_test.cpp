// The state by path: each value equals that of the state words or the bodies; wrong paths are
// answered with the nearest ones.
#include "core/env/state_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/assemble/compile_scenario.h"
#include "core/base/system/error.h"
#include "core/simulation/simulation.h"

namespace skybody {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

/// An environment in flight.
Simulation flying(const std::string& name) {
  Simulation world({.scenario = name, .seed = 5});
  world.reset();
  const std::vector<float> action(static_cast<std::size_t>(world.action_size()), 0.3f);
  for (int k = 0; k < 40; ++k) world.step(action);
  return world;
}

std::string refusal(const Simulation& world, const std::string& path) {
  try {
    world.state(path);
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

std::vector<double> values_of(const Vec3<double>& v) { return {v.x, v.y, v.z}; }
std::vector<double> values_of(const Quat<double>& q) { return {q.w, q.x, q.y, q.z}; }

TEST(StateValues, MotionIsWhatTheSimulationSays) {
  const Simulation world = flying("payload");
  for (const std::string place : {"base", "links.base_link"}) {
    const BodyState& base = world.base("");
    const std::string path = "robots.quad." + place + ".";
    EXPECT_EQ(world.state(path + "position"), values_of(base.position));
    EXPECT_EQ(world.state(path + "rotation"), values_of(base.rotation));
    EXPECT_EQ(world.state(path + "velocity"), values_of(base.velocity));
    EXPECT_EQ(world.state(path + "angular_velocity"), values_of(base.angular_velocity));
  }
  std::vector<double> positions;
  for (const BodyState& body : world.bodies()) {
    for (const double x : values_of(body.position)) positions.push_back(x);
  }
  ASSERT_GT(positions.size(), 3u);
  EXPECT_EQ(world.state("bodies.position"), positions);
}

TEST(StateValues, RotorsCountersAndDrawnValuesAreWhatTheSimulationSays) {
  const Simulation world = flying("payload");
  EXPECT_EQ(world.state("rotor_speed"), world.rotor_speeds());
  EXPECT_EQ(world.state("robots.quad.rotors.speed"), world.rotor_speeds());
  EXPECT_THAT(world.state("robots.quad.rotors[2].speed"), ElementsAre(world.rotor_speeds()[2]));
  EXPECT_EQ(world.state("robots.quad.rotors.command"), world.rotor_commands());
  EXPECT_EQ(world.state("action"), world.actions());
  EXPECT_EQ(world.state("command"), world.commands());
  EXPECT_EQ(world.state("robots.quad.command"), world.commands());
  EXPECT_THAT(world.state("time"), ElementsAre(world.time()));
  EXPECT_THAT(world.state("episode"), ElementsAre(1.0));
  EXPECT_THAT(world.state("steps"), ElementsAre(40.0));
  for (const EnvParam& param : world.compiled().layout().param_info) {
    EXPECT_THAT(world.state(param.path), ElementsAre(world.param(param.path)));
  }
}

TEST(StateValues, JointsAndSensorsHaveTheirOwnShapes) {
  const Simulation world = flying("payload");
  const StateValues& values = world.compiled().state_values();
  int joints = 0, channels = 0;
  for (const StateValue& value : values.all()) {
    if (value.path.starts_with("robots.quad.joints.") && value.path.ends_with(".position"))
      ++joints;
    if (value.path.starts_with("sensors.") && value.doc == std::string("last sample")) {
      const std::vector<double> outputs = world.sensors();
      const std::vector<double> part = world.state(value.path);
      EXPECT_NE(std::search(outputs.begin(), outputs.end(), part.begin(), part.end()),
                outputs.end());
      ++channels;
    }
  }
  EXPECT_EQ(joints, static_cast<int>(world.bodies().size()) - 1);
  EXPECT_GT(channels, 0);
}

TEST(StateValues, ALinkOnAFixedJointIsPlacedOnItsBody) {
  Simulation world = flying("hover");
  const RobotModel& model = world.scenario().robots[0].model;
  const auto link = std::find_if(model.links.begin(), model.links.end(), [](const Link& l) {
    return l.pose.position.x != 0.0 || l.pose.position.y != 0.0 || l.pose.position.z != 0.0;
  });
  ASSERT_NE(link, model.links.end());
  const BodyState base = world.base("");
  const std::string path = "robots.quad.links." + link->name;
  const Vec3<double> arm = rotate(base.rotation, link->pose.position);
  EXPECT_EQ(world.state(path + ".position"), values_of(base.position + arm));
  // Forward differences over a physics step of 1 ms: off by half the step times the acceleration.
  const std::vector<double> before = world.state(path + ".position");
  const std::vector<double> velocity = world.state(path + ".velocity");
  const double time = world.time();
  world.advance(1);
  const std::vector<double> after = world.state(path + ".position");
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR((after[k] - before[k]) / (world.time() - time), velocity[k], 0.05);
  }
}

TEST(StateValues, EveryPathIsThereOnceAndIsFound) {
  for (const char* name : {"hover", "payload", "formation"}) {
    const auto compiled = compile_scenario({name, {}, {}});
    std::set<std::string> paths;
    for (const StateValue& value : compiled->state_values().all()) {
      EXPECT_TRUE(paths.insert(value.path).second) << value.path;
      EXPECT_EQ(&compiled->state_values().at(value.path), &value);
      EXPECT_GE(value.count(), 0) << value.path;
    }
  }
}

TEST(StateValues, AWrongPathIsAnsweredWithTheNearestOnesAndWhatThereIs) {
  const Simulation world = flying("hover");
  EXPECT_EQ(refusal(world, "robots.quad.base.positon"),
            "no value of the state is called `robots.quad.base.positon`; did you mean "
            "`robots.quad.base.position`? `robots.quad.base` has position, rotation, velocity, "
            "angular_velocity (`skybody check --states FILE` lists all)");
  EXPECT_THAT(refusal(world, "robots.quat.base.position"),
              HasSubstr("did you mean `robots.quad.base.position`? `robots` has quad"));
  EXPECT_THAT(refusal(world, "robots.quad.base"),
              HasSubstr("; `robots.quad.base` has position, rotation"));
  EXPECT_THAT(refusal(world, "velocity"), AllOf(StartsWith("no value of the state"),
                                                HasSubstr("; the state has time, episode")));
  for (const char* path : {"", ".", "..", "robots.", "robots.quad.base.position.x"}) {
    EXPECT_THAT(refusal(world, path), StartsWith("no value of the state is called")) << path;
  }
}

}  // namespace
}  // namespace skybody
