// The range finder against hand calculation: rays at each kind of obstacle, mounting, noise, rate.
#include <cmath>
#include <numeric>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using ::testing::HasSubstr;

constexpr double kPi = 3.141592653589793;
/// Sums and products of numbers near 1: some roundings of 2e-16.
constexpr double kRounding = 1e-14;

class RangeFinderTest : public ::testing::Test {
 protected:
  RangeFinderTest() { world.add_quad("quad", 0, 0, 1); }

  /// Its output at the start.
  Numbers ranges(const Parameters& given) {
    const Instance finder("range_finder", world, given);
    Group g = finder.group(1);
    finder.call(Call::kSense, g);
    return g.output;
  }
  /// The only ray, straight ahead unless `given` changes it.
  double ahead(Parameters given = {}) {
    given.insert({"rays", 1});
    return ranges(given)[0];
  }
  PluginWorld world;
};

TEST_F(RangeFinderTest, GivesTheBitsOfDouble) {
  world.add_obstacle(SKYBODY_BOX, {0.4, 0.6, 0.8}, {0.7, 0.1, 0.2}, 0.3);
  world.add_obstacle(SKYBODY_SPHERE, {0.3}, {-0.7, 0.1, 0.2});
  world.add_obstacle(SKYBODY_CYLINDER, {0.2, 1.0}, {0.1, 0.8, 0.2}, 0.7);
  world.add_obstacle(SKYBODY_CAPSULE, {0.2, 1.0}, {0.1, -0.8, 0.2}, -0.7);
  world.add_obstacle(SKYBODY_GATE, {0.8, 0.6, 0.1}, {0.0, 0.0, 0.9}, 1.0);
  world.add_obstacle(SKYBODY_PLANE, {}, {0.0, 0.0, -0.8});
  expect_same_bits("range_finder", world, {{"rays", 6}, {"elevations", Numbers{-0.4, 0.3}}});
  expect_same_bits("range_finder", world, {{"rays", 5}, {"noise", 0.1}, {"level", true}});
}

TEST_F(RangeFinderTest, SaysItsRangeWhereNothingIsNearer) {
  EXPECT_EQ(ahead(), 5.0);
  world.add_obstacle(SKYBODY_SPHERE, {0.5}, {8.0, 0.0, 1.0});
  EXPECT_EQ(ahead(), 5.0);
  EXPECT_NEAR(ahead({{"max_range", 20.0}}), 7.5, kRounding);
}

TEST_F(RangeFinderTest, MeetsASphere) {
  world.add_obstacle(SKYBODY_SPHERE, {0.5}, {2.0, 0.3, 1.0});
  EXPECT_NEAR(ahead(), 2.0 - 0.4, kRounding) << "a chord of 0.8 m, 0.3 m beside the centre";
}

TEST_F(RangeFinderTest, MeetsTheFaceOfABox) {
  world.add_obstacle(SKYBODY_BOX, {1.0, 2.0, 3.0}, {3.0, 0.0, 1.0});
  EXPECT_NEAR(ahead(), 2.5, kRounding);
}

TEST_F(RangeFinderTest, MeetsTheEdgeOfATurnedBox) {
  world.add_obstacle(SKYBODY_BOX, {1.0, 1.0, 1.0}, {3.0, 0.0, 1.0}, 0.25 * kPi);
  EXPECT_NEAR(ahead(), 3.0 - std::sqrt(0.5), kRounding);
}

TEST_F(RangeFinderTest, MeetsACylindersSideAndPassesOverItsTop) {
  world.add_obstacle(SKYBODY_CYLINDER, {0.2, 1.8}, {2.0, 0.0, 0.0});
  EXPECT_EQ(ahead(), 5.0) << "its top is at 0.9 m, the ray at 1 m";
  // Down by 0.1 m per metre, to the top's near edge at (1.8, 0.82): it meets the side there.
  EXPECT_NEAR(ahead({{"elevations", Numbers{-std::atan(0.1)}}}), 1.8 * std::hypot(1.0, 0.1),
              kRounding);
}

TEST_F(RangeFinderTest, MeetsACapsulesCap) {
  world.add_obstacle(SKYBODY_CAPSULE, {0.5, 1.0}, {2.0, 0.0, 0.2});
  EXPECT_NEAR(ahead(), 2.0 - 0.4, kRounding) << "the cap's centre is 0.3 m below the ray";
}

TEST_F(RangeFinderTest, LooksThroughAGateAndMeetsItsBars) {
  world.add_obstacle(SKYBODY_GATE, {1.0, 1.0, 0.2}, {2.0, 0.0, 1.0});
  EXPECT_EQ(ahead(), 5.0);
  EXPECT_NEAR(ahead({{"position", Numbers{0.0, 0.6, 0.0}}}), 1.9, kRounding);
}

TEST_F(RangeFinderTest, MeetsTheGroundUnlessItIsTold) {
  const Numbers down{-kPi / 6.0};
  EXPECT_NEAR(ahead({{"elevations", down}}), 2.0, kRounding);
  EXPECT_EQ(ahead({{"elevations", down}, {"ground", false}}), 5.0);
}

TEST_F(RangeFinderTest, ReadsZeroInsideAndDoesNotSeeWhatIsBehindOrAbsent) {
  world.add_obstacle(SKYBODY_SPHERE, {0.5}, {-2.0, 0.0, 1.0});
  EXPECT_EQ(ahead(), 5.0) << "behind";
  const int first = world.add_obstacle(SKYBODY_SPHERE, {0.5}, {0.2, 0.0, 1.0});
  EXPECT_EQ(ahead(), 0.0);
  world.params[static_cast<std::size_t>(first + SKYBODY_OBSTACLE_PRESENT)].nominal = 0.0;
  EXPECT_EQ(ahead(), 5.0) << "not there";
}

TEST_F(RangeFinderTest, SpreadsItsRaysCounterClockwise) {
  world.add_obstacle(SKYBODY_SPHERE, {0.5}, {0.0, 2.0, 1.0});
  const Numbers ring = ranges({{"rays", 4}});
  EXPECT_EQ(ring[0], 5.0);
  EXPECT_NEAR(ring[1], 1.5, kRounding) << "to the left";
  const Numbers fan = ranges({{"rays", 3}, {"field_of_view", kPi}});
  EXPECT_EQ(fan[0], 5.0);
  EXPECT_NEAR(fan[2], 1.5, kRounding) << "the last of a half circle";
  const Numbers rings = ranges({{"rays", 4}, {"elevations", Numbers{0.5, 0.0}}});
  EXPECT_EQ(rings.size(), 8u);
  EXPECT_NEAR(rings[5], 1.5, kRounding) << "the second ring";
}

TEST_F(RangeFinderTest, TurnsWithItsLinkUnlessItIsHeldLevel) {
  const Instance fixed("range_finder", world, {{"rays", 1}});
  const Instance level("range_finder", world, {{"rays", 1}, {"level", true}});
  for (const Instance* finder : {&fixed, &level}) {
    Group g = finder->group(1);
    g.bodies[3] = std::cos(kPi / 12.0);
    g.bodies[5] = std::sin(kPi / 12.0);  // nose down by 30 degrees
    finder->call(Call::kSense, g);
    EXPECT_NEAR(g.output[0], finder == &fixed ? 2.0 : 5.0, kRounding);
  }
}

TEST_F(RangeFinderTest, NoiseHasItsDeviationAndIsNotOnRaysThatMeetNothing) {
  world.add_obstacle(SKYBODY_BOX, {1.0, 20.0, 20.0}, {2.5, 0.0, 1.0});
  const Instance finder("range_finder", world, {{"rays", 2}, {"noise", 0.05}, {"ground", false}});
  Group g = finder.group(1);
  Numbers readings;
  for (std::uint64_t k = 0; k < 4000; ++k) {
    g.physics_step[0] = k;
    finder.call(Call::kSense, g);
    readings.push_back(g.output[0]);
    ASSERT_EQ(g.output[1], 5.0) << "behind is nothing";
  }
  const double mean = std::accumulate(readings.begin(), readings.end(), 0.0) / 4000.0;
  double square = 0.0;
  for (const double r : readings) square += (r - mean) * (r - mean) / 4000.0;
  // Four standard errors of a mean and of a deviation over 4,000 draws.
  EXPECT_NEAR(mean, 2.0, 4.0 * 0.05 / std::sqrt(4000.0));
  EXPECT_NEAR(std::sqrt(square), 0.05, 4.0 * 0.05 / std::sqrt(8000.0));
}

TEST_F(RangeFinderTest, DeclaresItsRateAndMayBeLeftOut) {
  EXPECT_EQ(Instance("range_finder", world, {{"period", 20}}).declared.period, 20);
}

TEST_F(RangeFinderTest, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("range_finder", world, {{"elevations", Numbers{}}}),
              HasSubstr("`elevations` is empty: give one or more"));
  EXPECT_THAT(refusal("range_finder", world, {{"link", "nose"}}), HasSubstr("nose"));
  world.add_obstacle(SKYBODY_HEIGHT_FIELD, {10.0, 10.0, 2.0}, {0.0, 0.0, 0.0});
  EXPECT_THAT(refusal("range_finder", world, {}),
              HasSubstr("obstacle `solid_1` is a height field, and sensor `range_finder` knows "
                        "boxes"));
}

}  // namespace
}  // namespace skybody::testing
