// Distances of obstacles, by hand, and three closed forms against one another.
#include "plugins/obstacles/distance.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "plugins/obstacles/nearest.h"

namespace skybody::obstacles {
namespace {

using V = Vec3<double>;

PlacedObstacle<double> placed(const V& size, const V& position = {0, 0, 0},
                              const Quat<double>& rotation = {1, 0, 0, 0}) {
  return {true, position, rotation, size};
}

V way(int kind, const PlacedObstacle<double>& at, const V& p) { return way_to({kind, 0}, at, p); }

void expect_near(const V& found, const V& wanted) {
  EXPECT_NEAR(found.x, wanted.x, 1e-15);
  EXPECT_NEAR(found.y, wanted.y, 1e-15);
  EXPECT_NEAR(found.z, wanted.z, 1e-15);
}

TEST(ObstacleDistances, LeadToTheNearestPointByHand) {
  expect_near(way(SKYBODY_BOX, placed({2, 4, 6}), {2, -3, 1}), {-1, 1, 0});
  expect_near(way(SKYBODY_SPHERE, placed({0.5, 0, 0}), {0, 2, 0}), {0, -1.5, 0});
  expect_near(way(SKYBODY_CYLINDER, placed({0.5, 2, 0}), {-1, 0, 3}), {0.5, 0, -2});
  expect_near(way(SKYBODY_CAPSULE, placed({0.5, 2, 0}), {0, 0, 3}), {0, 0, -1.5});
  expect_near(way(SKYBODY_PLANE, placed({}), {1, 2, 3}), {0, 0, -3});
  expect_near(way(SKYBODY_GATE, placed({1.4, 1.2, 0.1}), {0, 0, 0}), {0, 0, 0.6});
  EXPECT_DOUBLE_EQ(distance_to_gate(V{1.4, 1.2, 0.1}, V{0, 0, 0}), 0.6);
  EXPECT_DOUBLE_EQ(distance_to_gate(V{1.4, 1.2, 0.1}, V{0.35, 0, 0}), std::hypot(0.3, 0.6));
  EXPECT_DOUBLE_EQ(distance_to_gate(V{1.4, 1.2, 0.1}, V{0, 1.8, 0}), 1.0);
}

TEST(ObstacleDistances, AreInTheWorldsAxes) {
  const double s = std::sqrt(0.5);
  expect_near(way(SKYBODY_BOX, placed({2, 4, 6}, {10, 0, 0}, {s, 0, 0, s}), {13, 0, 0}),
              {-1, 0, 0});  // a quarter turn about z: 4 m along x
}

TEST(ObstacleDistances, AreZeroWithin) {
  expect_near(way(SKYBODY_BOX, placed({2, 4, 6}), {0.9, 1.9, -2.9}), {0, 0, 0});
  expect_near(way(SKYBODY_SPHERE, placed({0.5, 0, 0}), {0.1, 0.2, 0.3}), {0, 0, 0});
  expect_near(way(SKYBODY_CYLINDER, placed({0.5, 2, 0}), {0.3, 0.3, 0.9}), {0, 0, 0});
  expect_near(way(SKYBODY_CAPSULE, placed({0.5, 2, 0}), {0, 0.4, 1.2}), {0, 0, 0});
  expect_near(way(SKYBODY_PLANE, placed({}), {1, 2, -3}), {0, 0, 0});
  expect_near(way(SKYBODY_GATE, placed({1.4, 1.4, 0.1}), {0.02, 0.75, 0.1}), {0, 0, 0});
  EXPECT_EQ(distance_to_gate(V{1.4, 1.4, 0.1}, V{0.02, 0.75, 0.1}), 0.0);
}

/// gap() is negative inside; the other forms do not distinguish it.
TEST(ObstacleDistances, OfAllFormsAgree) {
  std::mt19937 random(1);
  const auto draw = [&] { return 6.0 * static_cast<double>(random()) / 4294967295.0 - 3.0; };
  for (const int kind : {SKYBODY_BOX, SKYBODY_CYLINDER, SKYBODY_SPHERE, SKYBODY_CAPSULE,
                         SKYBODY_PLANE, SKYBODY_GATE}) {
    for (int k = 0; k < 2000; ++k) {
      const Quat<double> rotation = normalized(Quat<double>{draw(), draw(), draw(), draw()});
      const V size{0.2 + std::abs(draw()), 0.2 + std::abs(draw()), 0.1 + 0.1 * std::abs(draw())};
      const PlacedObstacle<double> at = placed(size, {draw(), draw(), draw()}, rotation);
      const V p{draw(), draw(), draw()};
      const Gap<double> to = gap({kind, 0}, at, p);
      const double distance = std::max(0.0, to.distance);
      EXPECT_NEAR(norm(way(kind, at, p)), distance, 1e-13) << kind;  // rounding of 10 m
      if (to.distance > 0.0) {
        EXPECT_LT(norm(way(kind, at, p) - to.way), 1e-7)
            << kind;  // near an edge the nearest points differ
      }
      if (kind == SKYBODY_GATE) {
        EXPECT_NEAR(distance_to_gate(size, at.local(p)), distance, 1e-13);
      }
    }
  }
}

struct Seen {
  double distance;
  int name;
};
Seen choose(bool mask, const Seen& a, const Seen& b) { return mask ? a : b; }

TEST(NearestObstacles, StandInOrderAndTheFirstOfEqualsBefore) {
  std::array<Seen, 3> nearest;
  nearest.fill({kInfinity, 0});
  const double distances[] = {3.0, 1.0, 2.0, 1.0, 5.0};
  for (int i = 0; i < 5; ++i) put_in_order(Seen{distances[i], i + 1}, nearest.data(), 3);
  EXPECT_EQ(nearest[0].name, 2);
  EXPECT_EQ(nearest[1].name, 4);
  EXPECT_EQ(nearest[2].name, 3);
}

}  // namespace
}  // namespace skybody::obstacles
