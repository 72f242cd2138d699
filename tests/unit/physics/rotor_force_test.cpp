// The fast forms of the rotors' law against the law, rotor by rotor.
#include "core/physics/forces/rotor_force.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/math/random.h"
#include "core/physics/forces/force_model.h"

namespace skybody::test {
namespace {

/// Four identical level rotors in rows, under random conditions.
struct Case {
  std::vector<RotorMount> places;
  std::vector<double> constants;  ///< kRotorParamCount each
  std::vector<RotorMotion<double>> motion;
  Vec3<double> velocity, spin;
  RotorGroup group{0, 0, 4, true};

  explicit Case(std::uint64_t episode) {
    Random<double> random(RandomKey{2026, 11}, episode, 0, derive_stream("rotor_force_test"));
    const Vec3<double> hub = random_vector(random, 0.3);
    std::vector<double> one(kRotorParamCount, 0.0);
    one[kThrustConstant] = random.uniform(1e-6, 3e-6);
    one[kMomentConstant] = random.uniform(1e-8, 3e-8);
    one[kDragConstant] = random.uniform(1e-5, 3e-5);
    one[kRollingMomentConstant] = random.uniform(1e-7, 1e-6);
    one[kRotorInertia] = random.uniform(1e-6, 1e-5);
    for (const Vec3<double> side : {Vec3<double>{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}) {
      RotorMount place;
      one[kRotorPosition] = side.x * hub.x;
      one[kRotorPosition + 1] = side.y * hub.y;
      one[kRotorPosition + 2] = hub.z;
      place.axis = {0, 0, 1};
      place.direction = side.z;
      place.params = kRotorParamCount * static_cast<int>(places.size());
      places.push_back(place);
      constants.insert(constants.end(), one.begin(), one.end());
      const double speed = random.uniform(0.0, 2000.0);
      motion.push_back({speed, random.uniform(-1e4, 1e4), 1.1 * speed * speed});
    }
    velocity = random_vector(random, 20.0);
    spin = random_vector(random, 20.0);
  }

  static Vec3<double> random_vector(Random<double>& random, double most) {
    return {random.uniform(-most, most), random.uniform(-most, most), random.uniform(-most, most)};
  }
  const double* of(int i) const { return constants.data() + kRotorParamCount * i; }
  std::vector<double> factors() const {
    std::vector<double> all(4 * kRotorFactorCount);
    for (int i = 0; i < 4; ++i) {
      make_rotor_factors(of(i), places[static_cast<std::size_t>(i)],
                         all.data() + kRotorFactorCount * i);
    }
    return all;
  }
  SpatialForce<double> by_law() const {
    return sum_rotors<double>(
        group, places.data(), [&](int i) { return of(i); },
        [&](int i) { return motion[static_cast<std::size_t>(i)]; }, 1.0, velocity, spin);
  }
  SpatialForce<double> force_of(const CoplanarRotors<double>& level) const {
    return level.force(constants[kRotorPosition + 2], 1.0, velocity, spin);
  }
};

/// Some hundred operations on terms of the size of the total thrust and its moments.
void expect_equal(const SpatialForce<double>& a, const SpatialForce<double>& b) {
  const double force = 50.0, moment = 20.0;
  EXPECT_LT(norm(a.force - b.force), 1e-14 * force);
  EXPECT_LT(norm(a.moment - b.moment), 1e-14 * moment);
}

TEST(RotorForce, LevelRotorsDoWhatTheLawSaysRotorByRotor) {
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const Case c(k);
    const std::vector<double> factors = c.factors();
    CoplanarRotors<double> level(factors.data(), c.motion[0]);
    for (std::size_t i = 1; i < 4; ++i) {
      level += CoplanarRotors<double>(factors.data() + kRotorFactorCount * i, c.motion[i]);
    }
    expect_equal(c.force_of(level), c.by_law());
  }
}

TEST(RotorForce, HubsOfALevelGroupThatAreDrawnToDifferentHeightsGoByTheLaw) {
  for (std::uint64_t k = 0; k < 1000; ++k) {
    Case c(k);
    c.constants[kRotorParamCount + kRotorPosition + 2] += 0.1;
    const SpatialForce<double> force = rotor_forces<double>(
        c.group, c.places.data(), [&](int i) { return c.of(i); },
        [&](int i) { return c.motion[static_cast<std::size_t>(i)]; }, 1.0, c.velocity, c.spin);
    expect_equal(force, c.by_law());
  }
}

TEST(RotorForce, RotorsInRowsDoWhatTheLawSaysRotorByRotor) {
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const Case c(k);
    ASSERT_TRUE(are_in_rows(c.places.data(), c.constants.data()));
    const std::vector<double> factors = c.factors();
    ASSERT_TRUE(are_alike(static_cast<const double*>(factors.data())));
    const RotorMotion<double> rotors[4] = {c.motion[0], c.motion[1], c.motion[2], c.motion[3]};
    expect_equal(c.force_of(CoplanarRotors<double>(factors.data(), rotors)), c.by_law());
  }
}

TEST(RotorForce, OtherOrdersTurnsAndConstantsAreNoRowsOfRotorsAlike) {
  Case c(0);
  std::swap(c.places[1], c.places[3]);
  EXPECT_FALSE(are_in_rows(c.places.data(), c.constants.data()));
  for (const int axis : {0, 1}) {
    c = Case(0);
    c.constants[2 * kRotorParamCount + kRotorPosition + axis] *= 1.01;
    EXPECT_FALSE(are_in_rows(c.places.data(), c.constants.data()));
    EXPECT_FALSE(are_alike(static_cast<const double*>(c.factors().data())));
    c.constants[2 * kRotorParamCount + kRotorPosition + axis] /= -1.01;
    EXPECT_FALSE(are_alike(static_cast<const double*>(c.factors().data()))) << "on another side";
  }
  c = Case(0);
  c.places[3].direction = -c.places[3].direction;
  EXPECT_FALSE(are_in_rows(c.places.data(), c.constants.data()));
  c = Case(0);
  c.constants[2 * kRotorParamCount + kDragConstant] *= 1.01;
  EXPECT_FALSE(are_alike(static_cast<const double*>(c.factors().data())));
}

}  // namespace
}  // namespace skybody::test
