// Number of draws of a start: no more than useful, each from the state at the reset.
#include <gtest/gtest.h>

#include "tests/unit/env/small_plugins.h"

namespace skybody {
namespace {

using test::Flight;
using test::InProcessFactory;

/// Puts the robot into the ball, always at the same place.
class Stuck : public Randomizer {
 public:
  inline static int calls = 0;

  void configure(const Setup&) override { calls = 0; }
  template <class Real>
  void randomize(const EnvView<Real>&, State<Real>&, Start<Real>& start) const {
    ++calls;
    start.q.set(2, Real(1.0));
  }
};

/// In the ball, or high above it; wrongly increments the controller's scale.
class Coin : public Randomizer {
 public:
  inline static int calls = 0;

  template <class Real>
  struct State {
    Word<Real> count;
  };
  void configure(const Setup& setup) override {
    calls = 0;
    param_ = setup.find_params("controllers.direct.scale")[0];
    setup.writes(param_);
  }
  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>& s, Start<Real>& start) const {
    ++calls;
    auto rng = random(env);
    start.q.set(2, select(rng.uniform() < 0.5, Real(1.0), Real(9.0)));
    start.params.set(param_, start.params[param_] + Real(0.01));
    s.count = s.count + Word<Real>(1);
  }

 private:
  int param_ = 0;
};

/// A robot with a ball of 0.1 m, five metres above one of 0.5 m.
std::unique_ptr<CompiledScenario> make(InProcessFactory& factory, const std::string& randomizer,
                                       int redraws) {
  factory.add<test::Direct>("direct");
  factory.add<test::Watch>("watch");
  factory.add<Stuck>("stuck");
  factory.add<Coin>("coin");
  const auto ball = [](double radius, double height) {
    Shape shape;
    shape.type = ShapeType::kSphere;
    shape.radius = radius;
    shape.pose.position.z = height;
    return shape;
  };
  Scenario s;
  s.name = "test";
  s.contact.redraws = redraws;
  RobotUse robot;
  robot.name = "quad";
  robot.model = test::quadrotor();
  robot.model.bodies[0].collisions.push_back(ball(0.1, 0.0));
  robot.pose.position.z = 6.0;
  robot.controllers.push_back(factory.use("direct", "direct"));
  s.robots.push_back(robot);
  s.obstacles = {{"ball", ball(0.5, 1.0), false, {}}};
  s.randomization.push_back(factory.use(randomizer, randomizer));
  s.task = factory.use("watch", "task");
  return std::make_unique<CompiledScenario>(std::move(s), factory);
}

TEST(Start, IsNotDrawnOnWhereNothingThatIsDrawnMovesTheOverlap) {
  InProcessFactory factory;
  const auto compiled = make(factory, "stuck", 1000);
  Flight flight(*compiled, 1);
  flight.reset();
  EXPECT_EQ(Stuck::calls, 1 + 4);
  EXPECT_EQ(flight.status[0] & 0x7f, kTruncated | kFault | kBadStart);
  // At the ball's centre: the depth is the sum of the radii.
  EXPECT_EQ(compiled->fault_reason(flight.status[0])
                .find("robot `quad` begins inside the obstacle `ball`, by 0.6 m"),
            0u);
}

TEST(Start, IsTakenAsItIsDrawnWhereRedrawsAreZero) {
  InProcessFactory factory;
  const auto compiled = make(factory, "stuck", 0);
  Flight flight(*compiled, 1);
  flight.reset();
  EXPECT_EQ(Stuck::calls, 1);
  EXPECT_EQ(flight.status[0], kRunning);
}

TEST(Start, IsDrawnAgainFromWhereTheResetBegan) {
  InProcessFactory factory;
  const auto compiled = make(factory, "coin", 50);
  Flight flight(*compiled, 1);
  const int scale = compiled->layout().params.offset +
                    compiled->layout().find_param("robots.quad.controllers.direct.scale");
  for (int k = 1; k <= 20; ++k) {
    flight.reset();
    EXPECT_EQ(flight.status[0], kRunning) << k;
    EXPECT_EQ(flight.group.reals(compiled->layout().q)[2], 9.0) << k;
    // Each reset counts once and adds once, regardless of its number of draws.
    const int count = compiled->plugins(SKYBODY_RANDOMIZER)[0].memory.state;
    EXPECT_EQ(flight.group.plugin_bits(count)[0], static_cast<std::uint64_t>(k));
    EXPECT_NEAR(flight.group.reals(scale)[0], 1.0 + 0.01 * k, 1e-12);
  }
  EXPECT_GT(Coin::calls, 25);
  EXPECT_LT(Coin::calls, 80);
}

}  // namespace
}  // namespace skybody
