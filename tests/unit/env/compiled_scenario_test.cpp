// The transition contract (docs/architecture.md, "The way of an action").
#include "core/env/compiled_scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <memory>

#include "core/model/located_error.h"
#include "core/physics/world/lane_values.h"
#include "tests/unit/env/small_plugins.h"

namespace skybody {
namespace {

constexpr int kLanes = kGroupLanes;

using test::Dangling;
using test::Direct;
using test::Flight;
using test::InProcessFactory;
using test::Kick;
using test::Look;
using test::LostSite;
using test::PlainDirect;
using test::Watch;

struct Options {
  int action_repeat = 1, horizon = 0;
  std::string controller = "direct";
  bool kick = false, kick_twice = false, look = false;
};

std::unique_ptr<CompiledScenario> make(InProcessFactory& factory, const Options& options = {}) {
  factory.add<Direct>("direct");
  factory.add<PlainDirect>("plain");
  factory.add<Dangling>("dangling");
  factory.add<Watch>("watch");
  factory.add<Kick>("kick");
  factory.add<Look>("look");
  factory.add<LostSite>("lost_site");
  Scenario s;
  s.name = "test";
  s.stepping.action_repeat = options.action_repeat;
  s.stepping.horizon = options.horizon;
  s.contact.ground = false;
  RobotUse robot;
  robot.name = "quad";
  robot.model = test::quadrotor();
  robot.pose.position = {0.0, 0.0, 1.0};
  robot.controllers.push_back(factory.use(options.controller, options.controller));
  s.robots.push_back(robot);
  if (options.kick) s.randomization.push_back(factory.use("kick", "kick"));
  if (options.kick_twice) s.randomization.push_back(factory.use("kick", "again"));
  if (options.look) s.randomization.push_back(factory.use("look", "look"));
  s.task = factory.use("watch", "task");
  return std::make_unique<CompiledScenario>(std::move(s), factory);
}

TEST(TransitionContract, AnActionActsOnTheVeryNextPhysicsStep) {
  InProcessFactory factory;
  const auto env = make(factory);
  Flight flight(*env, 1);
  flight.reset();
  flight.step({1, 1, 1, 1});  // 4 * 1e-6 * 4000^2 = 64 N on 1 kg: 54.19 m/s^2 upwards
  // One semi-implicit Euler step of 1 ms: v = dt a. Zero intervening steps.
  EXPECT_NEAR(flight.observation[1], 0.001 * (64.0 - 9.81), 1e-6);
}

TEST(TransitionContract, ControlSeesTheLatestStateInEachOfTheKSteps) {
  InProcessFactory factory;
  const auto env = make(factory, {.action_repeat = 10});
  Flight flight(*env, 1);
  flight.reset();
  flight.step({-1, -1, -1, -1});
  const PluginInstance& c = env->plugins(SKYBODY_CONTROLLER)[0];
  EXPECT_EQ(flight.group.plugin_reals(c.memory.state)[0], 10.0);  // once per physics step
  EXPECT_EQ(flight.group.plugin_bits(c.memory.state + 2)[0],
            9u);  // its last call: after 9 completed steps
  // Free fall, for which midpoint is exact: z_n = z_0 - g (n dt)^2 / 2. The tenth call reads n = 9.
  EXPECT_NEAR(flight.group.plugin_reals(c.memory.state + 1)[0], 1.0 - 9.81e-6 * 40.5, 1e-12);
}

TEST(TransitionContract, AnObservationBelongsToTheFinalState) {
  InProcessFactory factory;
  const auto env = make(factory, {.action_repeat = 10});
  Flight flight(*env, 1);
  flight.reset();
  EXPECT_EQ(flight.observation[2], 0.0f);
  flight.step({-1, -1, -1, -1});
  EXPECT_EQ(flight.observation[2], 10.0f);
  EXPECT_NEAR(flight.observation[0], 1.0 - 9.81e-6 * 50.0, 1e-7);  // float32 row
}

TEST(TransitionContract, TheHorizonTruncatesAndATaskTerminates) {
  InProcessFactory factory;
  const auto env = make(factory, {.horizon = 3});
  Flight flight(*env, 1);
  flight.reset();
  for (int i = 0; i < 2; ++i) {
    flight.step({0, 0, 0, 0});
    EXPECT_EQ(flight.status[0], kRunning);
  }
  flight.step({0, 0, 0, 0});
  EXPECT_EQ(flight.status[0], kTruncated);
  flight.reset();
  flight.group.writable(env->layout().q, 1u)[2] = -2.0;
  flight.step({0, 0, 0, 0});
  EXPECT_EQ(flight.status[0], kTerminated);
}

TEST(Fault, ANonFiniteActionKeepsTheLastOneAndTruncates) {
  InProcessFactory factory;
  const auto env = make(factory);
  Flight flight(*env, 1);
  flight.reset();
  flight.step({0.5f, 0.5f, 0.5f, 0.5f});
  flight.step({0.1f, std::numeric_limits<float>::quiet_NaN(), 0.1f, 0.1f});
  EXPECT_EQ(flight.status[0], kTruncated | kFault | kBadAction);
  EXPECT_EQ(flight.reward[0], 0.0f);
  EXPECT_EQ(flight.group.reals(env->layout().action)[1], 0.5);
  for (const float o : flight.observation) EXPECT_TRUE(std::isfinite(o));
}

TEST(Fault, ANonFiniteStateGivesTheLastFiniteObservationAndSparesTheNeighbours) {
  InProcessFactory factory;
  const auto env = make(factory);
  Flight flight(*env, kLanes), alone(*env, kLanes);
  flight.reset();
  alone.reset();
  const std::vector<float> actions(4 * kLanes, 0.2f);
  flight.step(actions);
  alone.step(actions);
  const float height = flight.observation[3 * 4];
  flight.group.writable(env->layout().u, 1u << 3)[3] = std::numeric_limits<double>::infinity();
  flight.step(actions);
  alone.step(actions);
  const std::uint64_t reasons = (std::uint64_t{1} << kBadStartPlace) - 1;
  EXPECT_EQ(flight.status[3] & reasons, kTruncated | kFault | kBadState);
  EXPECT_EQ(env->fault_reason(flight.status[3]),
            "the physics gave up or left the finite numbers: link `base` of robot `quad` moved at "
            "inf m/s before");
  EXPECT_EQ(flight.reward[3], 0.0f);
  EXPECT_EQ(flight.observation[3 * 4], height);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (lane == 3) continue;
    EXPECT_EQ(flight.status[static_cast<std::size_t>(lane)], kRunning);
    EXPECT_EQ(flight.group.save(lane), alone.group.save(lane)) << "lane " << lane;
  }
  flight.reset();
  flight.step(actions);
  EXPECT_EQ(flight.status[3], kRunning);  // a reset repairs it
}

TEST(Fault, AnObservationThatOverflowsAFloatIsOne) {
  InProcessFactory factory;
  const auto env = make(factory);
  Flight flight(*env, 1);
  flight.reset();
  auto words = flight.group.save(0);
  for (std::uint64_t& word : words) {  // the value that the task drew and outputs
    const auto value = static_cast<float>(std::bit_cast<double>(word));
    if (value == flight.observation[3]) word = std::bit_cast<std::uint64_t>(1e200);
  }
  flight.group.restore(0, words);
  flight.step({0, 0, 0, 0});
  EXPECT_EQ(flight.status[0], kTruncated | kFault | kBadOutcome);
  EXPECT_EQ(flight.observation[0], 1.0f);  // the last finite one
  EXPECT_EQ(flight.reward[0], 0.0f);
}

TEST(Randomization, SeesTheBodiesOfThisResetWhateverTheWorkServedBefore) {
  InProcessFactory factory;
  const auto env = make(factory, {.look = true});
  Flight used(*env, 1), fresh(*env, 1);
  used.reset();
  for (int i = 0; i < 100; ++i) used.step({1, 1, 1, 1});  // climbs
  const auto saved = used.group.save(0);
  used.reset();
  fresh.group.restore(0, saved);
  fresh.reset();
  EXPECT_EQ(used.group.save(0), fresh.group.save(0));
}

TEST(Lanes, SideBySideHaveTheBitsOfEnvironmentsOneByOne) {
  for (const char* controller : {"direct", "plain"}) {
    InProcessFactory factory;
    const auto env = make(factory, {.action_repeat = 3,
                                    .controller = controller,
                                    .kick = std::string(controller) == "direct"});
    Flight group(*env, kLanes);
    group.reset();
    std::vector<std::unique_ptr<Flight>> singles;
    for (int l = 0; l < kLanes; ++l) {
      singles.push_back(std::make_unique<Flight>(*env, 1));
      env->initialize(singles.back()->group, 0, 1, static_cast<std::uint64_t>(l));
      singles.back()->reset();
    }
    for (int step = 0; step < 20; ++step) {
      std::vector<float> actions(4 * kLanes);
      for (int k = 0; k < 4 * kLanes; ++k) {
        actions[static_cast<std::size_t>(k)] =
            0.05f * static_cast<float>((k * 7 + step) % 9) - 0.2f;
      }
      group.step(actions);
      for (int l = 0; l < kLanes; ++l) {
        const auto from = actions.begin() + 4 * l;
        singles[static_cast<std::size_t>(l)]->step({from, from + 4});
        ASSERT_EQ(group.group.save(l), singles[static_cast<std::size_t>(l)]->group.save(0))
            << controller << ", lane " << l << ", step " << step;
      }
    }
  }
}

TEST(Lanes, AMaskLeavesTheOthersUntouched) {
  InProcessFactory factory;
  const auto env = make(factory, {.kick = true});
  Flight flight(*env, kLanes);
  flight.reset();
  const auto before = flight.group.save(5);
  const std::vector<float> actions(4 * kLanes, 0.3f);
  env->step(flight.group, *flight.work, ~(1u << 5), actions.data(), 4, flight.rows());
  env->reset(flight.group, *flight.work, ~(1u << 5), flight.rows());
  EXPECT_EQ(flight.group.save(5), before);
}

TEST(Snapshot, SaveStepRestoreStepGivesTheSameBits) {
  InProcessFactory factory;
  const auto env = make(factory, {.kick = true});
  Flight flight(*env, 1);
  flight.reset();
  for (int i = 0; i < 5; ++i) flight.step({0.1f, 0.2f, 0.1f, 0.2f});
  const auto saved = flight.group.save(0);
  for (int i = 0; i < 50; ++i) flight.step({0.1f, 0.25f, 0.1f, 0.2f});
  flight.reset();
  const auto first = flight.group.save(0);
  flight.group.restore(0, saved);
  for (int i = 0; i < 50; ++i) flight.step({0.1f, 0.25f, 0.1f, 0.2f});
  flight.reset();
  EXPECT_EQ(flight.group.save(0), first);
  Flight other(*env, 1);  // another workspace, without history
  other.group.restore(0, saved);
  for (int i = 0; i < 50; ++i) other.step({0.1f, 0.25f, 0.1f, 0.2f});
  other.reset();
  EXPECT_EQ(other.group.save(0), first);
}

TEST(Randomization, DrawsAreHeldToTheDeclaredBounds) {
  InProcessFactory factory;
  const auto env = make(factory, {.kick = true});
  Flight flight(*env, kLanes);
  const int index = env->layout().find_param("robots.quad.controllers.direct.scale");
  ASSERT_GE(index, 0);
  bool low = false, high = false;
  for (int i = 0; i < 50; ++i) {
    flight.reset();
    for (int l = 0; l < kLanes; ++l) {
      const double v = flight.group.reals(env->layout().params.offset + index)[l];
      ASSERT_GE(v, 0.5);
      ASSERT_LE(v, 2.0);
      low |= v == 0.5;
      high |= v == 2.0;
    }
  }
  EXPECT_TRUE(low && high);
}

TEST(Randomization, AControllerGainIsOneValuePerEnvironment) {
  InProcessFactory factory;
  const auto env = make(factory);
  Flight flight(*env, kLanes);
  flight.reset();
  const int index = env->layout().find_param("robots.quad.controllers.direct.scale");
  flight.group.writable({env->layout().params.offset + index, 1}, 1u << 2)[2] = 0.5;
  flight.step(std::vector<float>(4 * kLanes, 0.0f));
  // 2000 rad/s give 16 N on 1 kg; half the speed gives 4 N.
  EXPECT_NEAR(flight.observation[2 * 4 + 1], 0.001 * (4.0 - 9.81), 1e-6);
  EXPECT_NEAR(flight.observation[3 * 4 + 1], 0.001 * (16.0 - 9.81), 1e-6);
}

TEST(Configuration, ASignalThatNoActuatorTakesIsRefusedAtItsLine) {
  InProcessFactory factory;
  try {
    make(factory, {.controller = "dangling"});
    FAIL();
  } catch (const LocatedError& e) {
    EXPECT_EQ(e.mark().file, "test.yaml");
    EXPECT_THAT(e.what(), testing::StartsWith("test.yaml:"));
    EXPECT_EQ(e.message(),
              "the last controller, `dangling`, gives srt[4]; it must give rotor_speed, wrench, "
              "joint, velocity "
              "or pose: add a controller behind it that takes srt");
  }
}

TEST(Configuration, ASiteOnABodyThatIsNotThereIsRefused) {
  InProcessFactory factory;
  try {
    make(factory, {.controller = "lost_site"});
    FAIL();
  } catch (const LocatedError& e) {
    EXPECT_EQ(e.message(), "plugin `lost_site` names body 7 of 1; this is a mistake in the plugin");
  }
}

TEST(Configuration, TwoRandomizersOfOneParameterAreRefused) {
  InProcessFactory factory;
  try {
    make(factory, {.kick = true, .kick_twice = true});
    FAIL();
  } catch (const LocatedError& e) {
    EXPECT_EQ(e.message(),
              "randomizers `kick` (line 1) and `again` both draw "
              "robots.quad.controllers.direct.scale: leave it to one of them");
  }
}

}  // namespace
}  // namespace skybody
