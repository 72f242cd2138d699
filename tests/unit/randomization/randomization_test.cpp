// Randomizers: physical values, no drift, schedules, starts, bad configuration.
#include <cmath>
#include <set>

#include "core/base/math/inertia.h"
#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;
using Numbers = std::vector<double>;
using Texts = std::vector<std::string>;

class Randomization : public ::testing::Test {
 protected:
  Randomization() { world.add_quad("quad", 1.0, 2.0, 3.0); }
  void reset(const Instance& r, Group& g) {
    ++g.episode[0];
    r.call(Call::kRandomize, g);
  }
  double& param(Group& g, int k) { return g.params[static_cast<std::size_t>(k)]; }
  /// Values of a start from `path` on, after robots.NAME.start.
  Numbers start(const Group& g, const std::string& path, int count,
                const std::string& robot = "quad") {
    const std::string first = "robots." + robot + ".start." + path;
    for (std::size_t k = 0; k < world.params.size(); ++k) {
      if (first != world.params[k].path) continue;
      const auto begin = g.params.begin() + static_cast<std::ptrdiff_t>(k);
      return {begin, begin + count};
    }
    throw std::logic_error("no " + first);
  }
  Numbers pose(const Group& g, const std::string& robot = "quad") {
    Numbers q = start(g, "position[0]", 3, robot);
    const Numbers rotation = start(g, "rotation[0]", 4, robot);
    q.insert(q.end(), rotation.begin(), rotation.end());
    return q;
  }
  double rotor_start(const Group& g, int k) {
    return start(g, "rotors[" + std::to_string(k) + "].speed", 1)[0];
  }
  PluginWorld world;
};

TEST_F(Randomization, GivesTheBitsOfDouble) {
  world.add_payload("bob");
  expect_same_bits("vehicle_constants", world,
                   {{"mass", Numbers{0.9, 1.1}}, {"tau_up", Numbers{0.5, 2.0}}, {"every", 3}});
  expect_same_bits("start", world,
                   {{"position_min", Numbers{-5, -5, 0.3}},
                    {"position_max", Numbers{5, 5, 3}},
                    {"tilt_max", 1.0},
                    {"velocity_max", 2.0},
                    {"rate_max", 3.0},
                    {"yaw_min", -1.0},
                    {"yaw_max", 2.0},
                    {"rotor_speed", "hover"}});
  expect_same_bits("draw", world,
                   {{"what", Texts{"robot.rotors[*].constant0"}},
                    {"range", Numbers{0.9, 1.1}},
                    {"form", "scale"}});
}

TEST_F(Randomization, InertiaStaysPhysicalAndNeverDrifts) {
  const Instance r("vehicle_constants", world,
                   {{"mass", Numbers{0.9, 1.1}},
                    {"inertia", Numbers{0.8, 1.25}},
                    {"thrust_constant", Numbers{0.95, 1.05}}});
  Group g = r.group(1);
  const SkybodyBodyInfo& body = world.bodies[0];
  const int m = body.first_param, kf = world.rotors[2].first_param;
  const int resets = 10000;
  double mass = 0, thrust = 0;
  for (int n = 0; n < resets; ++n) {
    reset(r, g);
    const double scale = param(g, m) / body.mass;
    ASSERT_GE(scale, 0.9);
    ASSERT_LE(scale, 1.1);
    const double j = param(g, m + 4) / body.inertia[0] / scale;
    ASSERT_GE(j, 0.8 - 1e-12);
    ASSERT_LE(j, 1.25 + 1e-12);
    ASSERT_TRUE(
        is_physical_inertia(SymMat3<double>{param(g, m + 4), param(g, m + 5), param(g, m + 6),
                                            param(g, m + 7), param(g, m + 8), param(g, m + 9)}));
    mass += scale;
    thrust += param(g, kf) / 1.9533e-6;
  }
  EXPECT_NEAR(mass / resets, 1.0, 5.0 * 0.2 / std::sqrt(12.0 * resets));
  EXPECT_NEAR(thrust / resets, 1.0, 5.0 * 0.1 / std::sqrt(12.0 * resets));
}

TEST_F(Randomization, ARangeOfOneReturnsToTheNominalBits) {
  // After any history, a randomizer of the same parameters with scale 1 +- 0 restores the nominal
  // values.
  const Instance wide(
      "draw", world,
      {{"what", Texts{"robot.links.base.mass"}}, {"range", Numbers{0.5, 2.0}}, {"form", "scale"}});
  const Instance one(
      "draw", world,
      {{"what", Texts{"robot.links.base.mass"}}, {"range", Numbers{1.0, 1.0}}, {"form", "scale"}});
  Group g = wide.group(1), h = one.group(1);
  for (int n = 0; n < 10000; ++n) reset(wide, g);
  h.params = g.params;
  reset(one, h);
  EXPECT_EQ(h.params[static_cast<std::size_t>(world.bodies[0].first_param)], 1.54);
}

TEST_F(Randomization, DrawsAtEveryNthResetTheFirstIncluded) {
  const Instance r("vehicle_constants", world, {{"mass", Numbers{0.5, 1.5}}, {"every", 3}});
  Group g = r.group(1);
  const int m = world.bodies[0].first_param;
  double last = param(g, m);
  for (int n = 0; n < 10; ++n) {
    reset(r, g);
    EXPECT_EQ(param(g, m) != last, n % 3 == 0) << n;
    last = param(g, m);
  }
  const std::vector<std::uint64_t> waited = g.state;
  r.call(Call::kRequest, g);
  EXPECT_NE(param(g, m), last);
  EXPECT_EQ(g.state, waited);
}

TEST_F(Randomization, OnlyNamedBodiesAndDeclaredParametersAreWritten) {
  const int bob = world.add_payload("bob");
  const Instance r(
      "vehicle_constants", world,
      {{"mass", Numbers{0.5, 1.5}}, {"links", Texts{"bob"}}, {"couple_inertia", false}});
  EXPECT_EQ(r.declared.writes,
            std::vector<int>{world.bodies[static_cast<std::size_t>(bob)].first_param});
  Group g = r.group(1);
  const Group before = g;
  reset(r, g);
  for (std::size_t k = 0; k < g.params.size(); ++k) {
    EXPECT_EQ(g.params[k] != before.params[k], static_cast<int>(k) == r.declared.writes[0]) << k;
  }
}

TEST_F(Randomization, DrawsOfOneNameRiseAndFallTogether) {
  const auto make = [&](const char* what, const char* name) {
    return Parameters{{"what", Texts{what}},
                      {"range", Numbers{0.5, 2.0}},
                      {"form", "scale"},
                      {"correlated", name}};
  };
  const Instance mass("draw", world, make("robot.links.base.mass", "size")),
      thrust("draw", world, make("robot.rotors[0].constant0", "size")),
      moment("draw", world, make("robot.rotors[0].constant1", "other"));
  Group g = mass.group(1), h = thrust.group(1), k = moment.group(1);
  const int m = world.bodies[0].first_param, kf = world.rotors[0].first_param;
  double least = 1.0;
  for (int n = 0; n < 100; ++n) {
    reset(mass, g);
    reset(thrust, h);
    reset(moment, k);
    const double scale = param(g, m) / world.params[static_cast<std::size_t>(m)].nominal;
    const auto of = [&](Group& group, int at) {
      return param(group, at) / world.params[static_cast<std::size_t>(at)].nominal;
    };
    EXPECT_NEAR(of(h, kf), scale, 1e-15);
    least = std::min(least, std::abs(of(k, kf + 1) - scale));
  }
  EXPECT_GT(least, 1e-6) << "another name, another number";
}

TEST_F(Randomization, DrawsInTimeOnceBetweenItsEnds) {
  const Instance r("draw", world,
                   {{"what", Texts{"robot.links.base.mass"}},
                    {"range", Numbers{0.5, 0.9}},
                    {"form", "scale"},
                    {"when", "time"},
                    {"time", Numbers{0.01, 0.02}}});
  Group g = r.group(1);
  const int m = world.bodies[0].first_param;
  const double nominal = world.params[static_cast<std::size_t>(m)].nominal;
  std::set<std::uint64_t> steps;
  for (int n = 0; n < 200; ++n) {
    g.physics_step[0] = 0;
    reset(r, g);
    EXPECT_EQ(param(g, m), nominal);
    std::uint64_t changed = 0;
    for (std::uint64_t step = 0; step < 30; ++step) {
      const double before = param(g, m);
      g.physics_step[0] = step;
      r.call(Call::kInTime, g);
      if (param(g, m) == before) continue;
      EXPECT_EQ(changed, 0u);
      changed = step;
      EXPECT_LE(param(g, m), 0.9 * nominal);
    }
    EXPECT_GE(changed, 10u);
    EXPECT_LE(changed, 20u);
    steps.insert(changed);
  }
  EXPECT_EQ(steps.size(), 11u) << "every step of the span comes";
}

TEST_F(Randomization, DrawsOnRequestAlone) {
  const Instance r("draw", world,
                   {{"what", Texts{"robot.links.base.mass"}},
                    {"range", Numbers{0.5, 0.9}},
                    {"form", "scale"},
                    {"when", "request"}});
  Group g = r.group(1);
  const int m = world.bodies[0].first_param;
  const double nominal = world.params[static_cast<std::size_t>(m)].nominal;
  reset(r, g);
  EXPECT_EQ(param(g, m), nominal);
  r.call(Call::kRequest, g);
  EXPECT_LE(param(g, m), 0.9 * nominal);
}

TEST_F(Randomization, ADrawIsSharedOrNot) {
  for (const bool shared : {false, true}) {
    const Instance r("draw", world,
                     {{"what", Texts{"robot.rotors[*].constant6"}},
                      {"range", Numbers{0.01, 0.02}},
                      {"shared", shared}});
    Group g = r.group(1);
    reset(r, g);
    const double a = param(g, world.rotors[0].first_param + SKYBODY_ROTOR_TAU_UP),
                 b = param(g, world.rotors[1].first_param + SKYBODY_ROTOR_TAU_UP);
    EXPECT_EQ(a == b, shared);
    EXPECT_GE(a, 0.01);
    EXPECT_LE(a, 0.02);
  }
}

TEST_F(Randomization, StartsLieInTheirRanges) {
  const Instance r("start", world,
                   {{"position_min", Numbers{-5, -4, 0.0}},
                    {"position_max", Numbers{5, 4, 3}},
                    {"min_height", 0.3},
                    {"tilt_max", 0.4},
                    {"velocity_max", 2.0},
                    {"rate_max", 3.0},
                    {"yaw_min", -0.72},
                    {"yaw_max", 0.72},
                    {"rotor_speed", "hover"}});
  Group g = r.group(1);
  for (int n = 0; n < 1000; ++n) {
    reset(r, g);
    const Numbers q = pose(g), v = start(g, "velocity[0]", 3),
                  w = start(g, "angular_velocity[0]", 3);
    ASSERT_LE(std::abs(q[0]), 5.0);
    ASSERT_LE(std::abs(q[1]), 4.0);
    ASSERT_GE(q[2], 0.3);
    ASSERT_LE(q[2], 3.0);
    ASSERT_NEAR(q[3] * q[3] + q[4] * q[4] + q[5] * q[5] + q[6] * q[6], 1.0, 1e-14);
    ASSERT_GE(1.0 - 2.0 * (q[4] * q[4] + q[5] * q[5]), std::cos(0.4) - 1e-12);
    ASSERT_LE(std::hypot(v[0], v[1], v[2]), 2.0 + 1e-12);
    ASSERT_LE(std::hypot(w[0], w[1], w[2]), 3.0 + 1e-12);
    ASSERT_NEAR(4.0 * 1.9533e-6 * rotor_start(g, 0) * rotor_start(g, 3), 1.54 * 9.81, 1e-11);
  }
}

TEST_F(Randomization, HoverSpeedCarriesTheWeightUnderTheGravityOfTheEnvironment) {
  const Instance r("start", world, {{"rotor_speed", "hover"}});
  Group earth = r.group(1), moon = r.group(1);
  param(moon, 2) = -9.81 / 4.0;
  reset(r, earth);
  reset(r, moon);
  EXPECT_DOUBLE_EQ(rotor_start(moon, 0), rotor_start(earth, 0) / 2.0);
}

TEST_F(Randomization, StartKeepsWhatIsNotAskedFor) {
  const Instance keep("start", world, {});
  Group g = keep.group(1);
  reset(keep, g);
  EXPECT_EQ(pose(g), (Numbers{1, 2, 3, 1, 0, 0, 0}));
  EXPECT_EQ(rotor_start(g, 0), 0.0);
  EXPECT_EQ(keep.declared.writes.size(), 13u) << "rotors may be drawn by another";
  EXPECT_EQ(g.q, keep.group(1).q) << "the engine places robots";
  const Instance near("start", world,
                      {{"relative", true},
                       {"position_min", Numbers{0, 0, 0.5}},
                       {"position_max", Numbers{0, 0, 0.5}}});
  reset(near, g);
  EXPECT_EQ(start(g, "position[0]", 3), (Numbers{1, 2, 3.5}));
}

TEST_F(Randomization, StartMovesATeamAsAWholeOrEveryRobotForItself) {
  world.add_quad("other", 4, 4, 4);
  Parameters given = {{"relative", true},
                      {"position_min", Numbers{-1, -1, -1}},
                      {"position_max", Numbers{1, 1, 1}},
                      {"yaw_min", -1.0},
                      {"yaw_max", 1.0}};
  const Instance each("start", world, given);
  given.insert({"together", true});
  const Instance together("start", world, given);
  Group a = each.group(1), b = together.group(1);
  for (int n = 0; n < 20; ++n) {
    reset(each, a);
    reset(together, b);
    EXPECT_NE(pose(a, "other")[0] - 4.0, pose(a)[0] - 1.0);
    const Numbers apart{3, 2, 1, 0, 0, 0, 0};
    // Adding a draw of up to 1 to poses of up to 4 rounds by up to 4e-16.
    for (std::size_t k = 0; k < 7; ++k) {
      EXPECT_NEAR(pose(b, "other")[k] - pose(b)[k], apart[k], 2e-15) << k;
    }
    EXPECT_NE(pose(b)[0], 1.0);
  }
}

TEST_F(Randomization, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("vehicle_constants", world, {}), HasSubstr("every range is [1, 1]"));
  EXPECT_THAT(refusal("vehicle_constants", world, {{"mass", Numbers{1.1, 0.9}}}),
              HasSubstr("runs backwards: write [low, high]"));
  EXPECT_THAT(
      refusal("vehicle_constants", world, {{"mass", Numbers{0.9, 1.1}}, {"links", Texts{"bob"}}}),
      HasSubstr("has no link `bob`"));
  EXPECT_THAT(refusal("vehicle_constants", world, {{"robot", "q"}, {"mass", Numbers{0.9, 1.1}}}),
              HasSubstr("no robot `q`"));
  EXPECT_THAT(refusal("start", world, {{"yaw_min", 1.0}}),
              HasSubstr("`yaw_min` 1 is above `yaw_max` 0: swap them"));
  EXPECT_THAT(refusal("start", world, {{"position_min", Numbers{0, 0, 0}}}),
              HasSubstr("give both [x, y, z], or neither"));
  PluginWorld team;
  team.add_quad("a");
  team.add_quad("b", 1);
  EXPECT_THAT(refusal("start", team,
                      {{"together", true},
                       {"position_min", Numbers{0, 0, 0}},
                       {"position_max", Numbers{1, 1, 1}}}),
              HasSubstr("would put all robots in one place: set `relative: true`"));
  EXPECT_THAT(refusal("draw", world, {{"what", Texts{"robot.links.base.mass"}}}),
              HasSubstr("`distribution: uniform` needs `range`"));
  const auto draw_refusal = [&](Parameters more) {
    more.insert({"what", Texts{"robot.links.base.mass"}});
    return refusal("draw", world, more);
  };
  EXPECT_THAT(draw_refusal({{"range", Numbers{1, 2}}, {"values", Numbers{1, 2}}}),
              HasSubstr("`distribution: uniform` does not know `values`"));
  EXPECT_THAT(draw_refusal({{"range", Numbers{1, 2}}, {"weights", Numbers{1}}}),
              HasSubstr("does not know `weights`"));
  EXPECT_THAT(draw_refusal({{"range", Numbers{2, 1}}}), HasSubstr("runs backwards"));
  EXPECT_THAT(draw_refusal({{"range", Numbers{1}}}), HasSubstr("`range` has 1 values"));
  EXPECT_THAT(draw_refusal({{"distribution", "choice"}}), HasSubstr("needs `values`"));
  EXPECT_THAT(draw_refusal({{"range", Numbers{1, 2}}, {"when", "time"}}),
              HasSubstr("`when: time` needs `time`"));
  EXPECT_THAT(draw_refusal({{"range", Numbers{1, 2}}, {"time", Numbers{1, 2}}}),
              HasSubstr("for `when: time` alone"));
  EXPECT_THAT(draw_refusal({{"range", Numbers{1, 2}}, {"when", "time"}, {"time", Numbers{2, 1}}}),
              HasSubstr("`time` is [2, 1] s: write [earliest, latest]"));
  EXPECT_THAT(
      refusal("draw", world,
              {{"what", Texts{"robot.nothing"}}, {"range", Numbers{1, 2}}, {"form", "scale"}}),
      HasSubstr("robot.nothing"));
  EXPECT_THAT(
      refusal("draw", world, {{"what", Texts{"robot.links.base.mass"}}, {"range", Numbers{-1, 2}}}),
      HasSubstr("narrow `range`"));
  world.robots[0].fixed_base = 1;
  EXPECT_THAT(refusal("start", world, {}), HasSubstr("no robot has a floating base"));
}

}  // namespace
}  // namespace skybody::testing
