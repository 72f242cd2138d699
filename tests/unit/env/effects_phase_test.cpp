// Held outputs of effects over a physics step: order, sums, periods, resets, lanes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/model/held_inputs.h"
#include "core/model/located_error.h"
#include "core/physics/world/lane_values.h"
#include "tests/unit/env/small_plugins.h"

namespace skybody {
namespace {

using test::Flight;
using test::InProcessFactory;

/// Wind that grows by 1 m/s per call, a gain of 0.5 on thrust, limits; rates stay unchanged.
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

/// Declares no outputs, but writes wind.
class Liar : public Effect {
 public:
  void configure(const Setup&) override {}
  template <class Real>
  void apply(const EnvView<Real>&, State<Real>&, Held<Real>& held) const {
    held.add_wind(0, {Real(1.0), Real(0.0), Real(0.0)});
  }
};

/// Steady wind of randomizable strength; counts its calls.
class Steady : public Effect {
 public:
  RealParameter strength{
      this, {.name = "strength", .value = 2.0, .max = 10.0, .doc = "of it", .randomizable = true}};
  void configure(const Setup& setup) override {
    setup.holds(HeldInput::kWind);
    setup.steady();
    setup.buffer(1);
  }
  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>&, Held<Real>& held, Values<Real> buffer) const {
    buffer.set(0, buffer[0] + 1.0);
    held.add_wind(0, {strength(env), Real(0.0), Real(0.0)});
  }
};

/// Declares itself steady and requests a call every second physics step.
class Fickle : public Effect {
 public:
  void configure(const Setup& setup) override {
    setup.steady();
    setup.period(2);
  }
  template <class Real>
  void apply(const EnvView<Real>&, State<Real>&, Held<Real>&) const {}
};

std::unique_ptr<CompiledScenario> make(InProcessFactory& factory,
                                       const std::vector<std::string>& names, double period = 1.0,
                                       Checking checking = Checking::kNo) {
  factory.add<test::Direct>("direct");
  factory.add<test::Watch>("watch");
  factory.add<Breeze>("breeze");
  factory.add<Liar>("liar");
  factory.add<Steady>("steady");
  factory.add<Fickle>("fickle");
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
    const bool is_breeze = name == "one" || name == "two";
    const std::string plugin = is_breeze ? "breeze" : name;
    s.effects.push_back(factory.use(plugin, name));
    if (is_breeze) s.effects.back().parameters[0].numbers = {period};
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
  EXPECT_EQ(flight.group.plugin_reals(e.memory.state)[0], 4.0);
  EXPECT_EQ(flight.group.plugin_bits(e.memory.state + 1)[0], 3u);  // before the fourth step
  EXPECT_EQ(held(flight, SKYBODY_HELD_WIND, 0), 4.0);  // added to zero, not to the last value
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

/// Number of calls of the first effect, which is steady, in a lane.
double calls(const Flight& flight, int lane = 0) {
  const PluginInstance& e = flight.env.plugins(SKYBODY_EFFECT)[0];
  return flight.group.reals(flight.env.layout().plugin_state.offset + e.memory.buffer)[lane];
}

void set_strength(Flight& flight, int lane, double value) {
  const StateLayout& layout = flight.env.layout();
  for (int k = 0; k < layout.params.size; ++k) {
    if (layout.param_info[static_cast<std::size_t>(k)].path != "effects.steady.strength") continue;
    flight.group.writable({layout.params.offset + k, 1}, 1u << lane)[lane] = value;
  }
}

TEST(Effects, ThatAreSteadySpeakOnceAnEpisodeAndWhereParametersChange) {
  InProcessFactory factory;
  const auto env = make(factory, {"steady"});
  Flight flight(*env, 1);
  for (int episode = 0; episode < 2; ++episode) {
    flight.reset();
    EXPECT_EQ(held(flight, SKYBODY_HELD_WIND, 0), 0.0);
    for (int k = 0; k < 3; ++k) flight.step(kHover);
    EXPECT_EQ(calls(flight), 1.0);
    EXPECT_EQ(held(flight, SKYBODY_HELD_WIND, 0), 2.0 + episode);
    set_strength(flight, 0, 3.0);
    EXPECT_EQ(calls(flight), 1.0);
    for (int k = 0; k < 3; ++k) flight.step(kHover);
    EXPECT_EQ(calls(flight), 2.0);
    EXPECT_EQ(held(flight, SKYBODY_HELD_WIND, 0), 3.0);
  }
}

TEST(Effects, ThatAreSteadySpeakInThoseLanesWhoseParametersChange) {
  InProcessFactory factory;
  const auto env = make(factory, {"steady", "one"});  // two effects hold the wind
  Flight flight(*env, kGroupLanes);
  const std::vector<float> hover(4 * kGroupLanes, 0.0f);
  flight.reset();
  flight.step(hover);
  set_strength(flight, 5, 7.0);
  flight.step(hover);
  const double* wind = flight.group.reals(env->layout().held[SKYBODY_HELD_WIND]);
  for (int lane = 0; lane < kGroupLanes; ++lane) {
    EXPECT_EQ(calls(flight, lane), lane == 5 ? 2.0 : 1.0);
    EXPECT_EQ(wind[lane], 8.0 + (lane == 5 ? 7.0 : 2.0));
  }
}

TEST(Effects, ThatAreSteadyFollowTheParametersOfARestoredState) {
  InProcessFactory factory;
  const auto env = make(factory, {"steady"});
  Flight drawn(*env, 1), other(*env, 1);
  drawn.reset();
  set_strength(drawn, 0, 7.0);
  const auto before = drawn.group.save(0);  // no effect was called since
  drawn.step(kHover);
  other.reset();
  other.step(kHover);
  other.group.restore(0, before);
  other.step(kHover);
  EXPECT_EQ(held(other, SKYBODY_HELD_WIND, 0), 7.0);
  EXPECT_EQ(other.group.save(0), drawn.group.save(0));
}

TEST(Effects, ThatAreSteadyHaveNoPeriod) {
  InProcessFactory factory;
  try {
    make(factory, {"fickle"});
    FAIL() << "nothing was said";
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("declares a period and that it is steady"));
  }
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
  } catch (const LocatedError& e) {
    EXPECT_EQ(e.message(),
              "plugin `liar` (liar) asks for held input value 0; allowed: none, what "
              "configure() has not named by `holds()`; this is a "
              "mistake in the plugin");
  }
}

}  // namespace
}  // namespace skybody
