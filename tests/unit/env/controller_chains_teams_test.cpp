// Controllers of several robots: their outputs go to the robots' own chains, or to actuators.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/env/state_values.h"
#include "core/model/located_error.h"
#include "core/physics/world/lane_values.h"
#include "tests/unit/env/small_plugins.h"

namespace skybody {
namespace {

using test::Flight;
using test::InProcessFactory;
using testing::HasSubstr;

/// A robot's own controller: each rotor gets ten times the commanded thrust.
class Own : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.robot();  // one robot's
    setup.input(Signal::kCtbt, {0, -1, -1, -1}, {10, 1, 1, 1});
    setup.output(Signal::kRotorSpeed, 4);
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> in, Values<Real> out) const {
    for (int i = 0; i < 4; ++i) out.set(i, 10.0 * in[0]);
  }
};

/// Gives robot k of the team k + 1 times the commanded thrust.
class Share : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kCtbt, {0, -1, -1, -1}, {10, 1, 1, 1});
    for (const int robot : setup.team()) setup.output(Signal::kCtbt, 4, robot);
    count_ = setup.team().size();
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> in, Values<Real> out) const {
    for (int k = 0; k < count_; ++k) {
      out.set(4 * k, (k + 1.0) * in[0]);
      for (int i = 1; i < 4; ++i) out.set(4 * k + i, in[i]);
    }
  }

 private:
  int count_ = 0;
};

/// Commands the rotors of all its robots directly, every second physics step.
class ToRotors : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kSrt, {0}, {100});
    for (const int robot : setup.team()) setup.output(Signal::kRotorSpeed, 4, robot);
    setup.period(2);
    count_ = 4 * setup.team().size();
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> in, Values<Real> out) const {
    for (int k = 0; k < count_; ++k) out.set(k, in[0] + k);
  }

 private:
  int count_ = 0;
};

/// Commands a robot outside its team.
class Elsewhere : public ToRotors {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kSrt, {0}, {100});
    setup.output(Signal::kRotorSpeed, 4, 2);
  }
};

/// Pushes each of its robots up, robot k with (k + 1) times the commanded force.
class Push : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kSrt, {0}, {10});
    for (const int robot : setup.team()) {
      setup.output(Signal::kWrench, 6, robot);
      setup.site({setup.robots()[robot].first_body, {0, 0, 0}, 1, 1});
    }
    count_ = setup.team().size();
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> in, Values<Real> out) const {
    for (int k = 0; k < 6 * count_; ++k) out.set(k, Real(0.0));
    for (int k = 0; k < count_; ++k) out.set(6 * k + 2, (k + 1.0) * in[0]);
  }

 private:
  int count_ = 0;
};

/// Declares a site on a robot that receives no wrench.
class PushesAnother : public Push {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kSrt, {0}, {10});
    setup.output(Signal::kWrench, 6, 0);
    setup.site({setup.robots()[0].first_body, {0, 0, 0}, 1, 1});
    setup.site({setup.robots()[1].first_body, {0, 0, 0}, 1, 1});
  }
};

/// One value for each chain's command, interpolated over the physics steps of an action.
class Glide : public Task {
 public:
  void configure(const Setup& setup) override {
    setup.channel("none", "", 1, 0, 1);
    setup.action("push", "N", 1, 0.0, 8.0, 0);
    setup.interpolate();
    for (const ChainInfo& chain : setup.chains()) size_ += chain.count;
  }
  template <class Real>
  void process(const EnvView<Real>&, State<Real>&, ConstValues<Real> action,
               Values<Real> command) const {
    for (int k = 0; k < size_; ++k) command.set(k, action[0]);
  }
  template <class Real>
  void evaluate(const EnvView<Real>&, State<Real>&, Evaluation<Real>&) const {}

 private:
  int size_ = 0;
};

/// Writes arbitrary values to the whole command, and reads them back.
class Commands : public Task {
 public:
  void configure(const Setup& setup) override {
    setup.channel("chains", "", 1, 0, 100);
    chains_ = setup.chains().size();
    size_ = 0;
    for (const ChainInfo& chain : setup.chains()) size_ += chain.count;
  }
  template <class Real>
  void process(const EnvView<Real>&, State<Real>&, ConstValues<Real>, Values<Real> command) const {
    for (int k = 0; k < size_; ++k) command.set(k, Real(1.0 + k));
  }
  template <class Real>
  void evaluate(const EnvView<Real>&, State<Real>&, Evaluation<Real>& out) const {
    out.observation.set(0, Real(static_cast<double>(chains_)));
  }

 private:
  int chains_ = 0, size_ = 0;
};

/// Three quadrotors; robots 0 and 1 are a team unless `robots` lists others.
struct Case {
  std::vector<std::vector<std::string>> own = {{"own"}, {"own"}, {"own"}};
  std::vector<std::string> of_team = {"share"};
  std::vector<int> team = {0, 1};
  std::vector<std::string> of_second = {};  ///< a team of robots 2 and 0
  std::string task = "watch";
};

std::unique_ptr<CompiledScenario> make(InProcessFactory& factory, const Case& c,
                                       Checking checking = Checking::kNo) {
  factory.add<test::Watch>("watch");
  factory.add<test::Direct>("direct");
  factory.add<Commands>("commands");
  factory.add<Push>("push");
  factory.add<PushesAnother>("pushes_another");
  factory.add<Glide>("glide");
  factory.add<Own>("own");
  factory.add<Share>("share");
  factory.add<Share>("share_again");
  factory.add<ToRotors>("to_rotors");
  factory.add<Elsewhere>("elsewhere");
  Scenario s;
  s.name = "test";
  s.stepping.action_repeat = 4;
  s.contact.ground = false;
  for (std::size_t r = 0; r < c.own.size(); ++r) {
    RobotUse robot;
    robot.name = "quad" + std::to_string(r);
    robot.model = test::quadrotor();
    robot.pose.position.x = 5.0 * static_cast<double>(r);
    robot.rotor_speed = 100.0;
    for (const std::string& name : c.own[r]) robot.controllers.push_back(factory.use(name, name));
    s.robots.push_back(robot);
  }
  const auto add_team = [&](const char* name, const std::vector<int>& robots,
                            const std::vector<std::string>& controllers) {
    TeamUse team;
    team.name = name;
    team.robots = robots;
    for (const std::string& each : controllers) team.controllers.push_back(factory.use(each, each));
    s.teams.push_back(team);
  };
  add_team("pair", c.team, c.of_team);
  if (!c.of_second.empty()) add_team("second", {2, 0}, c.of_second);
  s.task = factory.use(c.task, "task");
  return std::make_unique<CompiledScenario>(std::move(s), factory, checking);
}

std::string refusal(const Case& c) {
  InProcessFactory factory;
  try {
    make(factory, c);
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

TEST(Teams, FeedTheOwnChainsOfTheirRobots) {
  InProcessFactory factory;
  const auto env = make(factory, {});
  EXPECT_EQ(env->action_size(), 8);  // the team's, then robot 2's
  EXPECT_EQ(env->agents(), (std::vector<int>{0, 2}));
  EXPECT_EQ(env->model().commands_of(0).size, 4);
  EXPECT_EQ(env->model().commands_of(1).size, 0);
  EXPECT_EQ(env->model().commands_of(2).size, 4);
  Flight flight(*env, 1);
  flight.reset();
  flight.step({-0.8f, 0, 0, 0, 1.0f, 0, 0, 0});  // thrusts 1 N and 10 N
  const std::vector<double> speeds = values(flight, env->layout().rotor_command);
  ASSERT_EQ(speeds.size(), 12u);
  // A float's -0.8 is 1 - 0.8 = 0.2 to 6e-8, times 5 N, times 10.
  EXPECT_NEAR(speeds[0], 10.0, 1e-5);
  EXPECT_NEAR(speeds[4], 20.0, 1e-5);
  EXPECT_EQ(speeds[8], 100.0);
}

TEST(Teams, MayReachActuatorsThemselvesAndHaveAPeriod) {
  InProcessFactory factory;
  Case c;
  c.own = {{}, {}, {"own"}};
  c.of_team = {"to_rotors"};
  const auto env = make(factory, c);
  EXPECT_EQ(env->action_size(), 5);
  Flight flight(*env, 1);
  flight.reset();
  flight.step({-1.0f, 1.0f, 0, 0, 0});
  const std::vector<double> speeds = values(flight, env->layout().rotor_command);
  for (int k = 0; k < 8; ++k) EXPECT_EQ(speeds[static_cast<std::size_t>(k)], k);
  EXPECT_EQ(speeds[8], 100.0);
}

TEST(Teams, HaveTheirRobotsInTheGivenOrder) {
  InProcessFactory factory;
  Case c;
  c.team = {2, 0};
  const auto env = make(factory, c);
  EXPECT_EQ(env->agents(), (std::vector<int>{1, 2}));
  Flight flight(*env, 1);
  flight.reset();
  flight.step({-1.0f, 0, 0, 0, 1.0f, 0, 0, 0});
  const std::vector<double> speeds = values(flight, env->layout().rotor_command);
  EXPECT_EQ(speeds[8], 100.0);
  EXPECT_EQ(speeds[0], 200.0);
}

TEST(Teams, LeaveTasksTheChainsThatNobodyFeeds) {
  InProcessFactory factory;
  Case c;
  c.task = "commands";
  const auto env = make(factory, c, Checking::kYes);
  Flight flight(*env, 1);
  flight.reset();
  EXPECT_EQ(flight.observation[0], 2.0f);
  flight.step(std::vector<float>(8, 0.0f));
  const std::vector<double> speeds = values(flight, env->layout().rotor_command);
  EXPECT_EQ(speeds[0], 10.0);
  EXPECT_EQ(speeds[4], 20.0);
  EXPECT_EQ(speeds[8], 50.0);
}

TEST(Teams, PushEachRobotAtItsOwnSites) {
  InProcessFactory factory;
  Case c;
  c.own = {{}, {}, {}};
  c.team = {2, 0};
  c.of_team = {"push"};
  const auto env = make(factory, c);
  Flight flight(*env, 1);
  flight.reset();
  flight.step({1.0f});
  // 10 N on robot 2 and 20 N on robot 0, of 1 kg each, over four steps of 1 ms; only robot 1 falls.
  const std::vector<BodyState> bodies = flight.group.body_states(0);
  const double fall = -9.81 * 0.004;
  EXPECT_NEAR(bodies[2].velocity.z, fall + 10.0 * 0.004, 1e-12);
  EXPECT_NEAR(bodies[0].velocity.z, fall + 20.0 * 0.004, 1e-12);
  // Its rotors continue at 100 rad/s: 4 rotors of 1e-6 N s^2 give 0.04 N.
  EXPECT_NEAR(bodies[1].velocity.z, fall + 0.04 * 0.004, 1e-9);
}

TEST(Teams, MayServeOneRobotTogether) {
  InProcessFactory one, both;
  Case c;
  const auto pair = make(one, c);
  c.of_second = {"push"};
  const auto with_second = make(both, c);
  EXPECT_EQ(with_second->action_size(), 4 + 4 + 1);  // the pair's, robot 2's, the second team's
  Flight without(*pair, 1), flight(*with_second, 1);
  without.reset();
  flight.reset();
  const std::vector<float> action = {0.5f, 0, 0, 0, 0.5f, 0, 0, 0};
  without.step(action);
  flight.step({0.5f, 0, 0, 0, 0.5f, 0, 0, 0, 1.0f});
  const std::vector<BodyState> free = without.group.body_states(0);
  const std::vector<BodyState> pushed = flight.group.body_states(0);
  EXPECT_EQ(pushed[1].velocity.z, free[1].velocity.z);
  EXPECT_NEAR(pushed[2].velocity.z, free[2].velocity.z + 10.0 * 0.004, 1e-12);
  EXPECT_NEAR(pushed[0].velocity.z, free[0].velocity.z + 20.0 * 0.004, 1e-12);
  const StateValues& states = with_second->state_values();
  EXPECT_EQ(states.at("teams.pair.command").shape, (std::vector<int>{4}));
  EXPECT_EQ(states.at("teams.second.command").shape, (std::vector<int>{1}));
  EXPECT_EQ(states.at("teams.second.command").first, with_second->layout().command.offset + 8);
}

TEST(Teams, FlyOnFromASavedState) {
  InProcessFactory factory;
  Case c;
  c.of_second = {"push"};
  const auto env = make(factory, c);
  Flight flight(*env, 1);
  flight.reset();
  const std::vector<float> action = {0.5f, 0.1f, 0, 0, 0.5f, 0, -0.1f, 0, 1.0f};
  for (int step = 0; step < 5; ++step) flight.step(action);
  const auto saved = flight.group.save(0);
  for (int step = 0; step < 5; ++step) flight.step(action);
  const auto later = flight.group.save(0);
  flight.group.restore(0, saved);
  for (int step = 0; step < 5; ++step) flight.step(action);
  EXPECT_EQ(flight.group.save(0), later);
}

TEST(Teams, AreRefusedSitesOnARobotThatGetsNoWrench) {
  Case c;
  c.own = {{}, {}, {}};
  c.of_team = {"pushes_another"};
  EXPECT_THAT(refusal(c), HasSubstr("declares wrench sites, but gives no wrench to the robot that "
                                    "has them"));
}

TEST(Teams, LeaveTheCommandsOfTasksThatInterpolateOnTheirWay) {
  InProcessFactory factory;
  Case c;
  c.task = "glide";
  const auto env = make(factory, c);
  Flight flight(*env, 1);
  flight.reset();
  flight.step({-1.0f});
  flight.step({1.0f});  // 0 to 8 N in four steps
  const std::vector<double> speeds = values(flight, env->layout().rotor_command);
  EXPECT_EQ(speeds[0], 80.0);
  EXPECT_EQ(speeds[4], 160.0);
  env->advance(flight.group, *flight.work, 1u, 1);  // commands hold, and teams still write inputs
  EXPECT_EQ(values(flight, env->layout().rotor_command)[4], 160.0);
}

TEST(Teams, HaveTheSameBitsInLanesAsAlone) {
  InProcessFactory factory;
  const auto env = make(factory, {});
  Flight group(*env, kGroupLanes), alone(*env, 1);
  group.reset();
  alone.reset();
  for (int k = 0; k < 20; ++k) {
    const auto push = static_cast<float>(0.04 * k - 0.4);
    const std::vector<float> row{push, 0.1f, -0.1f, 0, push, 0, 0, 0};
    std::vector<float> rows;
    for (int l = 0; l < kGroupLanes; ++l) rows.insert(rows.end(), row.begin(), row.end());
    group.step(rows);
    alone.step(row);
  }
  for (int k = 0; k < env->layout().words; ++k) {
    if (k == kEnvId) continue;
    ASSERT_EQ(group.group.bits(k)[0], alone.group.bits(k)[0]) << k;
  }
}

TEST(Teams, AreRefusedAControllerThatServesOneRobot) {
  Case c;
  c.own = {{}, {}, {"own"}};
  c.of_team = {"own"};
  EXPECT_THAT(refusal(c), HasSubstr("serves one robot, and is given a team of 2: move it to the "
                                    "`controllers` of a robot"));
}

TEST(Teams, AreRefusedAnOutputThatNobodyTakes) {
  Case c;
  c.own = {{"own"}, {"direct"}, {"own"}};
  EXPECT_THAT(refusal(c), HasSubstr("the last controller, `share`, gives ctbt[4]"));
  EXPECT_THAT(refusal(c), HasSubstr("to the team or to robot `quad1`"));
}

TEST(Teams, AreRefusedASecondOneForAChainThatIsFed) {
  Case c;
  c.of_team = {"share", "share_again"};
  EXPECT_THAT(refusal(c), HasSubstr("gives ctbt[4] to robot `quad0`, whose chain that takes it is "
                                    "fed by another output already"));
}

TEST(Teams, AreRefusedActuatorsThatARobotCommandsItself) {
  Case c;
  c.of_team = {"to_rotors"};
  EXPECT_THAT(refusal(c), HasSubstr("gives rotor_speed to robot `quad0`, whose actuators a chain "
                                    "before it commands already"));
}

TEST(Teams, AreRefusedAnOutputToAnotherRobot) {
  Case c;
  c.own = {{}, {}, {}};
  c.of_team = {"elsewhere"};
  EXPECT_THAT(refusal(c), HasSubstr("declares an output to robot 2, which it does not serve"));
}

}  // namespace
}  // namespace skybody
