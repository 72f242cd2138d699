// What effects hold over a physics step: order, sums, periods, resets, lanes.
#include <gtest/gtest.h>

#include <cmath>

#include "core/model/held_inputs.h"
#include "core/model/marked_error.h"
#include "core/physics/world/lane_values.h"
#include "tests/unit/env/small_plugins.h"

namespace skybody {
namespace {

using test::Flight;
using test::InProcessFactory;

/// Wind that grows by 1 m/s a call, a gain of 0.5 on thrust, limits and no rate.
class Breeze : public Effect {
 public:
  template <class Real>
  struct State {
    Real calls;
    Word<Real> last_physics_step;
  };
  IntegerParameter period{this, {.name = "period", .value = 1, .min = 1, .doc = "of calls"}};
  void configure(const Setup& setup) override {
    for (const HeldInput input :
         {HeldInput::kWind, HeldInput::kRotorGain, HeldInput::kRotorLimit}) {
      setup.holds(input);
    }
    setup.period(static_cast<int>(period.value()));
    setup.buffer(1);
    setup.report("calls", "", 1, 0);
  }
  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>& s, Held<Real>& held,
             Values<Real> buffer) const {
    s.calls += Real(1.0);
    s.last_physics_step = env.physics_step();
    buffer.set(0, s.calls);
    held.add_wind(0, {s.calls, Real(0.0), Real(0.0)});
    held.scale_thrust(1, Real(0.5));
    held.limit_speed(2, Real(10.0), Real(100.0) * s.calls);
  }
};

/// Says that it fills nothing, and fills wind.
class Liar : public Effect {
 public:
  void configure(const Setup&) override {}
  template <class Real>
  void apply(const EnvView<Real>&, State<Real>&, Held<Real>& held) const {
    held.add_wind(0, {Real(1.0), Real(0.0), Real(0.0)});
  }
};

std::unique_ptr<CompiledScenario> make(InProcessFactory& factory,
                                       const std::vector<std::string>& names, double period = 1.0,
                                       Checking checking = Checking::kNo) {
  factory.add<test::Direct>("direct");
  factory.add<test::Watch>("watch");
  factory.add<Breeze>("breeze");
  factory.add<Liar>("liar");
  Scenario s;
  s.name = "test";
  s.stepping.action_repeat = 4;
  s.contact.ground = false;
  RobotUse robot;
  robot.name = "quad";
  robot.model = test::quadrotor();
  robot.controllers.push_back(factory.use("direct", "direct"));
  s.robots.push_back(robot);
  for (const std::string& name : names) {
    const std::string plugin = name == "liar" ? "liar" : "breeze";
    s.effects.push_back(factory.use(plugin, name));
    if (plugin == "breeze") s.effects.back().parameters[0].numbers = {period};
  }
  s.task = factory.use("watch", "task");
  return std::make_unique<CompiledScenario>(std::move(s), factory, checking);
}

double held(const Flight& flight, SkybodyHeldInput input, int k) {
  return flight.group.reals(flight.env.layout().held[input])[k * flight.group.lanes()];
}

const std::vector<float> kHover(4, 0.0f);

TEST(Effects, SpeakBeforeEveryPhysicsStepAndHoldNeutralValuesElsewhere) {
  InProcessFactory factory;
  const auto env = make(factory, {"one"});
  Flight flight(*env, 1);
  flight.reset();
  EXPECT_EQ(held(flight, SKYBODY_HELD_WIND, 0), 0.0);
  EXPECT_EQ(held(flight, SKYBODY_HELD_ROTOR_GAIN, 4), 1.0);
  flight.step(kHover);
  const PluginInstance& e = env->plugins(SKYBODY_EFFECT)[0];
  EXPECT_EQ(flight.group.plugin_reals(e.state)[0], 4.0);
  EXPECT_EQ(flight.group.plugin_bits(e.state + 1)[0], 3u);  // before the fourth step
  EXPECT_EQ(held(flight, SKYBODY_HELD_WIND, 0), 4.0);       // added to nothing, not to the last
  EXPECT_EQ(held(flight, SKYBODY_HELD_ROTOR_GAIN, 4 * 1 + SKYBODY_GAIN_THRUST), 0.5);
  EXPECT_EQ(held(flight, SKYBODY_HELD_ROTOR_GAIN, 4 * 1 + SKYBODY_GAIN_DRAG), 1.0);
  EXPECT_EQ(held(flight, SKYBODY_HELD_ROTOR_LIMIT, 2 * 2 + 1), 400.0);
  EXPECT_EQ(env->layout().held[SKYBODY_HELD_WRENCH].size, 0);
}

TEST(Effects, AddToOneAnother) {
  InProcessFactory factory;
  const auto env = make(factory, {"one", "two"});
  Flight flight(*env, 1);
  flight.reset();
  flight.step(kHover);
  EXPECT_EQ(held(flight, SKYBODY_HELD_WIND, 0), 8.0);
  EXPECT_EQ(held(flight, SKYBODY_HELD_ROTOR_GAIN, 4), 0.25);
  EXPECT_EQ(held(flight, SKYBODY_HELD_ROTOR_LIMIT, 2 * 2), 10.0);
  EXPECT_EQ(held(flight, SKYBODY_HELD_ROTOR_LIMIT, 2 * 2 + 1), 400.0);
}

TEST(Effects, HoldWhatTheyGaveBetweenCalls) {
  InProcessFactory factory;
  const auto env = make(factory, {"one", "two"}, 3.0);  // calls before physics steps 0, 3, 6
  Flight flight(*env, 1);
  flight.reset();
  flight.step(kHover);
  EXPECT_EQ(held(flight, SKYBODY_HELD_WIND, 0), 4.0);
  flight.step(kHover);
  EXPECT_EQ(held(flight, SKYBODY_HELD_WIND, 0), 6.0);
  flight.reset();
  EXPECT_EQ(held(flight, SKYBODY_HELD_WIND, 0), 0.0);
  flight.step(kHover);
  EXPECT_EQ(held(flight, SKYBODY_HELD_WIND, 0), 4.0);
}

TEST(Effects, HaveTheSameBitsInAFullGroup) {
  InProcessFactory factory;
  const auto env = make(factory, {"one", "two"}, 3.0);
  Flight one(*env, 1), all(*env, kGroupLanes);
  one.reset();
  all.reset();
  for (int k = 0; k < 3; ++k) {
    one.step(kHover);
    all.step(std::vector<float>(4 * kGroupLanes, 0.0f));
  }
  EXPECT_EQ(one.group.save(0), all.group.save(0));
}

TEST(Effects, ReportValuesBesideTheObservation) {
  InProcessFactory factory;
  const auto env = make(factory, {"one"});
  Flight flight(*env, 1);
  std::vector<float> info(static_cast<std::size_t>(env->info_size()));
  ASSERT_EQ(env->info_channels().size(), 1u);
  EXPECT_EQ(env->info_channels()[0].name, "one.calls");
  flight.reset();
  Rows rows = flight.rows();
  rows.info = info.data();
  env->step(flight.group, *flight.work, 1u, kHover.data(), 4, rows);
  EXPECT_EQ(info[0], 4.0f);
}

TEST(Effects, AreToldInCheckedModeWhatTheyDidNotAnnounce) {
  InProcessFactory factory;
  const auto env = make(factory, {"liar"}, 1.0, Checking::kYes);
  Flight flight(*env, 1);
  flight.reset();
  try {
    flight.step(kHover);
    FAIL() << "nothing was said";
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(),
                 "plugin `liar` (liar) asks for held input value 0; allowed: none, what "
                 "configure() has not named by `holds()`; this is a "
                 "mistake in the plugin");
  }
}

}  // namespace
}  // namespace skybody
