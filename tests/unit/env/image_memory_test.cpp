// Images of sensors: memory, rows, and lifetime.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "core/env/value_names.h"
#include "core/model/located_error.h"
#include "core/physics/world/lane_values.h"
#include "tests/unit/env/small_plugins.h"

namespace skybody {
namespace {

using test::Flight;
using test::InProcessFactory;
using ::testing::HasSubstr;

/// Two images with a vector between them, at every second physics step.
class Camera : public Sensor {
 public:
  struct State {
    std::uint64_t step;  ///< of the images
  };
  void configure(const Setup& setup) override {
    setup.period(2);
    grey_ = setup.image<std::uint8_t>("grey", {3, 5}, 0);  // 15 bytes: a padding byte follows
    setup.channel("height", "m", 1, -kInfinity, kInfinity);
    depth_ = setup.image<std::uint16_t>("depth", {2, 2, 1});
  }
  void sense(const EnvView<double>& env, State& state, Values<double> out) const {
    if (!env.draws_again()) {
      state.step = env.physics_step();
      out.set(0, env.body(0).position.z);
    }
    const auto step = static_cast<int>(state.step);
    std::uint8_t* grey = env.pixels(grey_);
    for (int k = 0; k < grey_.count; ++k) grey[k] = static_cast<std::uint8_t>(10 * step + k);
    std::uint16_t* depth = env.pixels(depth_);
    depth[3] = static_cast<std::uint16_t>(300 + step + static_cast<int>(env.stream_env()));
  }

 private:
  Image<std::uint8_t> grey_;
  Image<std::uint16_t> depth_;
};

/// The steps until its image is read, at every second physics step; -1: never.
class Countdown : public Sensor {
 public:
  struct State {};
  void configure(const Setup& setup) override {
    setup.period(2);
    setup.image<std::uint8_t>("dot", {1});
    setup.channel("left", "", 1, -1.0, kInfinity);
  }
  void sense(const EnvView<double>& env, State&, Values<double> out) const {
    const std::uint64_t left = env.steps_to_read();
    out.set(0, left == SKYBODY_NEVER_READ ? -1.0 : static_cast<double>(left));
  }
};

/// An image whose size is a parameter.
class OddCamera : public Sensor {
 public:
  struct State {};
  RealParameter extent{this, {.name = "extent", .value = 0.0, .doc = "of the image"}};
  void configure(const Setup& setup) override {
    setup.image<float>("range", {static_cast<int>(extent.value()), 2});
  }
  void sense(const EnvView<double>&, State&, Values<double>) const {}
};

/// A task must not output images.
class Painter : public Task {
 public:
  struct State {};
  void configure(const Setup& setup) override {
    setup.channel("height", "m", 1, 0, 1);
    setup.image<std::uint8_t>("picture", {2, 2});
  }
  void evaluate(const EnvView<double>&, State&, Evaluation<double>&) const {}
};

ObservedChannel observed(const std::string& channel) {
  ObservedChannel o;
  o.channel = o.name = channel;
  o.mark = {"test.yaml", 7, 3};
  return o;
}

struct Options {
  std::string task = "watch", sensor = "camera";
  double extent = 0.0;
  int action_repeat = 1;
  std::vector<ObservedChannel> observe = {};
};

std::unique_ptr<CompiledScenario> make(const Options& options) {
  InProcessFactory factory;
  factory.add<test::Direct>("direct");
  factory.add<test::Watch>("watch");
  factory.add<Painter>("painter");
  factory.add<Camera>("camera");
  factory.add<OddCamera>("odd_camera");
  factory.add<Countdown>("countdown");
  Scenario s;
  s.contact.ground = false;
  s.stepping.action_repeat = options.action_repeat;
  RobotUse robot;
  robot.name = "quad";
  robot.model = test::quadrotor();
  robot.pose.position = {0.0, 0.0, 1.0};
  robot.controllers.push_back(factory.use("direct", "direct"));
  s.robots.push_back(robot);
  PluginUse sensor = factory.use(options.sensor, "eye");
  if (!sensor.parameters.empty()) sensor.parameters[0].numbers = {options.extent};
  s.sensors.push_back(sensor);
  s.observe = options.observe;
  s.task = factory.use(options.task, "task");
  return std::make_unique<CompiledScenario>(std::move(s), factory);
}

std::string message_of(const Options& options) {
  try {
    make(options);
  } catch (const LocatedError& error) {
    return error.message();
  }
  return "";
}

/// A flight with rows of two images: depth, then grey.
struct ImageFlight : Flight {
  ImageFlight(const CompiledScenario& compiled, int lanes)
      : Flight(compiled, lanes),
        depth(4 * static_cast<std::size_t>(lanes)),
        grey(15 * static_cast<std::size_t>(lanes)),
        images{reinterpret_cast<std::uint8_t*>(depth.data()), grey.data()} {}
  Rows rows() {
    Rows out = Flight::rows();
    out.images = images;
    return out;
  }
  void reset() { env.reset(group, *work, all, rows()); }
  void step() {
    const std::vector<float> actions(4 * static_cast<std::size_t>(group.lanes()), 0.2f);
    env.step(group, *work, all, actions.data(), 4, rows());
  }
  std::uint64_t hash(int lane) {
    HashChain chain;
    env.hash(group, lane, rows(), chain);
    return chain.value();
  }
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> grey;
  std::uint8_t* images[2];
};

const Options kBoth{
    .observe = {observed("eye.depth"), observed("eye.height"), observed("eye.grey")}};

TEST(Images, AreColumnsBesideTheRow) {
  const auto env = make(kBoth);
  EXPECT_EQ(env->observation_size(), 5);
  ASSERT_EQ(env->images().size(), 2u);
  EXPECT_EQ(env->images()[0].bytes, 8);
  EXPECT_EQ(env->images()[0].from, 16);
  EXPECT_EQ(env->images()[1].bytes, 15);
  EXPECT_EQ(env->images()[1].from, 0);
  const ObservationColumn& depth = env->columns()[4];
  EXPECT_EQ(depth.shape, (std::vector<int>{2, 2, 1}));
  EXPECT_STREQ(info_of(depth.type).name, "uint16");
  EXPECT_EQ(depth.high, 65535.0);
  EXPECT_EQ(depth.image, 0);
  EXPECT_EQ(env->columns()[5].first, 4);
  EXPECT_EQ(env->columns()[6].robot, 0);
}

TEST(Images, AreNoStateWordsAndNoValuesOfSensors) {
  const auto env = make(kBoth);
  EXPECT_EQ(env->layout().sensors.size, 1);
  EXPECT_EQ(static_cast<int>(state_names(*env).size()), env->layout().words);
  EXPECT_EQ(env->saved_words(), static_cast<std::size_t>(env->layout().words));
}

TEST(Images, HaveWhatTheSensorWroteAtAResetAndAtItsRate) {
  const auto env = make(kBoth);
  for (const int lanes : {1, kGroupLanes}) {
    ImageFlight flight(*env, lanes);
    flight.reset();
    const auto last = static_cast<std::size_t>(lanes - 1);
    EXPECT_EQ(flight.grey[15 * last + 14], 14);
    EXPECT_EQ(flight.depth[4 * last + 3], 300 + last);
    EXPECT_EQ(flight.depth[4 * last + 2], 0);
    EXPECT_EQ(flight.observation[5 * last + 4], 1.0f);
    flight.step();  // the sensor is not due
    EXPECT_EQ(flight.grey[15 * last], 0);
    flight.step();
    EXPECT_EQ(flight.grey[15 * last], 20);
    EXPECT_EQ(flight.depth[4 * last + 3], 302 + last);
  }
}

TEST(Images, AreWrittenForTheLanesOfATransitionAlone) {
  const auto env = make(kBoth);
  ImageFlight flight(*env, kGroupLanes);
  flight.reset();
  flight.grey.assign(flight.grey.size(), 99);
  env->reset(flight.group, *flight.work, 1u << 3, flight.rows());
  EXPECT_EQ(flight.grey[2 * 15 + 14], 99);
  EXPECT_EQ(flight.grey[3 * 15 + 14], 14);
  EXPECT_EQ(flight.grey[4 * 15], 99);
}

TEST(Images, AreDrawnAgainAfterARestore) {
  const auto env = make(kBoth);
  ImageFlight flight(*env, kGroupLanes);
  flight.reset();
  flight.step();
  flight.step();
  const std::vector<std::uint64_t> saved = flight.group.save(7);
  const std::vector<std::uint8_t> before(flight.group.images().bytes_of(7),
                                         flight.group.images().bytes_of(7) + 24);
  for (int k = 0; k < 4; ++k) flight.step();
  flight.group.restore(7, saved);
  env->update(flight.group, *flight.work, flight.all);
  EXPECT_EQ(std::memcmp(flight.group.images().bytes_of(7), before.data(), 24), 0);
  EXPECT_NE(std::memcmp(flight.group.images().bytes_of(8), before.data(), 16), 0);
}

TEST(Images, BeginEveryEpisodeAsZero) {
  const auto env = make(kBoth);
  ImageFlight flight(*env, 1);
  flight.reset();
  flight.group.images().bytes()[16] = 5;  // depth[0], which this sensor never writes
  flight.reset();
  EXPECT_EQ(flight.depth[0], 0);
}

TEST(Images, AreInTheTrajectoryHash) {
  const auto env = make(kBoth);
  ImageFlight flight(*env, kGroupLanes);
  flight.reset();
  const std::uint64_t before = flight.hash(0);
  flight.group.images().bytes()[2] ^= 1;
  EXPECT_NE(flight.hash(0), before);
}

TEST(Images, HaveTheSameHashInLanesAsAlone) {
  const auto env = make(kBoth);
  ImageFlight alone(*env, 1), group(*env, kGroupLanes);
  alone.reset();
  group.reset();
  for (int k = 0; k < 5; ++k) {
    ASSERT_EQ(alone.hash(0), group.hash(0));
    alone.step();
    group.step();
  }
}

/// Countdown's last value after a reset, and after an action.
std::vector<float> countdown(int action_repeat, std::vector<ObservedChannel> observe) {
  const auto env =
      make({.sensor = "countdown", .action_repeat = action_repeat, .observe = std::move(observe)});
  Flight flight(*env, 1);
  flight.reset();
  std::vector<float> values{flight.observation[4]};
  flight.step(std::vector<float>(4, 0.2f));
  values.push_back(flight.observation[4]);
  return values;
}

TEST(Images, TellTheirSensorWhenTheyAreRead) {
  const std::vector<ObservedChannel> both{observed("eye.left"), observed("eye.dot")};
  EXPECT_EQ(countdown(4, both), (std::vector<float>{0.0f, 0.0f}));
  EXPECT_EQ(countdown(5, both), (std::vector<float>{0.0f, 1.0f})) << "called at steps 2 and 4";
}

TEST(Images, TellTheirSensorThatNothingReadsThem) {
  EXPECT_EQ(countdown(5, {observed("eye.left")}), (std::vector<float>{-1.0f, -1.0f}));
}

TEST(ImageErrors, AnExtentOfZeroIsRefused) {
  EXPECT_THAT(message_of({.sensor = "odd_camera"}),
              HasSubstr("declares image `range` with an extent of 0"));
}

TEST(ImageErrors, AnImageOfManyMegabytesIsRefused) {
  EXPECT_THAT(message_of({.sensor = "odd_camera", .extent = 1e9}),
              HasSubstr("declares image `range` of more than 256 MiB"));
}

TEST(ImageErrors, ATaskMustNotGiveImages) {
  EXPECT_THAT(message_of({.task = "painter"}),
              HasSubstr("declares image `picture` and is no sensor"));
}

TEST(ImageErrors, AnImageCannotBePrivileged) {
  ObservedChannel secret = observed("eye.grey");
  secret.privileged = true;
  EXPECT_THAT(message_of({.observe = {secret}}), HasSubstr("leave `privileged` out"));
}

}  // namespace
}  // namespace skybody
