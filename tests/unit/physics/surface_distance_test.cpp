// Signed distances against the nearest of many points of the surface, and tests for points inside.
#include "core/physics/shapes/surface_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/math/random.h"
#include "core/physics/shapes/overlap.h"

namespace skybody::test {
namespace {

using Points = std::vector<Vec3<double>>;

constexpr int kFine = 200;  ///< points along an edge
const Vec3<double> kHalf{0.3, 0.2, 0.1};
constexpr double kRadius = 0.25, kHalfLength = 0.15;

Points box_surface() {
  Points points;
  for (int i = 0; i <= kFine; ++i) {
    for (int j = 0; j <= kFine; ++j) {
      const double a = 2.0 * i / kFine - 1.0, b = 2.0 * j / kFine - 1.0;
      for (const double c : {-1.0, 1.0}) {
        points.push_back({a * kHalf.x, b * kHalf.y, c * kHalf.z});
        points.push_back({a * kHalf.x, c * kHalf.y, b * kHalf.z});
        points.push_back({c * kHalf.x, a * kHalf.y, b * kHalf.z});
      }
    }
  }
  return points;
}

Points cylinder_surface() {
  Points points;
  for (int i = 0; i <= 2 * kFine; ++i) {
    const double angle = kPi * i / kFine;
    for (int j = 0; j <= kFine; ++j) {
      const double r = kRadius * j / kFine, z = kHalfLength * (2.0 * j / kFine - 1.0);
      points.push_back({kRadius * std::cos(angle), kRadius * std::sin(angle), z});
      for (const double end : {-kHalfLength, kHalfLength}) {
        points.push_back({r * std::cos(angle), r * std::sin(angle), end});
      }
    }
  }
  return points;
}

double nearest(const Points& surface, const Vec3<double>& p) {
  double least = kInfinity;
  for (const Vec3<double>& s : surface) least = std::min(least, norm(s - p));
  return least;
}

/// @param distance  distance(p) gives a SurfaceDistance
template <class Distance, class IsInside>
void expect_nearest(const Points& surface, const Distance& distance, const IsInside& is_inside) {
  Random<double> random(RandomKey{2026, 12}, 0, 0, derive_stream("surface_distance_test"));
  const double grid = 0.006;  // above half the diagonal between the surface's points
  for (int k = 0; k < 300; ++k) {
    const Vec3<double> p{random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6),
                         random.uniform(-0.6, 0.6)};
    const SurfaceDistance<double> found = distance(p);
    EXPECT_EQ(found.distance < 0.0, is_inside(p));
    const double expected = nearest(surface, p);
    EXPECT_LE(std::abs(found.distance), expected + 1e-12);
    EXPECT_GE(std::abs(found.distance), expected - grid);
    EXPECT_NEAR(norm(found.normal), 1.0, 1e-12);
    // The surface lies along the normal.
    EXPECT_NEAR(distance(p - found.normal * found.distance).distance, 0.0, 1e-12);
  }
}

TEST(SurfaceDistance, OfABoxIsThatOfTheNearestPointOfItsSurface) {
  expect_nearest(
      box_surface(), [](const Vec3<double>& p) { return box_distance(kHalf, p); },
      [](const Vec3<double>& p) {
        return std::abs(p.x) < kHalf.x && std::abs(p.y) < kHalf.y && std::abs(p.z) < kHalf.z;
      });
}

TEST(SurfaceDistance, OfACylinderIsThatOfTheNearestPointOfItsSurface) {
  expect_nearest(
      cylinder_surface(),
      [](const Vec3<double>& p) { return cylinder_distance(kRadius, kHalfLength, p); },
      [](const Vec3<double>& p) {
        return std::hypot(p.x, p.y) < kRadius && std::abs(p.z) < kHalfLength;
      });
}

TEST(SurfaceDistance, HasANormalEverywhere) {
  const Vec3<double> origin{0.0, 0.0, 0.0};
  EXPECT_EQ(sphere_distance(0.5, origin).distance, -0.5);
  EXPECT_EQ(norm(sphere_distance(0.5, origin).normal), 1.0);
  EXPECT_EQ(norm(cylinder_distance(0.1, 0.5, origin).normal), 1.0);
  EXPECT_EQ(norm(box_distance(kHalf, origin).normal), 1.0);
}

TEST(Overlap, SeesAShapeThatLiesWhollyInAnother) {
  Shape wall, ball;
  wall.type = ShapeType::kBox;
  wall.size = {10, 10, 10};
  ball.type = ShapeType::kSphere;
  ball.radius = 0.1;
  EXPECT_NEAR(overlap(wall, {}, ball, {}), 5.0, 1e-12);
  EXPECT_NEAR(overlap(ball, {{0, 0, 4.9}, {}}, wall, {}), 0.2, 1e-12);
  EXPECT_EQ(overlap(ball, {{0, 0, 5.2}, {}}, wall, {}), 0.0);
}

TEST(Overlap, SeesAPoleThroughABox) {
  Shape pole, box;
  pole.type = ShapeType::kCylinder;
  pole.radius = 0.02;
  pole.length = 4.0;
  box.type = ShapeType::kBox;
  box.size = {0.4, 0.4, 0.1};
  EXPECT_NEAR(overlap(pole, {}, box, {}), 0.05, 1e-12);
  EXPECT_EQ(overlap(pole, {{0.25, 0, 0}, {}}, box, {}), 0.0);
}

}  // namespace
}  // namespace skybody::test
