// The columns of an observation: the task's, those added by `observe`, and privileged ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "core/env/value_names.h"
#include "core/model/located_error.h"
#include "core/physics/world/lane_values.h"
#include "tests/unit/env/observed_plugins.h"

namespace skybody {
namespace {

using test::Flight;
using test::InProcessFactory;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Options {
  std::string task = "watch", sensor = "gauge";
  std::vector<ObservedChannel> observe = {};
  double breaks_at = 1e9;
};

ObservedChannel observed(const std::string& channel, const std::string& name = "") {
  ObservedChannel o;
  o.channel = channel;
  o.name = name.empty() ? channel : name;
  o.mark = {"test.yaml", 7, 3};
  return o;
}

ObservedChannel privileged(const std::string& channel) {
  ObservedChannel o = observed(channel);
  o.privileged = true;
  return o;
}

std::unique_ptr<CompiledScenario> make(const Options& options) {
  InProcessFactory factory;
  factory.add<test::Direct>("direct");
  factory.add<test::Kick>("kick");
  factory.add<test::Watch>("watch");
  factory.add<test::Critic>("critic");
  factory.add<test::Blind>("blind");
  factory.add<test::Gauge>("gauge");
  factory.add<test::Twice>("twice");
  factory.add<test::Mirror<4, 1>>("mirror");
  factory.add<test::Mirror<5, 1, true>>("mirror_apart");
  factory.add<test::Mirror<5, 1>>("mirror_critic");
  factory.add<test::Mirror<6, 1>>("mirror_beyond");
  factory.add<test::Mirror<4, 3>>("mirror_itself");
  Scenario s;
  s.name = "test";
  s.contact.ground = false;
  RobotUse robot;
  robot.name = "quad";
  robot.model = test::quadrotor();
  robot.pose.position = {0.0, 0.0, 1.0};
  robot.controllers.push_back(factory.use("direct", "direct"));
  s.robots.push_back(robot);
  s.randomization.push_back(factory.use("kick", "kick"));
  PluginUse sensor = factory.use(options.sensor, "gauge");
  if (!sensor.parameters.empty()) sensor.parameters[0].numbers = {options.breaks_at};
  s.sensors.push_back(sensor);
  s.observe = options.observe;
  s.task = factory.use(options.task, "task");
  return std::make_unique<CompiledScenario>(std::move(s), factory);
}

/// A flight with privileged rows.
struct CriticFlight : Flight {
  CriticFlight(const CompiledScenario& compiled, int lanes)
      : Flight(compiled, lanes),
        privileged(static_cast<std::size_t>(lanes * compiled.privileged_size())) {}
  Rows rows() {
    Rows out = Flight::rows();
    out.privileged = privileged.data();
    return out;
  }
  void reset() { env.reset(group, *work, all, rows()); }
  void step(float action) {
    const std::vector<float> actions(4 * static_cast<std::size_t>(group.lanes()), action);
    env.step(group, *work, all, actions.data(), 4, rows());
  }
  std::uint64_t hash() {
    HashChain chain;
    env.hash(group, 0, rows(), chain);
    return chain.value();
  }
  std::vector<float> privileged;
};

std::vector<std::string> names_of(const CompiledScenario& env) {
  std::vector<std::string> names;
  for (const ObservationColumn& column : env.columns()) names.push_back(column.name);
  return names;
}

std::string message_of(const Options& options) {
  try {
    make(options);
  } catch (const LocatedError& error) {
    return error.mark().file + ":" + std::to_string(error.mark().line) + ": " + error.message();
  }
  return "";
}

TEST(Observation, IsTheTasksChannelsWhereNothingIsObserved) {
  const auto env = make({});
  EXPECT_THAT(names_of(*env), ElementsAre("height", "vertical_speed", "physics_step", "drawn"));
  EXPECT_EQ(env->observation_size(), 4);
  EXPECT_EQ(env->privileged_size(), 0);
  EXPECT_EQ(env->layout().last_observation.size, 4);
}

TEST(Observation, ObservedChannelsFollowTheTasksInTheirOrder) {
  const auto env = make({.observe = {observed("gauge.velocity"), observed("gauge.height", "z")}});
  EXPECT_THAT(names_of(*env), ElementsAre("height", "vertical_speed", "physics_step", "drawn",
                                          "gauge.velocity", "z"));
  EXPECT_EQ(env->observation_size(), 8);
  EXPECT_THAT(observation_names(*env)[6], "gauge.velocity[2]");
  const ObservationColumn& velocity = env->columns()[4];
  EXPECT_EQ(velocity.first, 4);
  EXPECT_EQ(velocity.robot, 0);
  EXPECT_EQ(velocity.unit, "m/s");
  EXPECT_EQ(source_of(*env, velocity), "gauge.velocity");
  EXPECT_EQ(source_of(*env, env->columns()[0]), "task");
}

TEST(Observation, HasTheSensorsFirstValueAtAReset) {
  const auto env = make({.observe = {observed("gauge.height"), observed("gauge.velocity")}});
  CriticFlight flight(*env, 1);
  flight.reset();
  EXPECT_EQ(flight.observation[4], 1.0f);  // the initial height
  EXPECT_NE(flight.observation[5], 0.0f);  // kicked
}

TEST(Observation, HasTheSensorsLatestValueAfterAStep) {
  const auto env = make({.observe = {observed("gauge.velocity"), observed("gauge.height")}});
  CriticFlight flight(*env, 1);
  flight.reset();
  for (int k = 0; k < 5; ++k) flight.step(1.0f);
  EXPECT_EQ(flight.observation[6], flight.observation[1]);  // the task's vertical speed
  EXPECT_EQ(flight.observation[7], flight.observation[0]);
  EXPECT_GT(flight.observation[6], 0.1f);
}

TEST(Observation, BoundsAreTheSensorsUnlessTheScenarioGivesThem) {
  ObservedChannel bounded = observed("gauge.velocity");
  bounded.low = -3.0;
  const auto env = make({.observe = {observed("gauge.height"), bounded}});
  EXPECT_EQ(env->columns()[4].low, 0.0);
  EXPECT_EQ(env->columns()[4].high, 100.0);
  EXPECT_EQ(env->columns()[5].low, -3.0);
  EXPECT_TRUE(std::isinf(env->columns()[5].high));
}

TEST(Observation, PrivilegedValuesAreInARowOfTheirOwn) {
  const auto env = make({.observe = {privileged("gauge.height"), observed("gauge.velocity"),
                                     observed("gauge.step")}});
  EXPECT_EQ(env->observation_size(), 7);
  EXPECT_EQ(env->privileged_size(), 2);  // the sensor itself declares gauge.step as privileged
  EXPECT_THAT(privileged_names(*env), ElementsAre("gauge.height", "gauge.step"));
  CriticFlight flight(*env, 1);
  flight.reset();
  flight.step(0.5f);
  EXPECT_EQ(flight.privileged[0], flight.observation[0]);
  EXPECT_EQ(flight.privileged[1], 1.0f);
  EXPECT_EQ(flight.observation[6], flight.observation[1]);
}

TEST(Observation, TakesATasksPrivilegedValuesOutOfItsRow) {
  const auto env = make({.task = "critic", .observe = {observed("gauge.velocity")}});
  EXPECT_EQ(env->observation_size(), 5);
  EXPECT_EQ(env->privileged_size(), 1);
  CriticFlight flight(*env, 1);
  flight.reset();
  for (int k = 0; k < 5; ++k) flight.step(1.0f);
  EXPECT_EQ(flight.observation[1], 1.0f);                  // `one`, after the privileged channel
  EXPECT_EQ(flight.observation[4], flight.privileged[0]);  // vertical speed, by sensor and task
  EXPECT_GT(flight.privileged[0], 0.1f);
}

TEST(Observation, ColumnsOfTheTaskCanBeForTheCriticAlone) {
  const auto env =
      make({.task = "critic", .observe = {privileged("task.height"), observed("gauge.velocity")}});
  EXPECT_THAT(observation_names(*env),
              ElementsAre("one", "gauge.velocity[0]", "gauge.velocity[1]", "gauge.velocity[2]"));
  EXPECT_THAT(privileged_names(*env), ElementsAre("height", "vertical_speed"));
  CriticFlight flight(*env, 1);
  flight.reset();
  EXPECT_EQ(flight.privileged[0], 1.0f);  // the initial height
  EXPECT_EQ(flight.observation[0], 1.0f);
  for (int k = 0; k < 5; ++k) flight.step(1.0f);
  EXPECT_GT(flight.privileged[0], 1.0f);
  EXPECT_EQ(flight.observation[3], flight.privileged[1]);  // vertical speed, by sensor and task
}

TEST(Observation, AColumnOfTheTaskForTheCriticCanHaveANameAndBounds) {
  ObservedChannel height = privileged("task.height");
  height.name = "z";
  height.low = 0.0;
  const auto env = make({.observe = {height}});
  EXPECT_THAT(privileged_names(*env), ElementsAre("z"));
  EXPECT_EQ(env->columns()[0].low, 0.0);
}

TEST(Observation, HasTheSameBitsInLanesAsAlone) {
  const auto env = make({.task = "critic",
                         .observe = {observed("gauge.velocity"), privileged("gauge.height"),
                                     privileged("task.one")}});
  CriticFlight alone(*env, 1), group(*env, kGroupLanes);
  alone.reset();
  group.reset();
  for (int k = 0; k < 20; ++k) {
    alone.step(0.3f);
    group.step(0.3f);
    ASSERT_TRUE(
        std::equal(alone.observation.begin(), alone.observation.end(), group.observation.begin()));
    ASSERT_TRUE(
        std::equal(alone.privileged.begin(), alone.privileged.end(), group.privileged.begin()));
    ASSERT_EQ(alone.hash(), group.hash());
  }
}

TEST(Observation, AValueThatIsNotFiniteIsAFaultAndTheLastRowsStay) {
  const auto env =
      make({.observe = {observed("gauge.height"), observed("gauge.step")}, .breaks_at = 3.0});
  CriticFlight flight(*env, kGroupLanes);
  flight.reset();
  flight.step(0.5f);
  flight.step(0.5f);
  const std::vector<float> observation = flight.observation, privileged = flight.privileged;
  ASSERT_EQ(flight.status[5], kRunning);
  flight.step(0.5f);
  EXPECT_EQ(flight.status[5], kTruncated | kFault | kBadOutcome);
  EXPECT_EQ(flight.observation, observation);
  EXPECT_EQ(flight.privileged, privileged);
}

TEST(Observation, AFaultIsSeenWhereNobodyTakesPrivilegedRows) {
  const auto env = make({.observe = {observed("gauge.step")}, .breaks_at = 1.0});
  Flight flight(*env, 1);
  flight.reset();
  flight.step({0, 0, 0, 0});
  EXPECT_EQ(flight.status[0], kTruncated | kFault | kBadOutcome);
}

TEST(Observation, ColumnsAreSaidInATextEach) {
  const auto env = make({.observe = {observed("gauge.velocity"), observed("gauge.step", "k")}});
  EXPECT_EQ(column_texts(*env)[4], "gauge.velocity float32 [3] from gauge.velocity");
  EXPECT_EQ(column_texts(*env)[5], "k float32 [1] from gauge.step, privileged");
}

TEST(Observation, TheHashChainsPrivilegedValues) {
  const auto env = make({.observe = {observed("gauge.step")}});
  CriticFlight flight(*env, 1);
  flight.reset();
  const std::uint64_t before = flight.hash();
  flight.privileged[0] += 1.0f;
  EXPECT_NE(flight.hash(), before);
}

TEST(Observation, StateWordsNameAllColumns) {
  const auto env = make({.task = "critic", .observe = {observed("gauge.height")}});
  const std::vector<std::string> names = state_names(*env);
  EXPECT_THAT(std::vector<std::string>(names.end() - 4, names.end()),
              ElementsAre("last_observation height", "last_observation one",
                          "last_observation gauge.height", "last_observation vertical_speed"));
}

TEST(ObservationErrors, AnUnknownChannelNamesTheClosest) {
  EXPECT_EQ(message_of({.observe = {observed("gauge.hieght")}}),
            "test.yaml:7: no sensor has a channel `gauge.hieght`; did you mean `gauge.height`?");
  EXPECT_EQ(message_of({.observe = {observed("camera.image")}}),
            "test.yaml:7: no sensor has a channel `camera.image`; there are: gauge.height, "
            "gauge.velocity, gauge.step");
}

TEST(ObservationErrors, ColumnsOfTheTaskAreNamedAndPrivileged) {
  EXPECT_EQ(message_of({.observe = {privileged("task.hieght")}}),
            "test.yaml:7: the task has no column `task.hieght`; did you mean `task.height`?");
  EXPECT_THAT(message_of({.observe = {observed("task.height")}}),
              HasSubstr("test.yaml:7: `task.height` is a column of the task and observed already"));
  ObservedChannel renamed = privileged("task.height");
  renamed.name = "drawn";
  EXPECT_THAT(message_of({.observe = {renamed}}), HasSubstr("has a column `drawn` already"));
}

TEST(ObservationErrors, APolicyObservesSomething) {
  EXPECT_THAT(message_of({.observe = {privileged("task.height"), privileged("task.vertical_speed"),
                                      privileged("task.physics_step"), privileged("task.drawn")}}),
              HasSubstr("test.yaml:7: `observe` makes every column privileged"));
}

TEST(ObservationErrors, AColumnMustNotTakeTheTasksName) {
  EXPECT_THAT(message_of({.observe = {observed("gauge.height", "height")}}),
              HasSubstr("already; give this one another `name`"));
}

TEST(ObservationErrors, BoundsMustNotCrossTheSensors) {
  ObservedChannel crossed = observed("gauge.height");
  crossed.low = 200.0;
  EXPECT_EQ(message_of({.observe = {crossed}}),
            "test.yaml:7: the bounds of `gauge.height` are 200 to 100; give `low` and `high` that "
            "fit (declared: 0 to 100)");
}

/// Tests rows and the state's last observation for a task that declares repeated values.
void expect_velocity_twice(const std::string& task) {
  const auto env = make({.task = task, .observe = {observed("gauge.height")}});
  ASSERT_EQ(env->observation_size(), 8);
  CriticFlight many(*env, kGroupLanes), one(*env, 1);
  many.reset();
  one.reset();
  for (int step = 0; step < 3; ++step) {
    many.step(0.1f);
    one.step(0.1f);
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      const float* row = many.observation.data() + 8 * lane;
      for (int k = 1; k <= 3; ++k) EXPECT_EQ(row[k], row[3 + k]) << task << ", lane " << lane;
    }
    for (int k = 0; k < 8; ++k) {
      EXPECT_EQ(many.observation[static_cast<std::size_t>(k)],
                one.observation[static_cast<std::size_t>(k)])
          << task << ", value " << k;
    }
    EXPECT_EQ(many.hash(), one.hash()) << task << ": packs and lanes alone";
  }
}

TEST(Observation, ValuesThatRepeatOthersAreCopiedToRows) {
  expect_velocity_twice("mirror");
  expect_velocity_twice("mirror_apart");
}

TEST(ObservationErrors, RepeatsAreValuesOfThePolicyThatRepeatNoOthers) {
  EXPECT_THAT(message_of({.task = "mirror_critic"}),
              HasSubstr("repeats 3 values from 1 on at 5, which are no values that a policy sees, "
                        "or repeat others"));
  EXPECT_THAT(message_of({.task = "mirror_beyond"}), HasSubstr("repeats 3 values from 1 on at 6"));
  EXPECT_THAT(message_of({.task = "mirror_itself"}),
              HasSubstr("repeats 3 values from 3 on at 4, of which some repeat others, or no "
                        "policy sees them"));
}

TEST(ObservationErrors, ATaskMustShowAPolicySomething) {
  EXPECT_THAT(message_of({.task = "blind"}), HasSubstr("declares no observation for a policy"));
}

TEST(ObservationErrors, ASensorMustNotHaveTwoChannelsOfOneName) {
  EXPECT_THAT(message_of({.sensor = "twice"}), HasSubstr("declares two channels `height`"));
}

}  // namespace
}  // namespace skybody
