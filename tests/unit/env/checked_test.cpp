// Checked mode: mistakes that would damage memory are reported with the plugin's name.
#include <gtest/gtest.h>
#include <skybody/task_kit.h>

#include "core/base/simd/fp_environment.h"
#include "core/model/located_error.h"
#include "tests/unit/env/small_plugins.h"

namespace skybody {
namespace {

using test::Flight;
using test::InProcessFactory;

/// Writes two observation values but declares one.
class Talkative : public Task {
 public:
  void configure(const Setup& setup) override { setup.channel("one", "", 1, 0, 1); }
  template <class Real>
  void evaluate(const EnvView<Real>&, State<Real>&, Evaluation<Real>& out) const {
    out.observation.set(0, Real(1.0));
    out.observation.set(1, Real(2.0));
  }
};

/// Requests a body that does not exist.
class FarLook : public Task {
 public:
  void configure(const Setup& setup) override { setup.channel("one", "", 1, 0, 1); }
  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    out.observation.set(0, env.body(3).position.z);
  }
};

/// Uses more of its buffer than it requested.
class Greedy : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kRotorSpeed, {0, 0, 0, 0}, {1, 1, 1, 1});
    setup.output(Signal::kRotorSpeed, 4);
    setup.buffer(2);
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> in, Values<Real> out,
               Values<Real> buffer) const {
    buffer.set(2, Real(1.0));
    for (int i = 0; i < 4; ++i) out.set(i, in[i]);
  }
};

/// Writes only the first of its four speeds.
class Forgetful : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kRotorSpeed, {0, 0, 0, 0}, {1, 1, 1, 1});
    setup.output(Signal::kRotorSpeed, 4);
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> in, Values<Real> out) const {
    out.set(0, in[0]);
  }
};

/// Writes robot rewards without declaring them.
class Generous : public Task {
 public:
  void configure(const Setup& setup) override { setup.channel("one", "", 1, 0, 1); }
  template <class Real>
  void evaluate(const EnvView<Real>&, State<Real>&, Evaluation<Real>& out) const {
    out.observation.set(0, Real(1.0));
    out.set_reward(0, Real(1.0));
  }
};

/// Omits one of its two infos.
class Secretive : public Task {
 public:
  void configure(const Setup& setup) override {
    setup.channel("one", "", 1, 0, 1);
    setup.info("told", "", 1);
    setup.info("untold", "", 1);
  }
  template <class Real>
  void evaluate(const EnvView<Real>&, State<Real>&, Evaluation<Real>& out) const {
    out.observation.set(0, Real(1.0));
    if (out.wants_info()) out.info.set(0, Real(1.0));
  }
};

/// Writes three values to a part of two, and so overwrites the next part.
class Overlong : public Task {
 public:
  void configure(const Setup& setup) override {
    velocity_ = parts_.add(setup, {"velocity", "m/s", 2, ""});
    height_ = parts_.add(setup, {"height", "m", 1, ""});
  }
  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>&, Evaluation<Real>& out) const {
    velocity_.set(out.observation, env.body(0).velocity);
    height_.set(out.observation, env.body(0).position.z);
  }

 private:
  task_kit::ObservationParts parts_;
  task_kit::Part velocity_, height_;
};

/// Reports success without having declared it; this would overwrite its first info.
class Hasty : public Task {
 public:
  void configure(const Setup& setup) override {
    setup.channel("one", "", 1, 0, 1);
    height_ = infos_.add(setup, "height", "m", "");
  }
  template <class Real>
  void evaluate(const EnvView<Real>&, State<Real>&, Evaluation<Real>& out) const {
    out.observation.set(0, Real(1.0));
    if (out.wants_info()) height_.set(out.info, Real(1.0));
    task_kit::Verdict<Real> verdict(out);
    verdict.succeed(success_, MaskOf<Real>(true));
  }

 private:
  task_kit::InfoParts infos_;
  task_kit::Part height_, success_;
};

class Moody : public Task {
 public:
  void configure(const Setup& setup) override { setup.channel("one", "", 1, 0, 1); }
  template <class Real>
  void evaluate(const EnvView<Real>&, State<Real>&, Evaluation<Real>&) const {
    throw std::runtime_error("not today");
  }
};

/// Outputs the commanded speeds, one of them divided by zero.
class Numberless : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kRotorSpeed, {0, 0, 0, 0}, {1, 1, 1, 1});
    setup.output(Signal::kRotorSpeed, 4);
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> in, Values<Real> out) const {
    for (int i = 0; i < 4; ++i) out.set(i, i == 2 ? (in[i] - in[i]) / Real(0.0) : in[i]);
  }
};

#ifdef __SSE2__
/// Works correctly, but leaves bits of the floating-point mode changed.
template <unsigned kChanged>
class Meddler : public Controller {
 public:
  void configure(const Setup& setup) override {
    setup.input(Signal::kRotorSpeed, {0, 0, 0, 0}, {1, 1, 1, 1});
    setup.output(Signal::kRotorSpeed, 4);
  }
  template <class Real>
  void control(const EnvView<Real>&, State<Real>&, ConstValues<Real> in, Values<Real> out) const {
    for (int i = 0; i < 4; ++i) out.set(i, in[i]);
    _mm_setcsr(_mm_getcsr() ^ kChanged);
  }
};
#endif

std::string mistake(const std::string& controller, const std::string& task) {
  InProcessFactory factory;
#ifdef __SSE2__
  factory.add<Meddler<0x2000>>("rounds_down");
  factory.add<Meddler<0x8000>>("flushes");
  factory.add<Meddler<0x0200>>("traps");
#endif
  factory.add<Numberless>("numberless");
  factory.add<test::Direct>("direct");
  factory.add<test::Watch>("watch");
  factory.add<Talkative>("talkative");
  factory.add<FarLook>("far_look");
  factory.add<Greedy>("greedy");
  factory.add<Forgetful>("forgetful");
  factory.add<Generous>("generous");
  factory.add<Moody>("moody");
  factory.add<Secretive>("secretive");
  factory.add<Overlong>("overlong");
  factory.add<Hasty>("hasty");
  Scenario s;
  s.name = "test";
  s.contact.ground = false;
  RobotUse robot;
  robot.name = "quad";
  robot.model = test::quadrotor();
  robot.controllers.push_back(factory.use(controller, controller));
  s.robots.push_back(robot);
  s.task = factory.use(task, "task");
  const CompiledScenario env(std::move(s), factory, Checking::kYes);
  Flight flight(env, 1);
  try {
    flight.reset();
    std::vector<float> infos(static_cast<std::size_t>(env.info_size()));
    Rows rows = flight.rows();
    rows.info = infos.data();
    const std::vector<float> actions(4, 0.0f);
    env.step(flight.group, *flight.work, flight.all, actions.data(), env.action_size(), rows);
  } catch (const LocatedError& e) {
    return e.message();
  }
  return "";
}

TEST(CheckedMode, SaysWhatIsTouchedBeyondItsEnd) {
  EXPECT_EQ(
      mistake("direct", "talkative"),
      "plugin `talkative` (task) asks for observation value 1; allowed: 0 to 0; this is a mistake "
      "in the plugin");
  EXPECT_EQ(mistake("direct", "far_look"),
            "plugin `far_look` (task) asks for body value 39; allowed: 0 to 12; this is a mistake "
            "in the plugin");
  EXPECT_EQ(mistake("greedy", "watch"),
            "plugin `greedy` (greedy) asks for buffer value 2; allowed: 0 to 1; this is a mistake "
            "in the plugin");
}

TEST(CheckedMode, SaysWhatIsNotWritten) {
  EXPECT_EQ(mistake("forgetful", "watch"),
            "plugin `forgetful` (forgetful) has not written output value 1 of 4; this is a mistake "
            "in the plugin");
}

TEST(CheckedMode, SaysWhichInfoIsNotWritten) {
  EXPECT_EQ(mistake("direct", "secretive"),
            "plugin `secretive` (task) has not written info value 1 of 2; this is a mistake in the "
            "plugin");
}

TEST(CheckedMode, NamesThePartThatIsWrittenBeyondItsEnd) {
  EXPECT_EQ(mistake("direct", "overlong"),
            "plugin `overlong` (task) asks for velocity value 2; allowed: 0 to 1; this is a "
            "mistake in the plugin");
}

TEST(CheckedMode, SaysThatAPartIsNotDeclared) {
  EXPECT_EQ(mistake("direct", "hasty"),
            "plugin `hasty` (task) asks for undeclared part value 0; allowed: none; this is a "
            "mistake in the plugin");
}

TEST(CheckedMode, SaysThatRewardsOfRobotsWereNotAnnounced) {
  EXPECT_EQ(mistake("direct", "generous"),
            "plugin `generous` (task) asks for robot reward value 0; allowed: none, unless "
            "configure() calls `robot_rewards()`; this is a mistake in the plugin");
}

TEST(CheckedMode, NamesThePluginThatThrows) {
  EXPECT_EQ(mistake("direct", "moody"),
            "plugin `moody` (task) throws in a step: not today; this is a mistake in the plugin");
}

TEST(CheckedMode, SaysWhichValueIsNoNumber) {
  EXPECT_EQ(mistake("numberless", "watch"),
            "plugin `numberless` (numberless) gives NaN as output value 2 of 4; this is a mistake "
            "in the plugin");
}

#ifdef __SSE2__
TEST(CheckedMode, NamesThePluginThatChangesTheFloatingPointMode) {
  const auto expected = [](const std::string& name, const std::string& what) {
    return "plugin `" + name + "` (" + name + ") changes the floating-point mode in a step (" +
           what +
           "), on which the bits of all flights rest: what a method changes it puts back before it "
           "returns; this is a mistake in the plugin";
  };
  EXPECT_EQ(mistake("rounds_down", "watch"), expected("rounds_down", "rounding"));
  EXPECT_EQ(mistake("flushes", "watch"), expected("flushes", "flushing of denormals to zero"));
  EXPECT_EQ(mistake("traps", "watch"), expected("traps", "traps at exceptions"));
  EXPECT_TRUE(has_standard_fp_environment()) << "the mode is put back";
}
#endif

TEST(CheckedMode, SaysNothingOfSoundPlugins) { EXPECT_EQ(mistake("direct", "watch"), ""); }

TEST(CheckedMode, GivesTheSameBits) {
  InProcessFactory factory;
  factory.add<test::Direct>("direct");
  factory.add<test::Watch>("watch");
  Scenario s;
  s.name = "test";
  RobotUse robot;
  robot.name = "quad";
  robot.model = test::quadrotor();
  robot.controllers.push_back(factory.use("direct", "direct"));
  s.robots.push_back(robot);
  s.task = factory.use("watch", "task");
  const CompiledScenario env(s, factory), checked_env(s, factory, Checking::kYes);
  EXPECT_EQ(checked_env.preferred_lanes(), 1);
  Flight plain(env, 1), checked(checked_env, 1);
  for (Flight* flight : {&plain, &checked}) {
    flight->reset();
    for (int k = 0; k < 20; ++k) flight->step({0.1f, 0.2f, 0.3f, 0.4f});
  }
  EXPECT_EQ(plain.group.save(0), checked.group.save(0));
}

}  // namespace
}  // namespace skybody
