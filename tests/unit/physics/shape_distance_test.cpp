// Distances from capsules, planes and height fields: against closed forms, against the nearest of
// many points of the surface, and in packs against each lane alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/math/random.h"
#include "core/base/simd/kernels.h"
#include "core/physics/shapes/height_field.h"
#include "core/physics/shapes/overlap.h"
#include "core/physics/shapes/surface_distance.h"
#include "tests/unit/physics/test_models.h"

namespace skybody::test {
namespace {

Vec3<double> in_box(Random<double>& random, double half) {
  return {random.uniform(-half, half), random.uniform(-half, half), random.uniform(-half, half)};
}

double distance_from(const Shape& field, const Vec3<double>& p, double reach = kInfinity) {
  return distance_from_heights(*field.heights, 0.5 * field.size.x, 0.5 * field.size.y, reach, p)
      .distance;
}

TEST(CapsuleDistance, IsThatOfTheNearestPointOfItsLine) {
  Random<double> random{RandomKey{2026, 71}, 0, 0, derive_stream("shape_distance_test")};
  const double radius = 0.2, half = 0.3;
  for (int k = 0; k < 1000; ++k) {
    const Vec3<double> p = in_box(random, 0.8);
    double nearest = kInfinity;
    for (int i = -1000; i <= 1000; ++i) {
      nearest = std::min(nearest, norm(p - Vec3<double>{0, 0, half * i / 1000.0}));
    }
    const SurfaceDistance<double> found = capsule_distance(radius, half, p);
    EXPECT_LE(found.distance, nearest - radius + 1e-12);
    EXPECT_GE(found.distance, nearest - radius - 3e-4);  // points are 0.3 mm apart
    EXPECT_NEAR(norm(found.normal), 1.0, 1e-12);
    EXPECT_NEAR(capsule_distance(radius, half, p - found.normal * found.distance).distance, 0.0,
                1e-12);
  }
  EXPECT_EQ(capsule_distance(radius, half, {0, 0, 0.1}).distance, -radius);
  EXPECT_EQ(norm(capsule_distance(radius, half, {0, 0, 0.1}).normal), 1.0);
}

TEST(HeightFieldDistance, OfFlatGroundIsThatOfAPlaneAndItsWalls) {
  const Shape flat = make_height_field(2.0, 3.0, 5, 4, [](double, double) { return 0.25; });
  EXPECT_NEAR(distance_from(flat, {0.3, -0.2, 0.65}), 0.4, 1e-12);
  EXPECT_NEAR(distance_from(flat, {0.3, -0.2, 0.05}), -0.2, 1e-12);
  EXPECT_NEAR(distance_from(flat, {0.9, -0.2, -5.0}), -0.1, 1e-12) << "the wall is nearer";
  EXPECT_NEAR(distance_from(flat, {1.5, 0.0, -5.0}), 0.5, 1e-12);
  EXPECT_NEAR(distance_from(flat, {1.3, 1.9, -1.0}), 0.5, 1e-12) << "two walls meet";
  EXPECT_NEAR(distance_from(flat, {1.3, 0.0, 0.65}), 0.5, 1e-12) << "wall and top meet";
}

TEST(HeightFieldDistance, OfARampIsThatOfATurnedPlane) {
  const Shape ramp =
      make_height_field(20.0, 20.0, 41, 41, [](double x, double y) { return 0.3 * x - 0.4 * y; });
  const Vec3<double> normal = Vec3<double>{-0.3, 0.4, 1.0} * (1.0 / std::sqrt(1.25));
  Random<double> random{RandomKey{2026, 72}, 0, 0, derive_stream("shape_distance_test")};
  for (int k = 0; k < 300; ++k) {
    const Vec3<double> p = in_box(random, 2.0);
    const auto found = distance_from_heights(*ramp.heights, 10.0, 10.0, kInfinity, p);
    EXPECT_NEAR(found.distance, dot(normal, p), 1e-12);
    EXPECT_NEAR(norm(found.normal - normal), 0.0, 1e-9);
  }
}

/// Points of the triangles of a field and of its walls down to z = -1.
std::vector<Vec3<double>> surface_of(const Shape& field, int fine) {
  const HeightField& h = *field.heights;
  const auto at = [&](int c, int r) {
    return Vec3<double>{field.size.x * (c / (h.columns() - 1.0) - 0.5),
                        field.size.y * (r / (h.rows() - 1.0) - 0.5),
                        h.heights()[static_cast<std::size_t>(r * h.columns() + c)]};
  };
  std::vector<Vec3<double>> points;
  for (int r = 0; r + 1 < h.rows(); ++r) {
    for (int c = 0; c + 1 < h.columns(); ++c) {
      for (int i = 0; i <= fine; ++i) {
        for (int k = 0; k <= i; ++k) {
          const double u = double(i) / fine, v = double(k) / fine;
          points.push_back(at(c, r) * (1 - u) + at(c + 1, r) * (u - v) + at(c + 1, r + 1) * v);
          points.push_back(at(c, r) * (1 - u) + at(c, r + 1) * (u - v) + at(c + 1, r + 1) * v);
        }
      }
    }
  }
  const auto add_wall = [&](const Vec3<double>& a, const Vec3<double>& b) {
    for (int i = 0; i <= fine; ++i) {
      const Vec3<double> top = a * (1.0 - double(i) / fine) + b * (double(i) / fine);
      for (double z = -1.0; z < top.z; z += 0.01) points.push_back({top.x, top.y, z});
    }
  };
  for (int c = 0; c + 1 < h.columns(); ++c) {
    add_wall(at(c, 0), at(c + 1, 0));
    add_wall(at(c, h.rows() - 1), at(c + 1, h.rows() - 1));
  }
  for (int r = 0; r + 1 < h.rows(); ++r) {
    add_wall(at(0, r), at(0, r + 1));
    add_wall(at(h.columns() - 1, r), at(h.columns() - 1, r + 1));
  }
  return points;
}

TEST(HeightFieldDistance, IsThatOfTheNearestPointOfItsSurface) {
  Random<double> random{RandomKey{2026, 73}, 0, 0, derive_stream("shape_distance_test")};
  const Shape field = make_height_field(
      1.0, 0.8, 6, 5, [&](double, double) { return random.uniform(-0.15, 0.15); });
  const std::vector<Vec3<double>> surface = surface_of(field, 30);
  int inside = 0;
  for (int k = 0; k < 400; ++k) {
    const Vec3<double> p = in_box(random, 0.7);
    double nearest = kInfinity;
    for (const Vec3<double>& s : surface) nearest = std::min(nearest, norm(s - p));
    const auto found = distance_from_heights(*field.heights, 0.5, 0.4, kInfinity, p);
    EXPECT_LE(std::abs(found.distance), nearest + 1e-12) << k;
    EXPECT_GE(std::abs(found.distance), nearest - 0.012) << k;  // half the distance between points
    EXPECT_NEAR(norm(found.normal), 1.0, 1e-12);
    EXPECT_NEAR(distance_from(field, p - found.normal * found.distance), 0.0, 1e-9) << k;
    // A short reach keeps all distances within it, and makes none smaller.
    const double near = distance_from(field, p, 0.1);
    if (std::abs(found.distance) < 0.1) {
      EXPECT_EQ(near, found.distance);
    } else {
      EXPECT_GE(std::abs(near), 0.1);
      EXPECT_EQ(near < 0.0, found.distance < 0.0);
    }
    inside += found.distance < 0.0;
  }
  EXPECT_GT(inside, 50);
}

TEST(HeightFieldDistance, DoesNotReadBesideTheGrid) {
  const Shape field = make_height_field(1.0, 1.0, 2, 2, [](double, double) { return 0.0; });
  for (const double far : {1e6, -1e6, 1e300, kInfinity, -kInfinity, kNan}) {
    distance_from(field, {far, 0.0, 0.1}, 0.1);
    distance_from(field, {0.0, far, 0.1}, 0.1);
    distance_from(field, {0.0, 0.0, far}, 0.1);
  }
  EXPECT_NEAR(distance_from(field, {0.5, 0.5, 0.25}), 0.25, 1e-15) << "the last corner";
}

/// Distances of points in lanes of fields of different sizes.
struct Many {
  const HeightField& field;
  const double (*points)[3];
  double (*out)[4];
};
struct FindMany {
  template <int W>
  static SKYBODY_INLINE void run(const Many* many, int count) {
    using Real = Pack<W>;
    for (int first = 0; first + W <= count; first += W) {
      Vec3<Real> p{Real(0.0), Real(0.0), Real(0.0)};
      Real x(0.0);
      for (int i = 0; i < W; ++i) {
        const double* v = many->points[first + i];
        set_lane(p.x, i, v[0]);
        set_lane(p.y, i, v[1]);
        set_lane(p.z, i, v[2]);
        set_lane(x, i, 0.5 + 0.01 * (first + i));
      }
      const auto d = distance_from_heights(many->field, x, Real(0.4), 0.3, p);
      for (int i = 0; i < W; ++i) {
        double* out = many->out[first + i];
        out[0] = lane(d.distance, i);
        out[1] = lane(d.normal.x, i);
        out[2] = lane(d.normal.y, i);
        out[3] = lane(d.normal.z, i);
      }
    }
  }
};

TEST(HeightFieldDistance, OfALaneIsWhatItIsAlone) {
  Random<double> random{RandomKey{2026, 74}, 0, 0, derive_stream("shape_distance_test")};
  const Shape field = make_height_field(1.0, 0.8, 17, 13,
                                        [&](double, double) { return random.uniform(-0.1, 0.1); });
  constexpr int kCount = 512;
  static double points[kCount][3], out[kCount][4];
  for (auto& p : points) {
    for (double& x : p) x = random.uniform(-0.6, 0.6);
  }
  for (int isa = 0; isa <= static_cast<int>(best_isa()); ++isa) {
    const Many many{*field.heights, points, out};
    kernel<FindMany>(static_cast<Isa>(isa))(&many, kCount);
    for (int k = 0; k < kCount; ++k) {
      const auto alone = distance_from_heights(*field.heights, 0.5 + 0.01 * k, 0.4, 0.3,
                                               {points[k][0], points[k][1], points[k][2]});
      ASSERT_EQ(out[k][0], alone.distance) << isa << ' ' << k;
      ASSERT_EQ(out[k][1], alone.normal.x);
      ASSERT_EQ(out[k][2], alone.normal.y);
      ASSERT_EQ(out[k][3], alone.normal.z);
    }
  }
}

TEST(Overlap, KnowsCapsulesPlanesHeightFieldsAndTheBoxesOfMeshes) {
  const Shape ball = make_sphere(0.1), capsule = make_capsule(0.1, 1.0);
  EXPECT_NEAR(overlap(capsule, {}, ball, {{0, 0, 0.55}, {}}), 0.1, 1e-12);
  EXPECT_EQ(overlap(capsule, {}, ball, {{0.21, 0, 0}, {}}), 0.0);
  EXPECT_NEAR(overlap(make_plane(), {{0, 0, 1}, {}}, ball, {{3, 0, 1.05}, {}}), 0.05, 1e-12);
  const Shape hill = make_height_field(
      2.0, 2.0, 3, 3, [](double x, double y) { return x == 0.0 && y == 0.0 ? 0.5 : 0.0; });
  EXPECT_GT(overlap(ball, {{0.9, 0, 0.05}, {}}, hill, {}), 0.04);
  EXPECT_EQ(overlap(ball, {{0.9, 0.9, 0.3}, {}}, hill, {}), 0.0);
  EXPECT_GT(overlap(ball, {{0.1, 0.0, 0.5}, {}}, hill, {}), 0.0);
  Shape mesh;
  mesh.type = ShapeType::kMesh;
  mesh.box_size = {0.2, 0.2, 0.2};
  mesh.box_center = {1.0, 0.0, 0.0};
  EXPECT_NEAR(overlap(mesh, {}, ball, {{1.15, 0, 0}, {}}), 0.05, 1e-12);
  EXPECT_EQ(overlap(mesh, {}, ball, {}), 0.0);
}

}  // namespace
}  // namespace skybody::test
