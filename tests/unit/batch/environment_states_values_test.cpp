// The state of a batch by path: equal to that of each environment alone, available only at rest,
// and reading it changes nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

#include "core/base/system/error.h"
#include "tests/unit/batch/small_env.h"

namespace skybody {
namespace {

using test::fly;
using test::small_env;
using testing::HasSubstr;

constexpr int kEnvs = 21;

std::vector<double> state_of(const Pool& envs, const std::string& path) {
  const int width = envs.compiled().state_values().at(path).count();
  std::vector<double> values(static_cast<std::size_t>(envs.envs() * width));
  envs.state(path, values);
  return values;
}

template <class Failure, class Call>
std::string refusal(Call&& call) {
  try {
    call();
  } catch (const Failure& error) {
    return error.what();
  }
  return "nothing was thrown";
}

/// Subscribes to contacts and outputs the force on the base.
class Feel : public Sensor {
 public:
  void configure(const Setup& setup) override {
    setup.need_contacts();
    setup.channel("force", "N", 3, -kInfinity, kInfinity);
  }
  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>&, Values<Real> out) const {
    out.set(0, env.contact(0).force);
  }
};

/// The robot at a height above the ground, with a ball of 5 cm around its origin.
std::shared_ptr<const CompiledScenario> env_at(double height) {
  test::InProcessFactory factory;
  Scenario scenario = test::small_scenario(factory);
  factory.add<Feel>("feel");
  scenario.sensors.push_back(factory.use("feel", "feel"));
  scenario.contact.ground = true;
  Shape ball;
  ball.radius = 0.05;
  scenario.robots[0].model.bodies[0].collisions.push_back(ball);
  scenario.robots[0].pose.position.z = height;
  return std::make_shared<CompiledScenario>(scenario, factory);
}

class InAnyShape : public testing::TestWithParam<PoolOptions> {};
INSTANTIATE_TEST_SUITE_P(
    StateOfABatch, InAnyShape,
    testing::Values(PoolOptions{.envs = kEnvs, .threads = 1},
                    PoolOptions{.envs = kEnvs, .threads = 3},
                    PoolOptions{.envs = kEnvs, .batch = 5, .threads = 2, .order = Order::kArrival},
                    PoolOptions{.envs = kEnvs, .threads = 2, .autoreset = Autoreset::kSameStep}));

TEST_P(InAnyShape, EveryValueIsThatOfTheWordsOfEachEnvironment) {
  const auto compiled = small_env();
  Pool envs(compiled, GetParam());
  fly(envs, 0, 30);
  const std::vector<std::uint64_t> saved = envs.save();
  // A second batch, with groups of one environment, in the state of the first batch.
  Pool alone(compiled, {.envs = kEnvs, .threads = 64});
  ASSERT_EQ(alone.lanes(), 1);
  fly(alone, 0, 1);
  alone.restore(saved);
  for (const StateValue& value : compiled->state_values().all()) {
    EXPECT_EQ(state_of(envs, value.path), state_of(alone, value.path)) << value.path;
  }
  EXPECT_EQ(envs.save(), saved);
}

TEST(StateOfABatch, AskingLeavesTheFutureAsItIs) {
  const PoolOptions options{.envs = kEnvs, .threads = 2, .seed = 4, .keep_hash = true};
  Pool asked(small_env(), options), left(small_env(), options);
  fly(asked, 0, 1);
  fly(left, 0, 1);
  for (int k = 1; k < 40; ++k) {
    fly(asked, k, k + 1);
    fly(left, k, k + 1);
    for (const char* path : {"bodies.position", "time", "robots.quad.rotors.speed"}) {
      state_of(asked, path);
    }
  }
  EXPECT_EQ(asked.hash(), left.hash());
}

TEST(StateOfABatch, HasSumsOfContactsWhereAPluginAsksForThem) {
  EXPECT_THAT(refusal<Error>(
                  [] { small_env()->state_values().at("robots.quad.links.base.contact.force"); }),
              HasSubstr("`robots.quad.links.base` has position, rotation"));
  for (const double height : {0.049, 1.0}) {
    Pool envs(env_at(height), {.envs = kEnvs, .threads = 2});
    test::begin(envs);
    const std::vector<double> force = state_of(envs, "robots.quad.links.base.contact.force");
    EXPECT_EQ(force, state_of(envs, "sensors.feel.force"));
    for (const double touching : state_of(envs, "robots.quad.links.base.contact.touching")) {
      EXPECT_EQ(touching, height < 0.05 ? 1.0 : 0.0);
    }
    EXPECT_EQ(force[2] > 0.0, height < 0.05);
    EXPECT_EQ(state_of(envs, "robots.quad.links.base.contact.moment").size(), 3u * kEnvs);
  }
}

TEST(StateOfABatch, FollowsASetParameterAndAFork) {
  Pool envs(small_env(), {.envs = kEnvs, .threads = 2});
  fly(envs, 0, 8);
  const std::string mass = "robots.quad.links.base.mass";
  envs.set_param(3, mass, 7.5);
  EXPECT_EQ(state_of(envs, mass)[3], 7.5);
  const std::vector<std::int32_t> targets = {11, 20};
  envs.fork(3, targets, false);
  const std::vector<double> position = state_of(envs, "robots.quad.base.position");
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(position[3 * 11 + k], position[3 * 3 + k]);
    EXPECT_EQ(position[3 * 20 + k], position[3 * 3 + k]);
  }
}

TEST(StateOfABatch, IsRefusedInFlightBeforeAResetAndForWrongSizesAndPaths) {
  Pool envs(small_env(), {.envs = 4, .threads = 2});
  std::vector<double> time(4);
  const auto ask = [&] { envs.state("time", time); };
  std::vector<std::uint8_t> mask = {1, 1, 0, 1};
  envs.send_reset(mask);
  EXPECT_EQ(refusal<StateError>(ask),
            "state() while 3 environments are in flight: recv() them first");
  envs.recv();
  EXPECT_EQ(refusal<Error>(ask),
            "state() of environment 2, which has not begun an episode: reset it first");
  envs.send_reset();
  envs.recv();
  ask();
  EXPECT_THAT(time, testing::Each(0.0));
  time.resize(5);
  EXPECT_EQ(refusal<Error>(ask), "values has 5 values; expected 4 x 1");
  EXPECT_THAT(refusal<Error>([&] { envs.state("times", time); }),
              HasSubstr("did you mean `time`?"));
}

}  // namespace
}  // namespace skybody
