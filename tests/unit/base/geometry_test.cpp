// Vectors, quaternions and matrices: the conventions (w x y z, W from B, URDF's angles) and
// algebra.
#include <gtest/gtest.h>

#include "core/base/math/inertia.h"
#include "core/base/math/quat.h"
#include "core/base/math/random.h"

namespace skybody {
namespace {

using V = Vec3<double>;
using Q = Quat<double>;

void expect_near(const V& a, const V& b, double tolerance = 1e-15) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Quat, YawTurnsXTowardsY) {
  expect_near(rotate(from_rpy(0.0, 0.0, kHalfPi), V{1, 0, 0}), V{0, 1, 0});
  expect_near(rotate(from_rpy(kHalfPi, 0.0, 0.0), V{0, 1, 0}), V{0, 0, 1});
  expect_near(rotate(from_rpy(0.0, kHalfPi, 0.0), V{0, 0, 1}), V{1, 0, 0});
}

TEST(Quat, RpyIsFixedAxisRollThenPitchThenYaw) {
  const Q roll = from_axis_angle(V{1, 0, 0}, 0.3), pitch = from_axis_angle(V{0, 1, 0}, -0.7);
  const Q yaw_turn = from_axis_angle(V{0, 0, 1}, 2.1), q = from_rpy(0.3, -0.7, 2.1);
  expect_near(rotate(q, V{1, 2, 3}), rotate(yaw_turn, rotate(pitch, rotate(roll, V{1, 2, 3}))),
              2e-15);
  expect_near(rotate(q, V{1, 2, 3}), rotate(yaw_turn * pitch * roll, V{1, 2, 3}), 2e-15);
  expect_near(to_rpy(q), V{0.3, -0.7, 2.1}, 1e-15);
  EXPECT_NEAR(yaw(q), 2.1, 1e-15);
}

TEST(Quat, RandomRotationsSurviveTheMatrixAndBack) {
  for (std::uint64_t step = 0; step < 2000; ++step) {
    Random<double> random(RandomKey{5, 6}, 0, step, 1);
    const Q q = random.quaternion();
    ASSERT_NEAR(squared_norm(q), 1.0, 1e-15);
    const Mat3<double> r = to_mat3(q);
    const V v = random.unit_vector();
    expect_near(r * v, rotate(q, v), 2e-15);
    expect_near(transpose_times(r, v), rotate_inverse(q, v), 2e-15);
    expect_near(rotate_inverse(q, rotate(q, v)), v, 2e-15);
    expect_near(r.column(2), body_z(q), 1e-15);
    ASSERT_NEAR(tilt_cosine(q), r(2, 2), 1e-15);
    const Q back = from_rotation(r);
    ASSERT_GE(back.w, 0.0);
    const double sign = q.w < 0.0 ? -1.0 : 1.0;
    ASSERT_NEAR(back.w, sign * q.w, 1e-15);
    ASSERT_NEAR(back.x, sign * q.x, 1e-15);
    ASSERT_NEAR(determinant(r), 1.0, 2e-15);
  }
}

TEST(Quat, HalfTurnsComeBackFromTheirMatrix) {
  for (const Q& q : {Q{0, 1, 0, 0}, Q{0, 0, 1, 0}, Q{0, 0, 0, 1}, Q{1, 0, 0, 0}}) {
    const Q back = from_rotation(to_mat3(q));
    EXPECT_EQ(back.w, q.w);
    EXPECT_EQ(back.x, q.x);
    EXPECT_EQ(back.y, q.y);
    EXPECT_EQ(back.z, q.z);
  }
}

TEST(Quat, RotationVectorIsSmoothAtZero) {
  const Q none = from_rotation_vector(V{0, 0, 0});
  EXPECT_EQ(none.w, 1.0);
  EXPECT_EQ(none.x, 0.0);
  EXPECT_NEAR(from_rotation_vector(V{1e-12, 0, 0}).x, 5e-13, 1e-28);
  const Q q = from_rotation_vector(V{0, 0.5, 0}), expected = from_axis_angle(V{0, 1, 0}, 0.5);
  EXPECT_EQ(q.w, expected.w);
  EXPECT_NEAR(q.y, expected.y, 1e-16);
}

TEST(Vec3, CrossFollowsTheRightHand) {
  expect_near(cross(V{1, 0, 0}, V{0, 1, 0}), V{0, 0, 1}, 0.0);
  expect_near(skew(V{1, 2, 3}) * V{4, 5, 6}, cross(V{1, 2, 3}, V{4, 5, 6}), 0.0);
  EXPECT_EQ(norm(V{2, 3, 6}), 7.0);
  EXPECT_FALSE(is_finite(V{0, kNan, 0}));
}

TEST(Vec3, PacksOfVectorsWorkLaneByLane) {
  using P = Pack<4>;
  Vec3<P> a{P(1.0), P(2.0), P(3.0)};
  set_lane(a.x, 2, 5.0);
  const Vec3<P> b = 2.0 * a + cross(a, Vec3<P>{P(0.0), P(0.0), P(1.0)});
  for (int i = 0; i < 4; ++i) {
    const V c{lane(a.x, i), 2, 3};
    expect_near(V{lane(b.x, i), lane(b.y, i), lane(b.z, i)}, 2.0 * c + cross(c, V{0, 0, 1}), 0.0);
  }
}

TEST(Mat3, InversesUndoTheirMatrices) {
  const Mat3<double> a{{2, -1, 0.5, 3, 4, 1, -2, 0.25, 5}};
  expect_near(inverse(a) * (a * V{1, 2, 3}), V{1, 2, 3}, 1e-14);
  expect_near((inverse(a) * a).row(1), V{0, 1, 0}, 1e-15);
  const SymMat3<double> s{2, 3, 4, 0.5, -0.25, 0.125};
  expect_near(inverse(s) * (s * V{1, 2, 3}), V{1, 2, 3}, 1e-15);
  EXPECT_NEAR(determinant(s), determinant(to_mat3(s)), 1e-14);
}

TEST(Inertia, EigenvaluesAreThePrincipalMomentsOnTurnedAxes) {
  const SymMat3<double> principal{3, 1, 2.5, 0, 0, 0};
  const SymMat3<double> turned = rotate_inertia(to_mat3(from_rpy(0.4, -1.1, 2.0)), principal);
  expect_near(eigenvalues(turned), V{1, 2.5, 3}, 1e-14);
  expect_near(eigenvalues(SymMat3<double>{1, 1, 1, 0, 0, 0}), V{1, 1, 1}, 0.0);
}

TEST(Inertia, EigenvaluesOfDiagonalMatricesHoldOverManyOrdersOfMagnitude) {
  // Each is scaled by the largest entry and back: one rounding each way.
  const V moments = eigenvalues(SymMat3<double>{0.3, 1e-12, 0.1, 0, 0, 0});
  EXPECT_NEAR(moments.x, 1e-12, 1e-27);
  EXPECT_NEAR(moments.z, 0.3, 1e-16);
  expect_near(eigenvalues(SymMat3<double>{1e300, 2e300, 3e300, 0, 0, 0}), V{1e300, 2e300, 3e300},
              1e285);
  EXPECT_FALSE(is_finite(eigenvalues(SymMat3<double>{kNan, 1, 1, 0, 0, 0})));
}

TEST(Inertia, OnlyPossibleBodiesAreAccepted) {
  EXPECT_TRUE(is_physical_inertia({0.01, 0.01, 0.017, 0, 0, 0}));
  EXPECT_TRUE(is_physical_inertia({1, 1, 2, 0, 0, 0}));     // a flat plate: exactly at the bound
  EXPECT_FALSE(is_physical_inertia({1, 1, 2.1, 0, 0, 0}));  // triangle inequality
  EXPECT_FALSE(is_physical_inertia({1, 1, -1, 0, 0, 0}));   // negative
  EXPECT_FALSE(is_physical_inertia({1, 1, 1, 1.5, 0, 0}));  // indefinite
  EXPECT_FALSE(is_physical_inertia({0, 0, 0, 0, 0, 0}));    // a point
  EXPECT_FALSE(is_physical_inertia({kNan, 1, 1, 0, 0, 0}));
  EXPECT_FALSE(is_physical_inertia({1, 1, 1, kInfinity, 0, 0}));
}

TEST(Inertia, ParallelAxisTermMatchesAPointMass) {
  const V r{1, 2, 3}, w{0.5, -1, 2};
  expect_near(point_inertia(2.0, r) * w, 2.0 * cross(r, cross(w, r)), 1e-14);
}

}  // namespace
}  // namespace skybody
