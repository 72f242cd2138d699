// Differential flatness: attitude, rates and angular acceleration of a specific thrust, against
// finite differences and jets.
#include "controllers/common/flatness.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/math/jet.h"

namespace skybody::control {
namespace {

using V = Vec3<double>;

/// A specific thrust that rotates and grows, and a heading.
struct Example {
  double phase;

  SpecificThrust<double> thrust(double t) const {
    const double a = 1.3 * t + phase, b = 0.8 * t - phase;
    return {{3 * std::sin(a), 2 * std::cos(b), 9.81 + std::sin(a + b)},
            {3.9 * std::cos(a), -1.6 * std::sin(b), 2.1 * std::cos(a + b)},
            {-5.07 * std::sin(a), -1.28 * std::cos(b), -4.41 * std::sin(a + b)}};
  }
  FlatMotion<double> at(double t) const { return flat_motion(thrust(t), 0.3 + 0.9 * t, 0.9); }
};

void expect_near(const V& a, const V& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Flatness, TheBodyPushesAlongTheThrustAndHasTheHeading) {
  for (int i = 0; i < 50; ++i) {
    const Example example{0.37 * i};
    const V u = example.thrust(0.1).value;
    const FlatMotion<double> flat = example.at(0.1);
    EXPECT_NEAR(squared_norm(flat.rotation), 1.0, 1e-14);
    expect_near(body_z(flat.rotation) * flat.thrust, u, 1e-12);
  }
  const FlatMotion<double> level = flat_motion<double>({{0, 0, 9.81}, {}, {}}, 1.1, 0.0);
  EXPECT_NEAR(yaw(level.rotation), 1.1, 1e-15);
}

TEST(Flatness, RatesAndAngularAccelerationAreDerivatives) {
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 50; ++i) {
    const Example example{0.37 * i};
    const FlatMotion<double> flat = example.at(0.2), later = example.at(0.2 + kStep),
                             before = example.at(0.2 - kStep);
    const Quat<double> turn = conjugate(before.rotation) * later.rotation;
    // Central differences of step 1e-5: 1e-10 of the third derivative, and rounding over the step.
    expect_near(flat.rates, V{turn.x, turn.y, turn.z} / kStep, 1e-8);
    expect_near(flat.angular_acceleration, (later.rates - before.rates) / (2.0 * kStep), 1e-8);
  }
}

/// The motion by jets: w = 2 vec(q* dq/dt), dw/dt = 2 vec(q* d2q/dt2).
FlatMotion<double> by_jets(const SpecificThrust<double>& u, double yaw, double yaw_rate) {
  using Number = Jet<double, 3>;
  const auto jet = [](double value, double rate, double second) {
    Number out = Number::variable(value, rate);
    out.c[2] = 0.5 * second;
    return out;
  };
  const Vec3<Number> thrust{jet(u.value.x, u.rate.x, u.second.x),
                            jet(u.value.y, u.rate.y, u.second.y),
                            jet(u.value.z, u.rate.z, u.second.z)};
  const Number size = sqrt(squared_norm(thrust));
  const Number half = Number::variable(0.5 * yaw, 0.5 * yaw_rate);
  const Quat<Number> q = tilted(thrust * (1.0 / size), sincos(half));
  const auto part = [&](int k) { return Quat<double>{q.w.c[k], q.x.c[k], q.y.c[k], q.z.c[k]}; };
  const Quat<double> back = conjugate(part(0)), first = back * part(1), second = back * part(2);
  return {size.c[0],
          part(0),
          {2.0 * first.x, 2.0 * first.y, 2.0 * first.z},
          {4.0 * second.x, 4.0 * second.y, 4.0 * second.z}};
}

TEST(Flatness, TheClosedFormIsWhatJetsGive) {
  for (int i = 0; i < 200; ++i) {
    const SpecificThrust<double> u = Example{0.37 * i}.thrust(0.05 * i);
    const FlatMotion<double> flat = flat_motion(u, 0.03 * i - 3.0, 1.7);
    const FlatMotion<double> jets = by_jets(u, 0.03 * i - 3.0, 1.7);
    // Some tens of operations on values up to 10.
    EXPECT_NEAR(flat.thrust, jets.thrust, 1e-13);
    expect_near(flat.rates, jets.rates, 1e-13);
    expect_near(flat.angular_acceleration, jets.angular_acceleration, 1e-12);
    EXPECT_NEAR(flat.rotation.w, jets.rotation.w, 1e-14);
    EXPECT_NEAR(flat.rotation.x, jets.rotation.x, 1e-14);
    EXPECT_NEAR(flat.rotation.y, jets.rotation.y, 1e-14);
    EXPECT_NEAR(flat.rotation.z, jets.rotation.z, 1e-14);
  }
}

TEST(Flatness, FreeFallAndStraightDownAreLevelAndAtRest) {
  for (const V& u : {V{0, 0, 0}, V{0, 0, -5}, V{1e-9, 0, -3}}) {
    const FlatMotion<double> flat = flat_motion<double>({u, {1, 2, 3}, {4, 5, 6}}, 0.0, 0.0);
    expect_near(body_z(flat.rotation), V{0, 0, 1}, 0.0);
    expect_near(flat.rates, V{0, 0, 0}, 0.0);
    expect_near(flat.angular_acceleration, V{0, 0, 0}, 0.0);
  }
}

}  // namespace
}  // namespace skybody::control
