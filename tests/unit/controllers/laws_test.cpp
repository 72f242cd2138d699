// Common properties of all control laws:
// - they follow a curve
// - they save and restore in mid-flight
// - a NaN affects only its own lane
// - the commanded thrust is never negative
// - they right a body that lies on its back
#include <limits>

#include "tests/unit/controllers/flight.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;

/// A chain that follows trajectories.
struct Law {
  std::string name;
  std::vector<Link> chain;
  double error;         ///< limit of the RMS error on the curve [m]
  int thrust_from = 0;  ///< the controller whose first output is the thrust [N]
};

void PrintTo(const Law& law, std::ostream* out) { *out << law.name; }

const Parameters kRates{{"feed_forward", true}};

Parameters flatness(const char* output) {
  return {{"output", output},
          {"kp", std::vector<double>{6, 6, 9}},
          {"kd", std::vector<double>{4, 4, 5.4}}};
}

std::vector<Law> laws() {
  return {
      // With acceleration, jerk and snap of the curve and the rotors' drag fed forward, errors of
      // millimetres remain, caused by the rotors' lag.
      {"geometric", {{"geometric", {}}, {"ctbt", {}}}, 0.005},
      {"geometric_rates", {{"geometric", {{"output", "ctbr"}}}, {"ctbr", {}}}, 0.005},
      // No drag is fed forward: 0.08 1/s times 1.5 m/s over kp.
      {"position",
       {{"position", {{"signal", "trajectory"}}}, {"attitude", kRates}, {"ctbr", {}}},
       0.03},
      {"position_integral",
       {{"position", {{"signal", "trajectory"}, {"ki", std::vector<double>{1, 1, 1}}}},
        {"attitude", kRates},
        {"ctbr", {}}},
       0.03},
      {"flatness", {{"flatness", flatness("attitude")}, {"attitude", kRates}, {"ctbr", {}}}, 0.005},
      // Without rates the attitude lags by 1 / gain of the attitude loop.
      {"force",
       {{"flatness", flatness("force")}, {"force", {}}, {"attitude", {}}, {"ctbr", {}}},
       0.06,
       1},
      {"acceleration",
       {{"flatness", flatness("acceleration")},
        {"acceleration", {}},
        {"force", {}},
        {"attitude", {}},
        {"ctbr", {}}},
       0.06,
       2},
      {"sliding_mode", {{"sliding_mode", {}}, {"ctbt", {}}}, 0.005},
      {"lqr", {{"lqr", {}}, {"ctbt", {}}}, 0.005},
      {"lqr_rates", {{"lqr", {{"output", "ctbr"}}}, {"ctbr", {}}}, 0.005},
  };
}

class Laws : public ::testing::TestWithParam<Law> {
 protected:
  Laws() { world.add_quad("quad"); }
  const std::vector<Link>& chain() const { return GetParam().chain; }
  PluginWorld world;
};

std::string name_of(const ::testing::TestParamInfo<Law>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(All, Laws, ::testing::ValuesIn(laws()), name_of);

TEST_P(Laws, FollowsACurveOfOneAndAHalfMetresASecond) {
  Chain control(world, chain());
  Flight flight(world);
  flight.p = lissajous(0.0).position;
  flight.v = lissajous(0.0).velocity;
  control.reset(flight);
  double sum = 0.0;
  int counted = 0;
  for (int n = 0; n < 14000; ++n) {
    const ReferencePoint<double> point = lissajous(n * world.dt);
    flight.step(control.control(flight, trajectory_of(point)), true);
    if (n < 4000) continue;
    sum += squared_norm(flight.p - lissajous((n + 1) * world.dt).position);
    ++counted;
  }
  EXPECT_LT(std::sqrt(sum / counted), GetParam().error);
  RecordProperty("rms_mm", std::to_string(1e3 * std::sqrt(sum / counted)));
  // Without yaw rate feed-forward, the heading lags by the yaw rate over the attitude's gain, 3
  // 1/s.
  EXPECT_NEAR(wrap_angle(yaw(flight.q) - 0.3 * 14.0), 0.0, 0.11);
}

TEST_P(Laws, GoesOnWithTheSameBitsWhereItIsRestored) {
  Chain control(world, chain());
  Flight flight(world);
  control.reset(flight);
  for (int n = 0; n < 500; ++n) {
    flight.step(control.control(flight, trajectory_of(lissajous(n * world.dt))), true);
  }
  PluginWorld other_world;
  other_world.add_quad("quad");
  Chain restored(other_world, chain());
  Flight other(other_world);
  other.p = flight.p, other.v = flight.v, other.w = flight.w, other.q = flight.q;
  other.speed = flight.speed;
  for (std::size_t i = 0; i < control.groups.size(); ++i) {
    restored.groups[i].state = control.groups[i].state;
    restored.groups[i].buffer = control.groups[i].buffer;
  }
  for (int n = 500; n < 1000; ++n) {
    const std::vector<double> input = trajectory_of(lissajous(n * world.dt));
    const std::vector<double> a = control.control(flight, input),
                              b = restored.control(other, input);
    ASSERT_EQ(a, b) << "step " << n;
    flight.step(a, true);
    other.step(b, true);
  }
}

TEST_P(Laws, LetsANaNThroughInItsOwnLaneAlone) {
  const Instance law(chain()[0].plugin, world, chain()[0].given);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> point = trajectory_of(lissajous(0.7));
  for (int bad = 0; bad < 17; ++bad) {
    Group clean = law.group(4);
    for (int k = 0; k < 17; ++k) {
      for (int l = 0; l < 4; ++l) clean.at(clean.input, k, l) = point[static_cast<std::size_t>(k)];
    }
    Group spoilt = clean;
    spoilt.at(spoilt.input, bad, 2) = kNan;
    law.call(Call::kControl, clean, 15);
    law.call(Call::kControl, spoilt, 15);
    bool is_nan = false;
    for (int k = 0; k < static_cast<int>(law.declared.controller.output_count()); ++k) {
      is_nan = is_nan || std::isnan(spoilt.at(spoilt.output, k, 2));
      for (const int l : {0, 1, 3}) {
        EXPECT_EQ(clean.at(clean.output, k, l), spoilt.at(spoilt.output, k, l));
      }
    }
    // Jerk, snap and yaw rate matter only if they are fed forward.
    const bool may_be_left_out = (bad >= 9 && bad < 15) || bad == 16;
    EXPECT_TRUE(is_nan || may_be_left_out) << "value " << bad << " of the reference";
  }
}

TEST_P(Laws, AsksForNoThrustOnItsBack) {
  Chain control(world, chain());
  Flight flight(world);
  flight.q = {0.0, 1.0, 0.0, 0.0};  // rolled by half a turn
  control.reset(flight);
  for (const double speed : control.control(flight, trajectory_of(standing_at({0, 0, 1})))) {
    EXPECT_TRUE(std::isfinite(speed));
  }
  EXPECT_EQ(control.groups[static_cast<std::size_t>(GetParam().thrust_from)].output[0], 0.0);
}

TEST_P(Laws, StaysFiniteWhereTheReferenceFallsFreely) {
  Chain control(world, chain());
  const Flight flight(world);
  control.reset(flight);
  ReferencePoint<double> point = standing_at(flight.p);
  point.acceleration = {0, 0, -world.gravity};
  point.jerk = {1, 2, 3};
  for (const double speed : control.control(flight, trajectory_of(point))) {
    EXPECT_TRUE(std::isfinite(speed));
  }
}

TEST_P(Laws, BringsABodyUpThatLiesOnItsBack) {
  Chain control(world, chain());
  Flight flight(world);
  flight.p = {0, 0, 20};
  flight.q = from_rpy(3.0, 0.0, 0.4);
  control.reset(flight);
  const std::vector<double> input = trajectory_of(standing_at({0, 0, 20}));
  // An integral decays at ki / kp, 0.25 1/s.
  for (int n = 0; n < 20000; ++n) flight.step(control.control(flight, input), true);
  EXPECT_NEAR(tilt_cosine(flight.q), 1.0, 1e-4);
  EXPECT_LT(norm(flight.p - Vec3<double>{0, 0, 20}), 0.02);
}

TEST_P(Laws, GivesTheBitsOfDoubleInEveryInstructionSet) {
  expect_same_bits(chain()[0].plugin, world, chain()[0].given);
}

TEST(LawsOfBadConfiguration, NameValueAndRemedy) {
  PluginWorld world;
  world.add_quad("quad");
  EXPECT_THAT(refusal("geometric", world, {{"max_acceleration_down", 9.5}}),
              HasSubstr("`max_acceleration_down` 9.5 would leave no thrust"));
  EXPECT_THAT(refusal("geometric", world, {{"position_min", std::vector<double>{6, 0, 0}}}),
              HasSubstr("`position_min[0]` 6 is not below `position_max[0]` 5"));
  EXPECT_THAT(refusal("acceleration", world, {{"max_acceleration_down", 9.5}}),
              HasSubstr("`max_acceleration_down` 9.5 would leave no thrust"));
  EXPECT_THAT(refusal("velocity_tracking", world, {{"max_acceleration_down", 9.5}}),
              HasSubstr("`max_acceleration_down` 9.5 would leave no thrust"));
  EXPECT_THAT(refusal("flatness", world, {{"position_max", std::vector<double>{5, 5, 0.5}}}),
              HasSubstr("`position_min[2]` 0.5 is not below `position_max[2]` 0.5"));
  EXPECT_THAT(refusal("sliding_mode", world, {{"max_acceleration_down", 9.5}}),
              HasSubstr("`max_acceleration_down` 9.5 would leave no thrust"));
  EXPECT_THAT(refusal("lqr", world, {{"thrust_weight", 1e300}}), HasSubstr("Riccati equation"));
  EXPECT_THAT(refusal("force", world, {{"yaw", 0.3}}), HasSubstr("set `takes_yaw: false`"));
  EXPECT_THAT(refusal("position", world, {{"points", 3}}), HasSubstr("set `signal: trajectory`"));
}

TEST(LawsOfBadConfiguration, WithoutGravityAForceNeedsItsRange) {
  PluginWorld world;
  world.add_quad("quad");
  world.gravity = 0.0;
  EXPECT_THAT(refusal("force", world, {}), HasSubstr("`max_force` has no default"));
  EXPECT_THAT(refusal("lqr", world, {}), HasSubstr("would leave no thrust"));
}

}  // namespace
}  // namespace skybody::testing
