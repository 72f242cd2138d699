// From commands to actuators: several chains and several ends, periods, a task's own action.
#include <gtest/gtest.h>

#include "core/model/located_error.h"
#include "tests/unit/env/small_plugins.h"

namespace skybody {
namespace {

using test::Flight;
using test::InProcessFactory;

/// Torque of the arm's joint from the action, -2 to 2 N m.
class ArmTorque : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kJoint, {-2.0}, {2.0});
    setup.output(Signal::kJoint, 1);
    setup.joint({1, 0, SKYBODY_JOINT_EFFORT, 0.0, 0.0, 2.0, 0.0, -2.0, 2.0});
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> in, Values<Real> out) const {
    out.set(0, in[0]);
  }
};

/// Declares the same joint twice.
class ArmTwice : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kJoint, {-2.0, -2.0}, {2.0, 2.0});
    setup.output(Signal::kJoint, 2);
    for (int i = 0; i < 2; ++i) {
      setup.joint({1, 0, SKYBODY_JOINT_EFFORT, 0.0, 0.0, 2.0, 0.0, -2.0, 2.0});
    }
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real>, Values<Real>) const {}
};

/// One command for rotors and arm: two ends.
class Both : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kCtbt, {0, 0, 0, 0}, {10, 1, 1, 1});
    setup.output(Signal::kRotorSpeed, 4);
    setup.output(Signal::kJoint, 1);
    setup.joint({1, 0, SKYBODY_JOINT_EFFORT, 0.0, 0.0, 2.0, 0.0, -2.0, 2.0});
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> in, Values<Real> out) const {
    for (int i = 0; i < 4; ++i) out.set(i, in[0] + i);
    out.set(4, in[3]);
  }
};

/// Called every third physics step; its thrusts are the number of the call.
class Slow : public Controller {
 public:
  template <class Real>
  struct State {
    Real calls;
  };
  void configure(const Setup& setup) override {
    setup.input(Signal::kCtbt, {0, 0, 0, 0}, {1, 1, 1, 1});
    setup.output(Signal::kRotorSpeed, 4);
    setup.period(3);
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>& s, ConstValues<Real>, Values<Real> out) const {
    s.calls += Real(1.0);
    for (int i = 0; i < 4; ++i) out.set(i, s.calls);
  }
};

/// Declares one output twice.
class Twice : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kCtbt, {0, 0, 0, 0}, {1, 1, 1, 1});
    setup.output(Signal::kRotorSpeed, 4);
    setup.output(Signal::kRotorSpeed, 4);
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real>, Values<Real>) const {}
};

/// Takes four values of a signal that has thirteen.
class WrongSize : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kTrajectory, {0, 0, 0, 0}, {1, 1, 1, 1});
    setup.output(Signal::kRotorSpeed, 4);
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real>, Values<Real>) const {}
};

/// A task with its own action: one height, 0 to 8, for all rotors; commands interpolate over the
/// physics steps.
class Climb : public Task {
 public:
  void configure(const Setup& setup) override {
    setup.channel("height", "m", 1, -kInfinity, kInfinity);
    setup.action("push", "rad/s", 1, 0.0, 8.0, 0);
    setup.interpolate();
  }
  template <class Real>
  void process(const EnvView<Real>&, State<Real>&, ConstValues<Real> action,
               Values<Real> command) const {
    for (int i = 0; i < 4; ++i) command.set(i, action[0]);
  }
  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    out.observation.set(0, env.body(0).position.z);
  }
};

/// Makes commands in every physics step; they count its calls.
class Count : public Task {
 public:
  template <class Real>
  struct State {
    Real calls;
  };
  void configure(const Setup& setup) override {
    setup.channel("calls", "", 1, 0, kInfinity);
    setup.period(2);
  }
  template <class Real>
  void process(const EnvView<Real>&, State<Real>& s, ConstValues<Real>,
               Values<Real> command) const {
    s.calls += Real(1.0);
    for (int i = 0; i < 4; ++i) command.set(i, s.calls);
  }
  template <class Real>
  void evaluate(const EnvView<Real>&, State<Real>& s, Evaluation<Real>& out) const {
    out.observation.set(0, s.calls);
  }
};

/// Declares an action of its own, but has no process().
class Mute : public Task {
 public:
  void configure(const Setup& setup) override {
    setup.channel("none", "", 1, 0, 1);
    setup.action("push", "", 1, 0.0, 1.0, 0);
  }
  template <class Real>
  void evaluate(const EnvView<Real>&, State<Real>&, Evaluation<Real>&) const {}
};

/// Passes rotor speeds on.
class PassOn : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kRotorSpeed, 4);
    setup.output(Signal::kRotorSpeed, 4);
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> in, Values<Real> out) const {
    for (int i = 0; i < 4; ++i) out.set(i, in[i]);
  }
};

/// Declares a goal, but has no goal().
class Aimless : public Task {
 public:
  void configure(const Setup& setup) override {
    setup.channel("none", "", 1, 0, 1);
    setup.goal(0, 0);
  }
  template <class Real>
  void evaluate(const EnvView<Real>&, State<Real>&, Evaluation<Real>&) const {}
};

RobotModel with_arm() {
  RobotModel model = test::quadrotor();
  Body arm;
  arm.name = "arm";
  arm.mass = {0.1, {0.0, 0.0, -0.1}, {1e-3, 1e-3, 1e-4, 0, 0, 0}};
  arm.joint.name = "shoulder";
  arm.joint.type = JointType::kPin;
  arm.joint.parent = 0;
  model.bodies.push_back(arm);
  return model;
}

std::unique_ptr<CompiledScenario> make(InProcessFactory& factory,
                                       const std::vector<std::string>& controllers,
                                       const std::string& task = "watch", int action_repeat = 4,
                                       Checking checking = Checking::kNo) {
  factory.add<test::Direct>("direct");
  factory.add<test::Watch>("watch");
  factory.add<PassOn>("pass_on");
  factory.add<ArmTorque>("arm_torque");
  factory.add<ArmTwice>("arm_twice");
  factory.add<Both>("both");
  factory.add<Slow>("slow");
  factory.add<Twice>("twice");
  factory.add<WrongSize>("wrong_size");
  factory.add<Climb>("climb");
  factory.add<Count>("count");
  factory.add<Mute>("mute");
  factory.add<Aimless>("aimless");
  Scenario s;
  s.name = "test";
  s.stepping.action_repeat = action_repeat;
  s.contact.ground = false;
  RobotUse robot;
  robot.name = "quad";
  robot.model = with_arm();
  robot.rotor_speed = 100.0;
  for (const std::string& name : controllers) {
    robot.controllers.push_back(factory.use(name, name));
    robot.controllers.back().mark.line = static_cast<int>(robot.controllers.size());
  }
  s.robots.push_back(robot);
  s.task = factory.use(task, "task");
  return std::make_unique<CompiledScenario>(std::move(s), factory, checking);
}

/// The message that refuses the scenario, after the line number.
std::string refusal(const std::vector<std::string>& controllers, const std::string& task = "watch",
                    int action_repeat = 4) {
  InProcessFactory factory;
  try {
    make(factory, controllers, task, action_repeat);
  } catch (const LocatedError& e) {
    return e.message();
  }
  return "";
}

std::vector<double> values(const Flight& flight, Block block) {
  std::vector<double> out(static_cast<std::size_t>(block.size));
  flight.group.gather(0, block, out.data());
  return out;
}

TEST(Chains, OneForTheRotorsAndOneForTheArm) {
  InProcessFactory factory;
  const auto env = make(factory, {"direct", "arm_torque"});
  ASSERT_EQ(env->chains().size(), 2u);
  EXPECT_EQ(env->action_size(), 5);
  EXPECT_EQ(env->agents(), std::vector<int>{0});
  EXPECT_EQ(env->model().commands_of(0).size, 5);
  Flight flight(*env, 1);
  flight.reset();
  flight.step({1.0f, 0.0f, 0.0f, 0.0f, 0.5f});
  EXPECT_EQ(values(flight, env->layout().rotor_command),
            (std::vector<double>{4000, 2000, 2000, 2000}));
  EXPECT_EQ(values(flight, env->layout().joint_command), std::vector<double>{1.0});
}

TEST(Chains, MayHaveSeveralEnds) {
  InProcessFactory factory;
  const auto env = make(factory, {"both"});
  ASSERT_EQ(env->chains().size(), 1u);
  ASSERT_EQ(env->chains()[0].ends.size(), 2u);
  Flight flight(*env, 1);
  flight.reset();
  flight.step({1.0f, 0.0f, 0.0f, 1.0f});
  EXPECT_EQ(values(flight, env->layout().rotor_command), (std::vector<double>{10, 11, 12, 13}));
  EXPECT_EQ(values(flight, env->layout().joint_command), std::vector<double>{1.0});
}

TEST(Chains, AControllerWithAPeriodHoldsWhatItGave) {
  InProcessFactory factory;
  const auto env = make(factory, {"slow"}, "watch", 1);
  Flight flight(*env, 1);
  flight.reset();
  std::vector<double> seen;
  for (int k = 0; k < 7; ++k) {
    flight.step({0, 0, 0, 0});
    seen.push_back(values(flight, env->layout().rotor_command)[0]);
  }
  EXPECT_EQ(seen, (std::vector<double>{1, 1, 1, 2, 2, 2, 3}));
}

TEST(Chains, AHeldOutputFeedsTheNextController) {
  InProcessFactory factory;
  const auto env = make(factory, {"slow", "direct"}, "watch", 2);
  ASSERT_EQ(env->chains().size(), 1u);
  Flight flight(*env, 1);
  flight.reset();
  flight.step({0, 0, 0, 0});
  EXPECT_EQ(values(flight, env->layout().rotor_command)[0], 1.0);
  flight.step({0, 0, 0, 0});
  EXPECT_EQ(values(flight, env->layout().rotor_command)[0], 2.0);
}

TEST(Chains, WhatPassesCommandsOnHasTheRangeOfTheOneBehindIt) {
  for (const std::vector<std::string>& before :
       {std::vector<std::string>{"pass_on"}, std::vector<std::string>{"pass_on", "again"}}) {
    InProcessFactory factory;
    factory.add<PassOn>("again");
    std::vector<std::string> controllers = before;
    controllers.emplace_back("direct");
    const auto env = make(factory, controllers);
    ASSERT_EQ(env->chains().size(), 1u);
    Flight flight(*env, 1);
    flight.reset();
    flight.step({1.0f, 0.0f, -1.0f, 0.5f});
    EXPECT_EQ(values(flight, env->layout().rotor_command),
              (std::vector<double>{4000, 2000, 0, 3000}));
  }
}

TEST(Chains, SayWhatDoesNotFit) {
  EXPECT_NE(refusal({"pass_on"}).find("passes its command on, but nothing behind it says"),
            std::string::npos);
  EXPECT_NE(refusal({"twice"}).find("declares its output rotor_speed twice"), std::string::npos);
  EXPECT_NE(refusal({"wrong_size"}).find("takes trajectory with 4 values; it has 17 a point"),
            std::string::npos);
  EXPECT_NE(refusal({"direct", "arm_torque", "slow"})
                .find("gives rotor_speed to robot `quad`, whose actuators a chain before it"),
            std::string::npos);
}

TEST(Chains, AJointHasOneDrive) {
  EXPECT_NE(refusal({"direct", "arm_twice"}).find("which is driven already"), std::string::npos);
  EXPECT_NE(refusal({"arm_torque", "arm_twice"}).find("which is driven already"),
            std::string::npos);
}

TEST(Chains, AnArmAloneLeavesTheRotorsRunning) {
  InProcessFactory factory;
  const auto env = make(factory, {"arm_torque"});
  Flight flight(*env, 1);
  flight.reset();
  EXPECT_GT(values(flight, env->layout().rotor_speed)[0], 0.0);
}

TEST(OwnAction, IsTheSameInCheckedMode) {
  for (const char* task : {"climb", "count"}) {
    InProcessFactory factory, others;
    const auto plain = make(factory, {"direct"}, task);
    const auto checked = make(others, {"direct"}, task, 4, Checking::kYes);
    Flight one(*plain, 1), two(*checked, 1);
    for (Flight* flight : {&one, &two}) {
      flight->reset();
      for (int k = 0; k < 3; ++k) {
        flight->step(std::vector<float>(static_cast<std::size_t>(plain->action_size()), 0.3f));
      }
    }
    EXPECT_EQ(one.group.save(0), two.group.save(0)) << task;
  }
}

TEST(OwnAction, IsMadeOfTheTasksChannelsInTheirUnits) {
  InProcessFactory factory;
  const auto env = make(factory, {"direct"}, "climb");
  EXPECT_EQ(env->action_size(), 1);
  ASSERT_EQ(env->action_channels().size(), 1u);
  EXPECT_EQ(env->action_channels()[0].name, "push");
  Flight flight(*env, 1);
  flight.reset();
  flight.step({0.0f});  // the first command of an episode has no previous one to interpolate from
  EXPECT_EQ(values(flight, env->layout().command)[0], 4.0);
}

TEST(OwnAction, MayReachTheRotorsStepByStep) {
  InProcessFactory factory;
  const auto env = make(factory, {"direct"}, "climb");
  Flight flight(*env, 1);
  flight.reset();
  flight.step({0.0f});
  const std::vector<std::uint64_t> before = flight.group.save(0);
  flight.step({1.0f});  // from 4 to 8 in four steps: 5, 6, 7, 8
  EXPECT_EQ(values(flight, env->layout().command)[0], 8.0);
  const double quick = flight.group.reals(env->layout().u)[2];
  InProcessFactory others;
  const auto at_once = make(others, {"direct"}, "watch");
  Flight jump(*at_once, 1);
  jump.reset();
  const auto speed = [](double command) { return static_cast<float>(command / 2000.0 - 1.0); };
  jump.step(std::vector<float>(4, speed(4.0)));
  jump.step(std::vector<float>(4, speed(8.0)));
  EXPECT_LT(quick,
            jump.group.reals(at_once->layout().u)[2]);  // the jump pushes harder from the start
}

TEST(OwnAction, CommandsMayBeMadeWithinAnAction) {
  InProcessFactory factory;
  const auto env = make(factory, {"direct"}, "count");
  Flight flight(*env, 1);
  flight.reset();
  flight.step({0, 0, 0, 0});
  EXPECT_EQ(flight.observation[0], 2.0f);
  EXPECT_NE(refusal({"direct"}, "count", 3).find("which do not divide action_repeat 3"),
            std::string::npos);
}

TEST(Declarations, OfWhatAMethodIsMissingAreRefused) {
  EXPECT_NE(refusal({"direct"}, "mute").find("has no process() that makes commands of it"),
            std::string::npos);
  EXPECT_NE(refusal({"direct"}, "aimless").find("has no goal() that says where it is"),
            std::string::npos);
}

}  // namespace
}  // namespace skybody
