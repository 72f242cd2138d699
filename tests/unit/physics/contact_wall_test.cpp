// Nothing passes a thin wall: balls and tumbling vehicles at up to 20 m/s, on its faces, edges and
// corners. Bounces never increase the energy.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/physics/shapes/surface_distance.h"
#include "tests/unit/physics/contact_worlds.h"

namespace skybody::test {
namespace {

/// A lane's target: a box about the origin.
struct Wall {
  Vec3<double> half;
  Quat<double> rotation;

  Vec3<double> to_local(Vec3<double> p) const { return rotate(conjugate(rotation), p); }
  double distance(Vec3<double> p) const { return box_distance(half, to_local(p)).distance; }
  /// Tests if the straight line between two points goes through the wall.
  bool cuts(Vec3<double> from, Vec3<double> to) const {
    const Vec3<double> p = to_local(from), way = to_local(to) - p;
    double first = 0.0, last = 1.0;
    const double ps[3] = {p.x, p.y, p.z}, ws[3] = {way.x, way.y, way.z},
                 hs[3] = {half.x, half.y, half.z};
    for (int k = 0; k < 3; ++k) {
      if (std::fabs(ws[k]) < 1e-12) {
        if (std::fabs(ps[k]) > hs[k]) return false;
        continue;
      }
      const double one = (-hs[k] - ps[k]) / ws[k], two = (hs[k] - ps[k]) / ws[k];
      first = std::max(first, std::min(one, two));
      last = std::min(last, std::max(one, two));
    }
    return first < last;
  }
};

/// A wall of 1 to 10 cm and at least 20 cm wide, in any attitude, and a flight towards its face,
/// edge or corner.
struct Attempt {
  Wall wall;
  Vec3<double> start, velocity;
  std::string words;
};

Attempt draw(Random<double>& random, int lane, double radius) {
  Attempt attempt;
  const double thickness = random.uniform(0.01, 0.1);
  const Vec3<double> half{0.5 * thickness, random.uniform(0.1, 0.6), random.uniform(0.1, 0.6)};
  attempt.wall = {half, random.quaternion()};
  // 0: a face; 1: an edge of it; 2: a corner; 3: beside the edge, where half of the body passes.
  const int kind = lane % 4;
  Vec3<double> aim{half.x, random.uniform(-half.y, half.y), random.uniform(-half.z, half.z)};
  if (kind > 0) aim.y = half.y;
  if (kind == 2) aim.z = half.z;
  if (kind == 3) aim.y += random.uniform(-radius, radius);
  const Vec3<double> aside = in_cube(random, 1.0);
  Vec3<double> from{random.uniform(0.2, 1.0), aside.y, aside.z};
  from = from * (1.0 / norm(from));
  double way = radius + 0.01;
  while (attempt.wall.distance(rotate(attempt.wall.rotation, aim + from * way)) < radius + 0.002) {
    way += 0.01;
  }
  way += random.uniform(0.0, 0.1);
  const double speed = random.uniform(0.5, 20.0);
  attempt.start = rotate(attempt.wall.rotation, aim + from * way);
  attempt.velocity = rotate(attempt.wall.rotation, from * -speed);
  const char* kinds[] = {"face", "edge", "corner", "beside the edge"};
  attempt.words = std::string(kinds[kind]) + ", wall " + std::to_string(thickness) + " m, " +
                  std::to_string(speed) + " m/s";
  return attempt;
}

LaneState state_of(const LaneTries& tries, const Attempt& attempt) {
  LaneState state = tries.nominal;
  const Wall& wall = attempt.wall;
  const Vec3<double> size = wall.half * 2.0;
  store(size, state.params.data() + tries.place("obstacles.wall.size[0]"));
  store(wall.rotation, state.params.data() + tries.place("obstacles.wall.rotation[0]"));
  store(attempt.start, state.q.data());
  store(attempt.velocity, state.u.data());
  return state;
}

Scenario before_a_wall(RobotModel model, double dt) {
  Scenario scenario = world_of(std::move(model), dt);
  switch_off_gravity_and_ground(scenario);
  add_box(scenario, "wall", {0.1, 1.0, 1.0}, {});
  return scenario;
}

double random_step(Random<double>& random) { return log_uniform(random, 1e-4, 2e-3); }

/// A group of 32 attempts, with one body and one step.
class Walls : public testing::TestWithParam<int> {
 protected:
  /// @param radius  of a sphere about the body
  /// @param depth   depth(state, wall): depth of the body in the wall [m]
  /// @param give    give(wall): largest allowed depth [m]
  template <class Depth, class Give>
  void fly(LaneTries& tries, Random<double>& random, double radius, double spin, const Depth& depth,
           const Give& give) {
    std::vector<Attempt> attempts;
    std::vector<BodyState> before;
    std::vector<double> energy;
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      attempts.push_back(draw(random, lane, radius));
      LaneState state = state_of(tries, attempts.back());
      if (spin > 0.0) {
        store(random.quaternion(), state.q.data() + 3);
        store(in_cube(random, spin), state.u.data() + 3);
      }
      tries.set(lane, state);
    }
    tries.begin();
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      before.push_back(tries.body(lane));
      energy.push_back(energy_of(before.back(), tries.world));
    }
    const double dt = tries.world.scenario.stepping.dt;
    for (int i = 0; i * dt < 0.3; ++i) {
      ASSERT_TRUE(tries.advance());
      for (int lane = 0; lane < kGroupLanes; ++lane) {
        const auto l = static_cast<std::size_t>(lane);
        const Attempt& attempt = attempts[l];
        const BodyState now = tries.body(lane);
        const auto where = [&] {
          return attempt.words + ", radius " + std::to_string(radius) + ", dt " +
                 std::to_string(dt) + ", lane " + std::to_string(lane) + ", step " +
                 std::to_string(i);
        };
        ASSERT_FALSE(attempt.wall.cuts(before[l].position, now.position)) << where();
        ASSERT_LT(depth(now, attempt.wall), give(attempt.wall)) << where();
        ASSERT_LT(energy_of(now, tries.world), energy[l] * (1.0 + 1e-3)) << where();
        before[l] = now;
        touched_ += tries.was_near(lane);
      }
    }
    tries_ += kGroupLanes;
  }

  int tries_ = 0;
  long touched_ = 0;  // steps near the wall
};

TEST_P(Walls, NoBallPasses) {
  for (std::uint64_t k = 0; k < 3; ++k) {
    Random<double> random{RandomKey{2026, 51}, static_cast<std::uint64_t>(GetParam()), k,
                          derive_stream("contact_wall_test")};
    const double radius = random.uniform(0.01, 0.1), mass = 4000.0 * radius * radius * radius;
    LaneTries tries(before_a_wall(solid(mass, make_sphere(radius)), random_step(random)));
    fly(
        tries, random, radius, 0.0,
        [&](const BodyState& b, const Wall& wall) { return radius - wall.distance(b.position); },
        // A quarter of the thinner one's width (docs/contact.md), plus the motion during a part of
        // a step.
        [&](const Wall& wall) { return 1.02 * 0.5 * std::min(radius, wall.half.x); });
  }
  EXPECT_EQ(tries_, 96);
  EXPECT_GT(touched_, tries_);
}

/// Overlap of two boxes along the axis of least overlap; negative: distance.
double overlap_of(const Mat3<double>& a, Vec3<double> half_a, const Mat3<double>& b,
                  Vec3<double> half_b, Vec3<double> apart) {
  const auto reach = [](const Mat3<double>& axes, Vec3<double> half, Vec3<double> n) {
    return std::fabs(dot(axes.column(0), n)) * half.x + std::fabs(dot(axes.column(1), n)) * half.y +
           std::fabs(dot(axes.column(2), n)) * half.z;
  };
  std::vector<Vec3<double>> ways;
  for (int i = 0; i < 3; ++i) {
    ways.push_back(a.column(i));
    ways.push_back(b.column(i));
    for (int k = 0; k < 3; ++k) ways.push_back(cross(a.column(i), b.column(k)));
  }
  double least = kInfinity;
  for (const Vec3<double>& way : ways) {
    if (norm(way) < 1e-3) continue;
    const Vec3<double> n = way * (1.0 / norm(way));
    least = std::min(least, reach(a, half_a, n) + reach(b, half_b, n) - std::fabs(dot(n, apart)));
  }
  return least;
}

TEST_P(Walls, NoTumblingVehiclePasses) {
  for (std::uint64_t k = 0; k < 3; ++k) {
    Random<double> random{RandomKey{2026, 52}, static_cast<std::uint64_t>(GetParam()), k,
                          derive_stream("contact_wall_test")};
    LaneTries tries(before_a_wall(make_vehicle(qdrone2()), random_step(random)));
    const Vec3<double> half = qdrone2().box * 0.5;
    fly(
        tries, random, norm(half) + 0.03, 10.0,
        [&](const BodyState& b, const Wall& wall) {
          return overlap_of(to_mat3(b.rotation), half, to_mat3(wall.rotation), wall.half,
                            b.position);
        },
        // The stop uses the body's mass without its inertia: a plate tumbling about an edge
        // continues by rotation. The largest depth was 0.36 of the thinner one's width.
        [&](const Wall& wall) { return 0.45 * 2.0 * std::min(half.z, wall.half.x); });
  }
  EXPECT_EQ(tries_, 96);
  EXPECT_GT(touched_, tries_);
}

INSTANTIATE_TEST_SUITE_P(Groups, Walls, testing::Range(0, 8));

/// Bodies in a walled yard with a table. The test compares the energy before and after each bounce;
/// between bounces the error is that of free rotation.
class Bounces : public testing::TestWithParam<int> {};

TEST_P(Bounces, NeverGainEnergy) {
  int bounces = 0;
  for (std::uint64_t k = 0; bounces < 2'500; ++k) {
    ASSERT_LT(k, 1000u);
    Random<double> random{RandomKey{2026, 53}, static_cast<std::uint64_t>(GetParam()), k,
                          derive_stream("contact_wall_test")};
    const auto size = [&] { return random.uniform(0.05, 0.3); };
    const Shape shape = k % 3 == 0   ? make_sphere(0.5 * size())
                        : k % 3 == 1 ? make_cylinder(0.5 * size(), size())
                                     : make_box(size(), size(), size());
    Scenario scenario = world_of(solid(random.uniform(0.05, 5.0), shape), k % 2 == 0 ? 1e-3 : 2e-3);
    for (const double side : {-1.0, 1.0}) {
      const std::string name = side < 0.0 ? "_low" : "_high";
      add_box(scenario, "x" + name, {0.1, 6.0, 20.0}, {{1.5 * side, 0, 5}, {1, 0, 0, 0}});
      add_box(scenario, "y" + name, {6.0, 0.1, 20.0}, {{0, 1.5 * side, 5}, {1, 0, 0, 0}});
    }
    add_box(scenario, "table", {size() * 3, size() * 3, size()},
            {{0, 0, 0.6}, random.quaternion()});
    LaneTries tries(std::move(scenario));
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      LaneState state = tries.nominal;
      state.params[tries.place("contact.dissipation")] = log_uniform(random, 0.1, 3.0);
      const double sides[2] = {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)};
      store(Vec3<double>{sides[0], sides[1], random.uniform(1.6, 2.5)}, state.q.data());
      store(random.quaternion(), state.q.data() + 3);
      store(in_cube(random, 6.0), state.u.data());
      store(in_cube(random, 8.0), state.u.data() + 3);
      tries.set(lane, state);
    }
    tries.begin();
    std::vector<double> free(kGroupLanes, 0.0);  // the energy of the last step without contact
    std::vector<bool> was_near(kGroupLanes, false);
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      free[static_cast<std::size_t>(lane)] = energy_of(tries.body(lane), tries.world);
    }
    for (int i = 0; i < 1500; ++i) {
      ASSERT_TRUE(tries.advance());
      for (int lane = 0; lane < kGroupLanes; ++lane) {
        const auto l = static_cast<std::size_t>(lane);
        const bool is_near = tries.was_near(lane);
        if (is_near) {
          was_near[l] = true;
          continue;
        }
        const double now = energy_of(tries.body(lane), tries.world);
        if (was_near[l]) {
          // Energy error of a few steps of free spin.
          ASSERT_LE(now, free[l] * (1.0 + 1e-4)) << "world " << k << " lane " << lane << ' ' << i;
          bounces += now < free[l] * (1.0 - 1e-3);
        }
        was_near[l] = false;
        free[l] = now;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Yards, Bounces, testing::Range(0, 4));

}  // namespace
}  // namespace skybody::test
