// Contact forces by pair and joint reactions, as plugins read them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/model/located_error.h"
#include "core/physics/world/lane_values.h"
#include "tests/unit/env/small_plugins.h"

namespace skybody {
namespace {

using test::Flight;
using test::InProcessFactory;
using testing::HasSubstr;

/// Outputs of this task:
/// - body 0: sum of contacts, and contacts with the ground, with the second obstacle and with body
///   1 (the
///   arm, or the other robot), each as force and touching flag
/// - body 1: the reaction of its joint
class Feel : public Task {
 public:
  void configure(const Setup& setup) override {
    setup.channel("felt", "", 4 * 4 + 6, -kInfinity, kInfinity);
    setup.need_contacts();
    setup.contact_pair(1, Partner::kGroundPlane);  // an unused pair before the used ones
    pairs_[0] = setup.contact_pair(0, Partner::kGroundPlane);
    pairs_[1] = setup.contact_pair(0, Partner::kObstacle, 1);
    pairs_[2] = setup.contact_pair(0, Partner::kBody, 1);
    reaction_ = setup.joint_reaction(1);
  }
  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    int next = 0;
    const auto add = [&](const ContactSum<Real>& sum) {
      for (const Real& value : {sum.force.x, sum.force.y, sum.force.z}) {
        out.observation.set(next++, value);
      }
      out.observation.set(next++, select(sum.touching, Real(1.0), Real(0.0)));
    };
    add(env.contact(0));
    for (const int pair : pairs_) add(env.contact_pair(pair));
    const JointReaction<Real> r = env.joint_reaction(reaction_);
    for (const Real& value :
         {r.force.x, r.force.y, r.force.z, r.moment.x, r.moment.y, r.moment.z}) {
      out.observation.set(next++, value);
    }
  }

 private:
  int pairs_[3] = {}, reaction_ = 0;
};

/// Records contact and joint forces at a reset: they must not come from the previous episode.
class Remember : public Randomizer {
 public:
  template <class Real>
  struct State {
    Real contact, pair, reaction;
  };
  void configure(const Setup& setup) override {
    setup.need_contacts();
    pair_ = setup.contact_pair(0, Partner::kGroundPlane);
    reaction_ = setup.joint_reaction(1);
  }
  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>& state, Start<Real>&) const {
    state.contact = env.contact(0).force.z;
    state.pair = env.contact_pair(pair_).force.z;
    state.reaction = env.joint_reaction(reaction_).force.z;
  }

 private:
  int pair_ = 0, reaction_ = 0;
};

/// Requests objects that do not exist.
class Lost : public Feel {
 public:
  void configure(const Setup& setup) override {
    setup.channel("felt", "", 1, 0, 1);
    setup.contact_pair(0, Partner::kObstacle, 2);
  }
};

class LostJoint : public Feel {
 public:
  void configure(const Setup& setup) override {
    setup.channel("felt", "", 1, 0, 1);
    setup.joint_reaction(2);
  }
};

Body arm() {
  Body body;
  body.name = "arm";
  body.mass = {0.1, {0.0, 0.0, -0.1}, {1e-3, 1e-3, 1e-4, 0, 0, 0}};
  body.joint.name = "shoulder";
  body.joint.type = JointType::kPin;
  body.joint.parent = 0;
  return body;
}

Shape ball(double radius) {
  Shape shape;
  shape.type = ShapeType::kSphere;
  shape.radius = radius;
  return shape;
}

/// One robot with an arm, and two obstacles far away.
Scenario scene() {
  Scenario s;
  s.name = "test";
  s.stepping.action_repeat = 1;
  RobotUse robot;
  robot.name = "quad";
  robot.model = test::quadrotor();
  robot.model.bodies[0].collisions.push_back(ball(0.1));
  robot.model.bodies.push_back(arm());
  robot.pose.position.z = 5.0;
  s.robots.push_back(robot);
  for (int k = 0; k < 2; ++k) {
    Obstacle obstacle;
    obstacle.name = "post" + std::to_string(k);
    obstacle.shape = ball(0.5);
    obstacle.shape.pose.position = {50.0 + 10.0 * k, 0.0, 5.0};
    s.obstacles.push_back(obstacle);
  }
  return s;
}

std::unique_ptr<CompiledScenario> make(InProcessFactory& factory, Scenario s,
                                       const std::string& task = "feel",
                                       Checking checking = Checking::kNo) {
  factory.add<test::Direct>("direct");
  factory.add<Feel>("feel");
  factory.add<Lost>("lost");
  factory.add<LostJoint>("lost_joint");
  for (RobotUse& robot : s.robots) robot.controllers.push_back(factory.use("direct", "direct"));
  s.task = factory.use(task, "task");
  return std::make_unique<CompiledScenario>(std::move(s), factory, checking);
}

constexpr int kSum = 0, kOfGround = 4, kOfPost = 8, kOfBody = 12, kReaction = 16;

TEST(JointReaction, IsNothingInFreeFall) {
  InProcessFactory factory;
  const auto env = make(factory, scene(), "feel", Checking::kYes);
  Flight flight(*env, 1);
  flight.reset();
  flight.step({-1, -1, -1, -1});
  for (int k = 0; k < 6; ++k) {
    // All parts fall alike; 1.1 kg times 9.81 m/s^2 cancel up to rounding.
    EXPECT_NEAR(flight.observation[static_cast<std::size_t>(kReaction + k)], 0.0, 1e-6) << k;
  }
}

TEST(JointReaction, CarriesAnArmThatIsLiftedAtItsWeightAndMore) {
  InProcessFactory factory;
  const auto env = make(factory, scene());
  Flight flight(*env, 1);
  flight.reset();
  const std::vector<float> lift(4, 0.0f);  // 2000 rad/s: 4 N each, 16 N for 1.1 kg
  flight.step(lift);
  flight.step(lift);
  // The arm hangs straight below: m (g + a) = 0.1 kg 16 N / 1.1 kg; floats have 1e-7 of that.
  EXPECT_NEAR(flight.observation[kReaction + 2], 0.1 * 16.0 / 1.1, 1e-6);
  for (const int k : {0, 1, 3, 4, 5}) {
    EXPECT_NEAR(flight.observation[static_cast<std::size_t>(kReaction + k)], 0.0, 1e-6) << k;
  }
}

TEST(ContactPair, WithTheGroundIsTheSumWhereNothingElseTouches) {
  InProcessFactory factory;
  Scenario s = scene();
  s.robots[0].pose.position.z = 0.0995;
  const auto env = make(factory, s, "feel", Checking::kYes);
  Flight flight(*env, 1);
  flight.reset();
  flight.step({-1, -1, -1, -1});
  EXPECT_GT(flight.observation[kOfGround + 2], 1.0f);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(flight.observation[static_cast<std::size_t>(kOfGround + k)],
              flight.observation[static_cast<std::size_t>(kSum + k)]);
    EXPECT_EQ(flight.observation[static_cast<std::size_t>(kOfPost + k)], 0.0f);
  }
}

TEST(ContactPair, TellsOneObstacleFromAnother) {
  for (const int touched : {0, 1}) {
    InProcessFactory factory;
    Scenario s = scene();
    s.obstacles[static_cast<std::size_t>(touched)].shape.pose.position = {0.599, 0.0, 5.0};
    const auto env = make(factory, s);
    Flight flight(*env, 1);
    flight.reset();
    flight.step({-1, -1, -1, -1});
    EXPECT_LT(flight.observation[kSum], 0.0f);
    EXPECT_EQ(flight.observation[kOfPost], touched == 1 ? flight.observation[kSum] : 0.0f);
    EXPECT_EQ(flight.observation[kOfPost + 3], static_cast<float>(touched));
    EXPECT_EQ(flight.observation[kOfGround + 3], 0.0f);
  }
}

TEST(ContactPair, WithAnotherRobotIsSeenFromEitherSide) {
  InProcessFactory factory;
  Scenario s = scene();
  s.robots[0].model.bodies.pop_back();
  s.robots.push_back(s.robots[0]);
  s.robots[1].name = "other";
  s.robots[1].pose.position.x = 0.199;
  const auto env = make(factory, s);
  Flight flight(*env, 1);
  flight.reset();
  flight.step(std::vector<float>(8, -1.0f));
  EXPECT_LT(flight.observation[kOfBody], 0.0f);  // pushed towards -x
  EXPECT_EQ(flight.observation[kOfBody], flight.observation[kSum]);
  EXPECT_EQ(flight.observation[kOfBody + 3], 1.0f);
  for (int k = 0; k < 6;
       ++k) {  // a free base has no joint; forces of some 10 N cancel up to rounding
    EXPECT_NEAR(flight.observation[static_cast<std::size_t>(kReaction + k)], 0.0, 1e-4) << k;
  }
}

TEST(WhatBodiesFeel, HasTheSameBitsInLanesAsAlone) {
  InProcessFactory factory;
  Scenario s = scene();
  s.robots[0].pose.position.z = 0.101;
  const auto env = make(factory, s);
  Flight group(*env, kGroupLanes), alone(*env, 1);
  group.reset();
  alone.reset();
  for (int k = 0; k < 40; ++k) {
    const std::vector<float> row{-0.9f, -0.95f, -1.0f, 0.01f * static_cast<float>(k) - 1.0f};
    std::vector<float> rows;
    for (int l = 0; l < kGroupLanes; ++l) rows.insert(rows.end(), row.begin(), row.end());
    group.step(rows);
    alone.step(row);
    for (std::size_t i = 0; i < alone.observation.size(); ++i) {
      ASSERT_EQ(group.observation[i], alone.observation[i]) << k << " " << i;
    }
  }
  EXPECT_NE(alone.observation[kSum + 2], 0.0f);
}

TEST(WhatBodiesFeel, BeginsAnewAtAReset) {
  InProcessFactory factory;
  factory.add<Remember>("remember");
  Scenario s = scene();
  s.robots[0].pose.position.z = 0.0995;
  s.randomization.push_back(factory.use("remember", "remember"));
  const auto env = make(factory, s);
  Flight flight(*env, 1);
  flight.reset();
  flight.step({1, 1, -1, -1});
  ASSERT_NE(flight.observation[kSum + 2], 0.0f);
  ASSERT_NE(flight.observation[kReaction + 2], 0.0f);
  flight.reset();
  const PluginInstance& remember = env->plugins(SKYBODY_RANDOMIZER)[0];
  std::vector<double> seen(3);
  flight.group.gather(0, {env->layout().plugin_state.offset + remember.memory.state, 3},
                      seen.data());
  EXPECT_EQ(seen, (std::vector<double>{0.0, 0.0, 0.0}));
}

TEST(WhatBodiesFeel, IsRefusedOfThingsThatAreNotThere) {
  const auto refusal = [](const std::string& task) -> std::string {
    InProcessFactory factory;
    try {
      make(factory, scene(), task);
    } catch (const LocatedError& e) {
      return e.message();
    }
    return "";
  };
  EXPECT_THAT(refusal("lost"),
              HasSubstr("asks for the contact of body 0 with 2, which there is not"));
  EXPECT_THAT(refusal("lost_joint"),
              HasSubstr("asks for the reaction of the joint of body 2 of 2"));
}

}  // namespace
}  // namespace skybody
