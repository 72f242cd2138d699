// Starts and targets are randomizable values: set, drawn and requested like all others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/math/quat.h"
#include "core/simulation/simulation.h"

namespace skybody {
namespace {

const std::string kStart = "robots.quad.start.";
const std::vector<float> kNothing(4, 0.0f);

Simulation hover(const std::string& randomizers, std::vector<std::string> more = {},
                 const std::string& scenario = "hover") {
  more.push_back("randomization=[" + randomizers + "]");
  return Simulation({.scenario = scenario, .overrides = more, .seed = 3});
}

using List = std::vector<double>;
List list(const Vec3<double>& v) { return {v.x, v.y, v.z}; }

ParamChange to(const std::string& path, double value) { return {path, make_constant(value)}; }

void ask(Simulation& simulation, const ParamChange& change, RequestTime when) {
  simulation.request(std::vector<ParamChange>{change}, when);
}

TEST(Starts, AreWhereTheirParametersSay) {
  Simulation simulation = hover("");
  simulation.set_param(kStart + "position[0]", 2.0);
  simulation.set_param(kStart + "turn[2]", 0.5);
  simulation.set_param(kStart + "velocity[1]", -1.0);
  simulation.set_param(kStart + "angular_velocity[0]", 0.25);
  simulation.set_param(kStart + "rotors[1].speed", 100.0);
  simulation.set_param(kStart + "rotors.front_left.speed", 1e9);
  for (int k = 0; k < 2; ++k) {  // and stay so
    simulation.reset();
    const BodyState& base = simulation.base("quad");
    EXPECT_EQ(list(base.position), (List{2.0, 0.0, 1.0}));
    EXPECT_NEAR(yaw(base.rotation), 0.5, 1e-15);
    EXPECT_EQ(list(base.velocity), (List{0.0, -1.0, 0.0}));
    EXPECT_EQ(list(base.angular_velocity), (List{0.25, 0.0, 0.0}));
    const std::vector<double> speeds = simulation.rotor_speeds();
    EXPECT_EQ(std::count(speeds.begin(), speeds.end(), 100.0), 1);
    EXPECT_EQ(std::count(speeds.begin(), speeds.end(), 2246.0), 1) << "held to what a rotor can do";
    simulation.step(kNothing);
  }
}

TEST(Starts, OfTheScenarioHaveTheirBits) {
  Simulation plain = hover(""), set = hover("");
  set.set_param(kStart + "turn[0]", 0.3);
  set.set_param(kStart + "turn[0]", 0.0);
  for (Simulation* s : {&plain, &set}) s->reset();
  EXPECT_EQ(plain.state("q"), set.state("q"));
  EXPECT_EQ(plain.state("q"), (std::vector<double>{0, 0, 1, 1, 0, 0, 0}));
}

TEST(Starts, TurnAboutTheAxesOfTheWorldOnTopOfTheScenariosRotation) {
  Simulation simulation = hover("", {"robots.quad.pose.rpy=[0.2, 0, 0]"});
  simulation.set_param(kStart + "turn[2]", kPi / 2.0);
  simulation.reset();
  const Vec3<double> rpy = to_rpy(simulation.base("quad").rotation);
  EXPECT_NEAR(rpy.x, 0.2, 1e-15);
  EXPECT_NEAR(rpy.y, 0.0, 1e-15);
  EXPECT_NEAR(rpy.z, kPi / 2.0, 1e-15);
}

TEST(Starts, AreDrawn) {
  Simulation simulation = hover(
      "{plugin: draw, name: height, parameters: {what: ['robot.start.position[2]'], range: [1, 2], "
      "form: shift}}, {plugin: draw, name: heading, parameters: {what: ['robot.start.turn[2]'], "
      "range: [-3, 3]}}");
  double least = 10.0, greatest = 0.0, last = 0.0;
  for (int k = 0; k < 200; ++k) {
    simulation.reset();
    const BodyState& base = simulation.base("quad");
    EXPECT_EQ(base.position.z, simulation.param(kStart + "position[2]"));
    EXPECT_NEAR(yaw(base.rotation), simulation.param(kStart + "turn[2]"), 1e-15);
    EXPECT_NE(base.position.z, last);
    last = base.position.z;
    least = std::min(least, last);
    greatest = std::max(greatest, last);
  }
  EXPECT_NEAR(least, 2.0, 0.05);
  EXPECT_NEAR(greatest, 3.0, 0.05);
}

TEST(Starts, OfJointsAreDrawnToo) {
  Simulation simulation = hover("", {}, "payload");
  simulation.reset();
  std::string joint;
  for (const EnvParam& param : simulation.compiled().layout().param_info) {
    if (param.path.find("start.joints.") != std::string::npos) joint = param.path;
  }
  ASSERT_NE(joint, "");
  simulation.set_param(joint, 0.125);
  simulation.reset();
  const std::vector<double> u = simulation.state("u");
  EXPECT_EQ(std::count(u.begin(), u.end(), 0.125), 1) << joint;
}

TEST(Starts, ThatACallerAsksForComeAfterTheRandomizers) {
  Simulation simulation =
      hover("{plugin: start, parameters: {position_min: [1, 1, 1], position_max: [2, 2, 2]}}");
  simulation.reset();
  ask(simulation, to(kStart + "position[0]", -4.0), RequestTime::kNextReset);
  simulation.step(kNothing);
  EXPECT_GT(simulation.base("quad").position.x, 0.9) << "motion goes on";
  simulation.reset();
  EXPECT_EQ(simulation.base("quad").position.x, -4.0);
  EXPECT_GE(simulation.base("quad").position.y, 1.0);
  simulation.reset();
  EXPECT_GE(simulation.base("quad").position.x, 1.0) << "drawn anew";
}

TEST(Starts, ThatACallerAsksForInMidEpisodeAreThoseOfTheNext) {
  Simulation simulation = hover("");
  simulation.reset();
  ask(simulation, to(kStart + "position[0]", -4.0), RequestTime::kNextStep);
  simulation.step(kNothing);
  EXPECT_EQ(simulation.base("quad").position.x, 0.0);
  EXPECT_EQ(simulation.param(kStart + "position[0]"), -4.0);
  simulation.reset();
  EXPECT_EQ(simulation.base("quad").position.x, -4.0);
}

TEST(Starts, ThatACallerAsksForAreDrawnAgainOutOfObstacles) {
  Simulation simulation =
      hover("", {"obstacles=[{name: block, box: [4, 4, 4], position: [0, 0, 2]}]",
                 "robots.quad.pose.position=[5, 0, 2]"});
  int redrawn = 0;
  for (int k = 0; k < 30; ++k) {
    ask(simulation, {kStart + "position[0]", make_uniform(0.0, 6.0)}, RequestTime::kNextReset);
    simulation.reset();
    EXPECT_FALSE(simulation.fault());
    EXPECT_GT(simulation.base("quad").position.x, 1.9);
    redrawn += simulation.state("redraws")[0] > 0.0 ? 1 : 0;
  }
  EXPECT_GT(redrawn, 3) << "a third of the range lies in the block";
  ask(simulation, to(kStart + "position[0]", 0.0), RequestTime::kNextReset);
  simulation.reset();
  EXPECT_TRUE(simulation.fault());
}

TEST(Starts, AreNotMovedByARandomizerInMidEpisode) {
  Simulation simulation =
      hover("{plugin: start, parameters: {position_min: [1, 1, 1], position_max: [2, 2, 2]}}");
  simulation.reset();
  const std::vector<double> q = simulation.state("q");
  simulation.randomize();
  EXPECT_EQ(simulation.state("q"), q);
}

TEST(Targets, ThatTheTaskDrawsAreParameters) {
  Simulation simulation = hover("");
  for (int k = 0; k < 20; ++k) {
    simulation.reset();
    const std::vector<double> goal = simulation.goals();
    for (int i = 0; i < 4; ++i) {
      EXPECT_EQ(simulation.param("task.target[" + std::to_string(i) + "]"),
                goal[static_cast<std::size_t>(i)]);
    }
    EXPECT_LE(std::abs(goal[0]), 5.0);
    EXPECT_NE(goal[0], 0.0);
  }
}

TEST(Targets, ChangeInFlightAndAreDrawnAnewAtTheNextReset) {
  Simulation simulation = hover("");
  simulation.reset();
  const double drawn = simulation.param("task.target[0]");
  ask(simulation, to("task.target[0]", 4.5), RequestTime::kNextStep);
  EXPECT_EQ(simulation.goals()[0], drawn);
  simulation.step(kNothing);
  EXPECT_EQ(simulation.goals()[0], 4.5);
  EXPECT_NEAR(simulation.observation()[0], 4.5 - simulation.base("quad").position.x, 1e-6);
  simulation.reset();
  EXPECT_NE(simulation.goals()[0], 4.5);
}

TEST(Targets, ThatACallerAsksForAtAResetAreKept) {
  for (const char* scenario : {"hover", "formation_2", "payload"}) {
    Simulation simulation = hover("", {}, scenario);
    simulation.reset();
    ask(simulation, to("task.target[1]", 2.25), RequestTime::kNextReset);
    simulation.reset();
    EXPECT_EQ(simulation.param("task.target[1]"), 2.25) << scenario;
  }
}

TEST(Targets, OfTheScenarioAreDrawnByARandomizer) {
  Simulation simulation =
      hover("{plugin: draw, parameters: {what: ['task.target[0]'], range: [1, 2]}}",
            {"task.parameters.target=[0, 0, 1, 0]"});
  double last = 0.0;
  for (int k = 0; k < 10; ++k) {
    simulation.reset();
    const double x = simulation.goals()[0];
    EXPECT_GE(x, 1.0);
    EXPECT_LE(x, 2.0);
    EXPECT_NE(x, last);
    last = x;
    EXPECT_EQ(simulation.goals()[2], 1.0);
  }
}

TEST(Targets, MoveAtATimeInTheEpisode) {
  Simulation simulation = hover(
      "{plugin: draw, parameters: {what: ['task.target[0]'], range: [1, 2], when: time, time: "
      "[0.05, 0.05]}}",
      {"task.parameters.target=[0, 0, 1, 0]"});
  simulation.reset();
  for (int k = 0; k < 50; ++k) simulation.step(kNothing);
  EXPECT_EQ(simulation.goals()[0], 0.0);
  simulation.step(kNothing);
  EXPECT_GE(simulation.goals()[0], 1.0);
}

TEST(Infos, HaveTheRandomizableValuesThatTheScenarioNames) {
  Simulation simulation =
      hover("{plugin: start, parameters: {position_min: [1, 1, 1], position_max: [2, 2, 2]}}",
            {"infos=[robots.quad.start.position, 'task.target[3]']"});
  simulation.reset();
  const std::vector<Channel>& channels = simulation.compiled().info_channels();
  const std::size_t own = channels.size() - 4;  // the task's
  EXPECT_EQ(channels[own].name, "robots.quad.start.position[0]");
  EXPECT_EQ(channels[own + 3].name, "task.target[3]");
  ask(simulation, to("task.target[3]", 0.5), RequestTime::kNextStep);
  simulation.step(kNothing);
  EXPECT_EQ(simulation.info()[own + 3], 0.5f);
  EXPECT_EQ(simulation.info()[own + 1],
            static_cast<float>(simulation.param(channels[own + 1].name)));
}

}  // namespace
}  // namespace skybody
