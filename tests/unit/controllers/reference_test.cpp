// The controller `reference`: levels, points ahead, drawn values, infos, refusals.
#include <cmath>
#include <fstream>

#include "plugins/api/reference_point.h"
#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using ::testing::HasSubstr;

class ReferenceTest : public ::testing::Test {
 protected:
  ReferenceTest() { world.add_quad("quad"); }

  /// The output after a reset and `steps` physics steps of 1 ms.
  Numbers output(const Parameters& given, int steps) {
    PluginWorld own = world;
    const Instance reference("reference", own, given);
    Group g = reference.group(1);
    reference.call(Call::kReset, g);
    g.physics_step[0] = static_cast<std::uint64_t>(steps);
    reference.call(Call::kControl, g);
    return g.output;
  }
  std::string refused(const Parameters& given) {
    PluginWorld own = world;
    return refusal("reference", own, given);
  }
  std::string table(const std::string& text) {
    const std::string file = ::testing::TempDir() + "path.csv";
    std::ofstream(file) << text;
    return file;
  }

  PluginWorld world;
  const Parameters circle{{"kind", "circle"},
                          {"centre", Numbers{1, 2, 3}},
                          {"amplitude", Numbers{2, 2, 0}},
                          {"peak_speed", 3.0},
                          {"ramp", 0.0},
                          {"check", false}};
};

TEST_F(ReferenceTest, GivesPositionVelocityAccelerationOfACircleAtItsPeakSpeed) {
  const Numbers out = output(circle, 0);
  ASSERT_EQ(out.size(), 17u);
  EXPECT_NEAR(out[0], 3.0, 1e-12);
  EXPECT_NEAR(out[1], 2.0, 1e-12);
  EXPECT_NEAR(out[4], 3.0, 1e-12);           // along y
  EXPECT_NEAR(out[6], -9.0 / 2.0, 1e-12);    // v^2 / r inwards
  EXPECT_NEAR(out[10], -27.0 / 4.0, 1e-12);  // jerk
}

TEST_F(ReferenceTest, LowerLevelsAreThePartsOfTheTrajectory) {
  const Numbers whole = output(circle, 700);
  const std::vector<std::pair<const char*, std::array<std::size_t, 4>>> levels = {
      {"position", {0, 1, 2, 15}},
      {"velocity_tracking", {3, 4, 5, 16}},
      {"acceleration", {6, 7, 8, 15}}};
  for (const auto& [level, parts] : levels) {
    Parameters given = circle;
    given.insert({"gives", level});
    const Numbers part = output(given, 700);
    ASSERT_EQ(part.size(), 4u);
    for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(part[k], whole[parts[k]]) << level << k;
  }
}

TEST_F(ReferenceTest, PointsAheadAreWhatComesLater) {
  Parameters given = circle;
  given.insert({"points", 3});
  given.insert({"spacing", 0.25});
  const Numbers ahead = output(given, 100), later = output(circle, 600);
  ASSERT_EQ(ahead.size(), 51u);
  for (std::size_t k = 0; k < 17; ++k) EXPECT_NEAR(ahead[34 + k], later[k], 1e-12) << k;
}

TEST_F(ReferenceTest, ApproachBeginsWhereTheBaseIs) {
  Parameters given = circle;
  given.insert({"approach", 2.0});
  const Numbers out = output(given, 0), on = output(given, 2000);
  EXPECT_NEAR(out[0], 0.0, 1e-12);  // the robot is at 0, 0, 1
  EXPECT_NEAR(out[2], 1.0, 1e-12);
  EXPECT_NEAR(on[0], 3.0, 1e-12);
  EXPECT_NEAR(on[2], 3.0, 1e-12);
}

TEST_F(ReferenceTest, TellsWhereTheBaseShouldBeAtTheEndOfTheStep) {
  const Instance reference("reference", world, circle);
  ASSERT_EQ(reference.declared.reports.size(), 2u);
  Group g = reference.group(1);
  reference.call(Call::kReset, g);
  g.physics_step[0] = 499;
  reference.call(Call::kControl, g);
  const Numbers told(g.buffer.begin(), g.buffer.begin() + 3);
  g.physics_step[0] = 500;
  reference.call(Call::kControl, g);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(told[k], g.output[k], 1e-12);
}

TEST_F(ReferenceTest, EveryEnvironmentHasItsOwnNumbers) {
  const Instance reference("reference", world, circle);
  Group g = reference.group(2);
  g.at(g.params, reference.env_param("amplitude"), 1) = 1.0;
  g.at(g.params, reference.env_param("amplitude") + 1, 1) = 1.0;
  g.at(g.params, reference.env_param("peak_speed"), 1) = 2.0;
  reference.call(Call::kReset, g, 3);
  reference.call(Call::kControl, g, 3);
  EXPECT_NEAR(g.at(g.output, 4, 0), 3.0, 1e-12);
  EXPECT_NEAR(g.at(g.output, 4, 1), 2.0, 1e-12);
  EXPECT_NEAR(g.at(g.output, 6, 1), -4.0, 1e-12);
}

TEST_F(ReferenceTest, ASavedStateGoesOnAlike) {
  Parameters given = circle;
  given.insert({"approach", 1.0});
  const Instance reference("reference", world, given);
  Group g = reference.group(1);
  reference.call(Call::kReset, g);
  g.physics_step[0] = 300;
  const Group saved = g;
  g.bodies[0] = 5.0;  // the base's present position no longer matters
  Group again = saved;
  reference.call(Call::kControl, g);
  reference.call(Call::kControl, again);
  EXPECT_EQ(g.output, again.output);
}

TEST_F(ReferenceTest, GivesTheBitsOfDoubleForEveryKind) {
  const std::string file = table("t,x,y,z,yaw\n0,0,0,1,0\n0.5,1,0,1,1\n1,1,1,1,2\n1.4,0,1,2,7\n");
  const Numbers waypoints{0, 0, 1, 1, 0, 1, 1, 1, 2};
  const std::vector<Parameters> all = {
      circle,
      {{"kind", "lissajous"}, {"yaw", "tangent"}, {"approach", 0.5}},
      {{"kind", "helix"}, {"climb", 0.3}, {"gives", "position"}},
      {{"kind", "figure_eight"}, {"points", 2}},
      {{"kind", "waypoints"}, {"waypoints", waypoints}, {"peak_speed", 2.0}},
      {{"kind", "csv"}, {"file", file.c_str()}, {"yaw", "table"}, {"ramp", 0.5}, {"check", false}},
      {{"kind", "step"}, {"gives", "velocity_tracking"}},
      {{"kind", "hold"}, {"gives", "acceleration"}}};
  for (const Parameters& given : all) {
    PluginWorld own = world;
    expect_same_bits("reference", own, given);
  }
}

TEST_F(ReferenceTest, GivesTheSameBitsBesideALaneThatHasJustBegun) {
  for (const char* yaw : {"fixed", "tangent"}) {
    PluginWorld own = world;
    const Instance reference("reference", own,
                             {{"kind", "lissajous"},
                              {"amplitude", Numbers{1.5, 1.5, 0}},
                              {"yaw", yaw},
                              {"approach", 1.0}});
    Group g = reference.group(2);
    g.bodies[0] = -0.7;
    reference.call(Call::kReset, g, 3);
    for (std::uint64_t step = 3500; step < 9000; step += 501) {
      g.physics_step = {step, step};
      reference.call(Call::kControl, g, 3, 0);
      const Group together = g;
      g.physics_step = {step, 700};
      reference.call(Call::kControl, g, 3, 0);
      EXPECT_TRUE(together.alone(0).output == g.alone(0).output);
      EXPECT_EQ(std::memcmp(together.alone(0).output.data(), g.alone(0).output.data(), 17 * 8), 0)
          << yaw << step;
    }
  }
}

TEST_F(ReferenceTest, WaypointsArePassedAtTheirTimesAndAtThePeakSpeed) {
  const Numbers waypoints{0, 0, 1, 2, 0, 1, 2, 2, 2, 0, 2, 1};
  const Numbers out = output(
      {{"kind", "waypoints"}, {"waypoints", waypoints}, {"times", Numbers{0, 2, 4, 6}}}, 4000);
  EXPECT_NEAR(out[0], 2.0, 1e-11);
  EXPECT_NEAR(out[2], 2.0, 1e-11);
  double peak = 0.0;
  for (int k = 0; k < 12000; k += 20) {
    const Numbers at =
        output({{"kind", "waypoints"}, {"waypoints", waypoints}, {"peak_speed", 1.5}}, k);
    peak = std::max(peak, std::hypot(at[3], at[4], at[5]));
  }
  EXPECT_NEAR(peak, 1.5, 0.01);  // by 32 samples per piece, and by steps of 20 ms here
}

TEST_F(ReferenceTest, ATablesRowsArePassed) {
  const std::string file = table("# made by hand\nt,x,y,z\n1,0,0,1\n1.5,1,0,1\n2,1,1,1\n");
  const Parameters given{{"kind", "csv"}, {"file", file.c_str()}, {"check", false}};
  EXPECT_NEAR(output(given, 500)[0], 1.0, 1e-11);
  EXPECT_NEAR(output(given, 1000)[1], 1.0, 1e-11);
  EXPECT_NEAR(output(given, 9000)[1], 1.0, 1e-11);  // rests there
}

TEST_F(ReferenceTest, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refused({{"kind", "circle"}, {"cycles", Numbers{1, 1, 1}}}),
              HasSubstr("`cycles` says nothing with `kind: circle`; it belongs to lissajous"));
  EXPECT_THAT(refused({{"kind", "circle"}, {"period", 3.0}, {"peak_speed", 1.0}}),
              HasSubstr("`period` 3 s and `peak_speed` 1 m/s are both given"));
  EXPECT_THAT(refused({{"kind", "hold"}, {"gives", "position"}, {"points", 2}}),
              HasSubstr("`points` is 2, but `position` is of one moment"));
  EXPECT_THAT(refused({{"kind", "hold"}, {"yaw", "table"}}), HasSubstr("needs a column `yaw`"));
}

TEST_F(ReferenceTest, BadWaypointsNameTheirNumbers) {
  const auto with = [](const Numbers& places, const Numbers& times) {
    return Parameters{{"kind", "waypoints"}, {"waypoints", places}, {"times", times}};
  };
  EXPECT_THAT(refused(with({0, 0, 1, 1, 0, 1, 1, 0, 1.0004}, {0, 1, 2})),
              HasSubstr("waypoints 1 and 2 are 0.0004 m apart, which is on one another"));
  EXPECT_THAT(refused(with({0, 0, 1, 1}, {0, 1})), HasSubstr("`waypoints` has 4 values"));
  EXPECT_THAT(refused(with({0, 0, 1, 1, 0, 1}, {0, 1, 2})), HasSubstr("`times` has 3 values"));
  EXPECT_THAT(refused(with({0, 0, 1, 1, 0, 1, 2, 0, 1}, {0, 2, 2})),
              HasSubstr("`times[2]` is 2 s, not after the one before, 2 s"));
  EXPECT_THAT(refused({{"kind", "waypoints"}, {"waypoints", Numbers{0, 0, 1, 1, 0, 1}}}),
              HasSubstr("without a pace: add `times`, or `peak_speed`"));
}

TEST_F(ReferenceTest, BadTablesNameTheLine) {
  const auto with = [this](const std::string& text) {
    return refused({{"kind", "csv"}, {"file", table(text).c_str()}});
  };
  EXPECT_THAT(refused({{"kind", "csv"}, {"file", "nowhere.csv"}}), HasSubstr("no such file"));
  EXPECT_THAT(refused({{"kind", "csv"}}), HasSubstr("`kind: csv` needs `file`"));
  EXPECT_THAT(with("x,y,z\n"), HasSubstr("path.csv:1: the first line must be t,x,y,z"));
  EXPECT_THAT(with("t,x,y,z\n0,0,0,1\n"), HasSubstr("the file has 1 row"));
  EXPECT_THAT(with("t,x,y,z\n0,0,0,1\n1,0,,1\n"), HasSubstr("path.csv:3: `y` is missing"));
  EXPECT_THAT(with("t,x,y,z\n0,0,0,1\n0,1,0,1\n"), HasSubstr("path.csv:3: the time 0 s"));
  EXPECT_THAT(with("t,x,y,z\n0,0,0,1\n0.1,0,0,1\n0.2,0,0,1\n3,1,0,1\n"),
              HasSubstr("path.csv:5: a gap of 2.8 s, where the median interval is 0.1 s"));
}

/// The QDrone2 of PluginWorld: 1.54 kg, four rotors of 9.853 N each.
class FlyableTest : public ReferenceTest {
 protected:
  static Parameters fast(double speed, double scale = 1.0, double radius = 2.0) {
    return {{"kind", "circle"},
            {"amplitude", Numbers{radius, radius, 0}},
            {"peak_speed", speed},
            {"time_scale", scale},
            {"ramp", 2.0 * radius}};
  }
  static double number_behind(const std::string& text, const std::string& words) {
    const std::size_t place = text.find(words);
    return place == std::string::npos ? 0.0 : std::stod(text.substr(place + words.size()));
  }
};

TEST_F(FlyableTest, AWideCircleIsRefusedForItsThrustWithTheFastestScaleThatBreaksNoLimit) {
  // So wide that torques are negligible: 1.54 kg sqrt(g^2 + (v^2 / 200 m)^2) equals the rotors'
  // 39.42 N at v = 68.6 m/s.
  const double most = 4 * 1.9533e-6 * 2246.0 * 2246.0;
  const double speed = std::sqrt(200 * std::sqrt(std::pow(most / 1.54, 2) - 9.81 * 9.81));
  EXPECT_EQ(refused(fast(0.995 * speed, 1.0, 200)), "");
  const std::string why = refused(fast(100.0, 1.0, 200));
  EXPECT_THAT(why, HasSubstr("the reference cannot be flown: thrust at "));
  EXPECT_NEAR(number_behind(why, "takes "), 1.54 * std::hypot(9.81, 50.0), 0.05);
  EXPECT_NEAR(number_behind(why, "the vehicle has "), most, 0.01);
  const double scale = number_behind(why, "breaks no limit is ");
  EXPECT_NEAR(scale, speed / 100, 0.003);  // bisection to 0.1 %, plus the torques
  EXPECT_EQ(refused(fast(100.0, 0.999 * scale, 200)), "");
  EXPECT_NE(refused(fast(100.0, 1.01 * scale, 200)), "");
}

TEST_F(FlyableTest, UpAndDownIsBoundByTheFall) {
  // amplitude (2 pi / T)^2 s^2 = 0.95 g
  const Parameters falls{{"kind", "lissajous"},
                         {"amplitude", Numbers{0, 0, 1}},
                         {"cycles", Numbers{1, 1, 1}},
                         {"period", 1.8},
                         {"ramp", 4.0}};
  const std::string why = refused(falls);
  EXPECT_THAT(why, HasSubstr("N, the least with which it keeps an attitude is 0.755"));
  EXPECT_NEAR(number_behind(why, "breaks no limit is "),
              std::sqrt(0.95 * 9.81) / (2 * 3.14159265358979 / 1.8), 2e-3);
}

TEST_F(FlyableTest, TiltsRatesAndTorquesAreNamed) {
  Parameters tilts = fast(4.0);  // atan(8 / 9.81) = 0.684 rad
  tilts.insert({"max_tilt", 0.6});
  EXPECT_THAT(refused(tilts), HasSubstr("tilt at "));
  EXPECT_NEAR(number_behind(refused(tilts), "takes "), 0.684, 1e-3);
  Parameters turns{{"kind", "circle"}, {"amplitude", Numbers{0.01, 0.01, 0}},
                   {"period", 1.0},    {"yaw", "tangent"},
                   {"max_rate", 6.0},  {"ramp", 4.0}};  // 2 pi rad/s
  EXPECT_THAT(refused(turns), HasSubstr("yaw rate at "));
  const Parameters shakes{
      {"kind", "lissajous"}, {"amplitude", Numbers{0.02, 0, 0}}, {"period", 0.14}, {"ramp", 4.0}};
  EXPECT_THAT(refused(shakes), HasSubstr("torque about x and y beside the thrust at "));
}

TEST_F(FlyableTest, JumpsAreRefusedAndTheCheckCanBeLeftOut) {
  Parameters jump = circle;
  jump.at("check") = true;
  EXPECT_THAT(refused(jump), HasSubstr("jump of the velocity at the start at 0 s takes 3 m/s"));
  EXPECT_THAT(refused(jump), HasSubstr("add a `ramp`, or take `check: false`"));
  jump.at("check") = false;
  EXPECT_EQ(refused(jump), "");
  const std::string ends = table("t,x,y,z\n0,0,0,1\n1,0,0,1\n2,0.1,0,1\n3,0.9,0,1\n");
  EXPECT_THAT(refused({{"kind", "csv"}, {"file", ends.c_str()}, {"ramp", 1.0}}),
              HasSubstr("jump of the velocity at the end"));
}

TEST_F(ReferenceTest, DerivativesGoThroughTheNumbersOfThePath) {
  Parameters given = circle;
  given.insert({"approach", 1.0});
  expect_derivatives({"reference", world, given, Call::kControl, {}}, {"params", "state"});
}

}  // namespace
}  // namespace skybody::testing
