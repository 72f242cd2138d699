// Randomizer `course`: tracks, the index of the first gate, and starts before it.
#include <cmath>
#include <set>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;

constexpr double kPi = 3.141592653589793;
/// Arithmetic on a few metres: some roundings of 1e-16.
constexpr double kRounding = 1e-13;

class CourseDraws : public ::testing::Test {
 protected:
  CourseDraws() {
    world.add_quad("quad", 0, -1, 1);
    for (int i = 0; i < kGates; ++i) {
      const double angle = 2 * kPi * i / kGates;
      world.add_gate("gate_" + std::to_string(i), {3 * std::cos(angle), 3 * std::sin(angle), 1.5},
                     angle + 0.5 * kPi);
    }
    first_gate = world.add_param("task.first_gate", 0.0);
  }
  int param(const std::string& path) const {
    for (std::size_t k = 0; k < world.params.size(); ++k)
      if (world.params[k].path == path) return static_cast<int>(k);
    ADD_FAILURE() << "no parameter " << path;
    return 0;
  }
  double at(const Group& g, const std::string& path) const {
    return g.params[static_cast<std::size_t>(param(path))];
  }
  double gate(const Group& g, int i, const std::string& value) const {
    return at(g, "obstacles.gate_" + std::to_string((i + kGates) % kGates) + "." + value);
  }
  static constexpr int kGates = 4;
  PluginWorld world;
  int first_gate = 0;
};

TEST_F(CourseDraws, GiveTheBitsOfDouble) {
  world.add_quad("other", 1, -1, 1);
  expect_same_bits("course", world, {{"gates", true}});
}

TEST_F(CourseDraws, BeginOnTheWayToAnyGateAndFlyAlongIt) {
  const Instance course(
      "course", world, {{"spread", 0.0}, {"share", std::vector<double>{0.2, 0.4}}, {"speed", 2.0}});
  Group g = course.group(1);
  std::set<int> firsts;
  for (int n = 0; n < 200; ++n) {
    ++g.episode[0];
    course.call(Call::kRandomize, g);
    const int k = static_cast<int>(g.params[static_cast<std::size_t>(first_gate)]);
    firsts.insert(k);
    double along[3], share[2];
    for (int i = 0; i < 2; ++i) {
      const std::string place = "position[" + std::to_string(i) + "]";
      along[i] = gate(g, k, place) - gate(g, k - 1, place);
      share[i] = (at(g, "robots.quad.start." + place) - gate(g, k - 1, place)) / along[i];
    }
    EXPECT_NEAR(share[0], share[1], kRounding);
    EXPECT_GE(share[0], 0.2 - kRounding);
    EXPECT_LE(share[0], 0.4 + kRounding);
    const double vx = at(g, "robots.quad.start.velocity[0]");
    const double vy = at(g, "robots.quad.start.velocity[1]");
    EXPECT_NEAR(vx * along[1] - vy * along[0], 0.0, kRounding);
    EXPECT_GE(vx * along[0] + vy * along[1], 0.0);
    EXPECT_LE(std::hypot(vx, vy), 2.0 + kRounding);
    EXPECT_NEAR(at(g, "robots.quad.start.turn[2]"), std::atan2(along[1], along[0]), kRounding);
    EXPECT_EQ(gate(g, 0, "position[0]"), 3.0) << "gates stay where they are";
  }
  EXPECT_EQ(firsts, (std::set<int>{0, 1, 2, 3}));
}

TEST_F(CourseDraws, KeepTheFirstGateWhereTheScenarioSaysSo) {
  const Instance course("course", world, {{"anywhere", false}});
  Group g = course.group(1);
  for (int n = 0; n < 50; ++n) {
    ++g.episode[0];
    course.call(Call::kRandomize, g);
    EXPECT_EQ(g.params[static_cast<std::size_t>(first_gate)], 0.0);
  }
}

TEST_F(CourseDraws, PutGatesIntoTheirSectorsOfTheRing) {
  const Instance course("course", world, {{"gates", true}, {"sector_share", 0.5}, {"turn", 0.2}});
  Group g = course.group(1);
  for (int n = 0; n < 500; ++n) {
    ++g.episode[0];
    course.call(Call::kRandomize, g);
    for (int i = 0; i < kGates; ++i) {
      const double x = gate(g, i, "position[0]"), y = gate(g, i, "position[1]");
      const double z = gate(g, i, "position[2]"), radius = std::hypot(x, y);
      EXPECT_GE(radius, 2.5 - kRounding);
      EXPECT_LE(radius, 3.5 + kRounding);
      EXPECT_GE(z, 1.2);
      EXPECT_LE(z, 2.0);
      const double off = std::remainder(std::atan2(y, x) - 2 * kPi * i / kGates, 2 * kPi);
      EXPECT_LE(std::abs(off), 0.25 * 2 * kPi / kGates + kRounding);
      const double yaw = 2 * std::atan2(gate(g, i, "rotation[3]"), gate(g, i, "rotation[0]"));
      const double turn = std::remainder(yaw - std::atan2(y, x) - 0.5 * kPi, 2 * kPi);
      EXPECT_LE(std::abs(turn), 0.2 + kRounding);
    }
  }
}

TEST_F(CourseDraws, LetATeamKeepItsPlacesTurnedWithTheWay) {
  world.add_quad("other", 1, -1, 1);
  const Instance course("course", world, {{"spread", 0.0}});
  Group g = course.group(1);
  course.call(Call::kRandomize, g);
  const double turn = at(g, "robots.quad.start.turn[2]");
  EXPECT_NEAR(at(g, "robots.other.start.position[0]") - at(g, "robots.quad.start.position[0]"),
              std::cos(turn), kRounding);
  EXPECT_NEAR(at(g, "robots.other.start.position[1]") - at(g, "robots.quad.start.position[1]"),
              std::sin(turn), kRounding);
}

TEST_F(CourseDraws, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("course", world, {{"radius", std::vector<double>{4, 3}}}),
              HasSubstr("4 to 3: swap them"));
  EXPECT_THAT(refusal("course", world, {{"robots", std::vector<std::string>{"quat"}}}),
              HasSubstr("no robot `quat`: there are quad"));
  PluginWorld empty;
  empty.add_quad("quad");
  EXPECT_THAT(refusal("course", empty, {}),
              HasSubstr("a course needs two gates or more, and there is none"));
}

}  // namespace
}  // namespace skybody::testing
