// Springs too stiff for the step. A deeply overlapping body leaves no faster than the contact law
// allows, a falling body rebounds to the height of the law, and a thrown body comes to rest.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/physics/contact/manifold.h"
#include "tests/unit/physics/contact_worlds.h"

namespace skybody::test {
namespace {

constexpr double kSteps[] = {2.5e-4, 1e-3, 2e-3, 4e-3};  // [s]
constexpr double kDamping = 1.5 * 3.0;                   // d, with the default dissipation [s/m]
constexpr double kEdge = 0.2;                            // of a cube [m]

Scenario cube(double dt) { return world_of(solid(1.0, make_box(kEdge, kEdge, kEdge)), dt); }

/// Rebound speed of a body with this impact speed, without gravity: m v dv = -f dx of the law, in
/// small parts.
double rebound_of(double speed) {
  const double d = kDamping, wanted = speed / d - std::log1p(d * speed) / (d * d);
  double low = 0.0, high = 1.0 / d;
  for (int i = 0; i < 200; ++i) {
    const double mid = 0.5 * (low + high);
    (-mid / d - std::log1p(-d * mid) / (d * d) < wanted ? low : high) = mid;
  }
  return low;
}

class Deep : public testing::TestWithParam<double> {};

TEST_P(Deep, ReboundsAreTheLaws) {
  Scenario scenario = cube(GetParam());
  scenario.constants[kGravity + 2] = 0.0;
  LaneTries tries(scenario);
  for (int group = 0; group < 4; ++group) {
    std::vector<double> speeds;
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      const int k = group * kGroupLanes + lane;
      speeds.push_back(0.1 * std::pow(110.0, k / 127.0));
      LaneState state = tries.nominal;
      state.q[2] = 0.5 * kEdge + 0.37 * k * speeds.back() * GetParam() / 16.0;
      state.u[2] = -speeds.back();
      tries.set(lane, state);
    }
    tries.begin();
    for (int i = 0; i * GetParam() < 2.0; ++i) ASSERT_TRUE(tries.advance());
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      const double speed = speeds[static_cast<std::size_t>(lane)];
      const double error = tries.body(lane).velocity.z / rebound_of(speed) - 1.0;
      EXPECT_LT(std::fabs(error), 0.05) << speed << " m/s";
    }
  }
}

/// No part of a deep start is ever faster than the law allows.
TEST_P(Deep, CubesInTheGroundLeaveAtTheLawsSpeed) {
  for (const double depth : {0.009, 0.05, 1.0}) {
    for (const double tilt : {0.0, 0.4}) {
      Bench bench(cube(GetParam()));
      bench.state.q[2] = 0.5 * kEdge - depth;
      store(from_rpy(tilt, 0.7 * tilt, 0.0), bench.state.q.data() + 3);
      double most = 0.0, top = -1.0;
      for (int i = 0; i * GetParam() < 8.0; ++i) {
        ASSERT_TRUE(bench.run(1));
        most = std::fmax(most, bench.state.u[2]);
        top = std::fmax(top, bench.state.q[2]);
      }
      EXPECT_LT(most, 1.05 / kDamping) << depth << " m, tilt " << tilt;
      EXPECT_GT(top, 0.5 * kEdge - 0.002) << "it is out";
      EXPECT_LT(norm(bench.state.bodies[0].velocity), 1e-4) << "and at rest";
    }
  }
}

TEST_P(Deep, RobotsThatOverlapDoNotFlyApart) {
  const Shape shapes[] = {make_box(0.2, 0.2, 0.2), make_sphere(0.1)};
  for (const Shape& shape : shapes) {
    for (const double apart : {0.02, 0.1, 0.19}) {
      Scenario scenario = world_of(solid(1.0, shape), GetParam());
      switch_off_gravity_and_ground(scenario);
      add_robot(scenario, "s", solid(0.5, shape), {{apart, 0.01, 0.02}, {1, 0, 0, 0}});
      Bench bench(scenario);
      double most = 0.0;
      for (int i = 0; i * GetParam() < 3.0; ++i) {
        ASSERT_TRUE(bench.run(1));
        const Vec3<double> way =
            load_vec3(bench.state.u.data() + 6) - load_vec3(bench.state.u.data());
        most = std::fmax(most, norm(way));
      }
      EXPECT_LT(most, 1.05 / kDamping) << static_cast<int>(shape.type) << ", " << apart << " m";
    }
  }
}

/// A body of 1 kg with shapes in a ring about it.
struct Ring {
  const char* name;
  int count;
  double radius;  // of the ring [m]
  Shape shape;
  double height;   // from the body's centre to its lowest point [m]
  double inertia;  // about x and y; twice as much about z [kg m^2]
};

const Ring kRings[] = {
    {"legs", 4, 0.1, make_cylinder(0.01, 0.1), 0.05, 0.0031},
    {"rotor discs", 8, 0.2, make_cylinder(0.05, 0.02), 0.01, 0.0031},
    {"spheres", 32, 0.2, make_sphere(0.02), 0.02, 0.02},
    {"feet far from a small body", 4, 0.2, make_sphere(0.01), 0.01, 2e-4},
};

/// Allowed depth of a ring in the ground [m]. A small body on distant feet has softer springs at 4
/// ms: it sinks in by 12 mm.
double sunk(const Ring& ring, double dt) {
  return ring.inertia < 1e-3 && dt > 3e-3 ? 0.015 : 0.003;
}

Scenario world_with(const Ring& ring, double dt) {
  RobotModel model = make_free_body(1.0, diagonal(ring.inertia, ring.inertia, 2.0 * ring.inertia));
  for (int i = 0; i < ring.count; ++i) {
    const SinCos<double> angle = sincos(0.1 + i * (kTwoPi / ring.count));
    model.bodies[0].collisions.push_back(ring.shape);
    model.bodies[0].collisions.back().pose.position = {ring.radius * angle.cos,
                                                       ring.radius * angle.sin, 0.0};
  }
  return world_of(std::move(model), dt);
}

/// Springs of many contacts act together: dampers and parts of the step are chosen for their sum.
TEST_P(Deep, BodiesOfManyPlacesLeaveTheGroundAtTheLawsSpeed) {
  for (const Ring& ring : kRings) {
    for (const double depth : {0.02, 0.3}) {
      for (const double tilt : {0.0, 0.1}) {
        Bench bench(world_with(ring, GetParam()));
        bench.state.q[2] = ring.height - depth;
        store(from_rpy(tilt, 0.3 * tilt, 0.0), bench.state.q.data() + 3);
        double most = 0.0, top = -1.0;
        for (int i = 0; i * GetParam() < 4.0; ++i) {
          ASSERT_TRUE(bench.run(1)) << ring.name;
          most = std::fmax(most, bench.state.u[2]);
          top = std::fmax(top, bench.state.q[2]);
        }
        EXPECT_LT(most, 1.05 / kDamping) << ring.name << ", " << depth << " m, tilt " << tilt;
        EXPECT_GT(top, ring.height - sunk(ring, GetParam())) << ring.name << " is out";
      }
    }
  }
}

TEST_P(Deep, BodiesOfManyPlacesThatFallGainNoEnergyAndStayAboveTheGround) {
  for (const Ring& ring : kRings) {
    for (const double speed : {0.5, 3.0, 12.0}) {
      for (const double tilt : {0.0, 0.1, 0.5}) {
        Bench bench(world_with(ring, GetParam()));
        bench.state.q[2] = ring.height + 0.25 + 0.37 * speed * GetParam();
        bench.state.u[2] = -speed;
        store(from_rpy(tilt, 0.3 * tilt, 0.0), bench.state.q.data() + 3);
        ASSERT_TRUE(bench.run(1));
        const double start = energy(bench);
        double most = start;
        for (int i = 0; i * GetParam() < 2.0; ++i) {
          ASSERT_TRUE(bench.run(1)) << ring.name;
          most = std::fmax(most, energy(bench));
        }
        const auto name = std::string(ring.name) + ", " + std::to_string(speed) + " m/s, tilt " +
                          std::to_string(tilt);
        EXPECT_LT(most, 1.001 * start) << name;
        EXPECT_GT(bench.state.q[2], ring.height - sunk(ring, GetParam())) << name;
      }
    }
  }
}

/// A ring in the top of a wide box, which is fixed or is another robot.
/// @param box  mass [kg]; 0: fixed
Scenario ring_in_a_box(const Ring& ring, double box, double depth, double dt) {
  const Pose pose{{0, 0, -0.15}, {1, 0, 0, 0}};
  const Vec3<double> size{0.8, 0.8, 0.3};
  Scenario scenario = world_with(ring, dt);
  switch_off_gravity_and_ground(scenario);
  scenario.robots[0].pose.position = {0, 0, ring.height - depth};
  if (box > 0.0) {
    add_robot(scenario, "box", solid(box, make_box(size.x, size.y, size.z)), pose);
  } else {
    add_box(scenario, "box", size, pose);
  }
  return scenario;
}

TEST_P(Deep, BodiesOfManyPlacesLeaveBoxesAndRobotsAtTheLawsSpeed) {
  for (const Ring& ring : kRings) {
    for (const double box : {0.0, 0.5, 5.0}) {
      for (const double depth : {0.003, 0.015}) {
        Bench bench(ring_in_a_box(ring, box, depth, GetParam()));
        double most = 0.0;
        for (int i = 0; i * GetParam() < 1.0; ++i) {
          ASSERT_TRUE(bench.run(1)) << ring.name;
          const double other = box > 0.0 ? bench.state.u[8] : 0.0;
          most = std::fmax(most, bench.state.u[2] - other);
        }
        EXPECT_LT(most, 1.05 / kDamping) << ring.name << ", " << box << " kg, " << depth << " m";
        EXPECT_GT(most, 0.02) << ring.name << " leaves";
      }
    }
  }
}

/// More contacts than the list keeps: the pairs of balls and box would fill more than two lists.
TEST_P(Deep, ABodyOfMorePlacesThanAreKeptLeavesAtTheLawsSpeed) {
  const Ring ring{"small balls", kKeptPlaces + 60, 0.2, make_sphere(0.004), 0.004, 0.02};
  for (const double depth : {0.001, 0.006}) {
    Bench bench(ring_in_a_box(ring, 0.0, depth, GetParam()));
    double most = 0.0;
    for (int i = 0; i * GetParam() < 0.2; ++i) {
      ASSERT_TRUE(bench.run(1));
      most = std::fmax(most, bench.state.u[2]);
    }
    EXPECT_LT(most, 1.05 / kDamping) << depth << " m";
    EXPECT_GT(bench.state.q[2], ring.height) << "it is out";
  }
}

LaneState thrown(Random<double>& random, LaneState state) {
  state.q[2] = random.uniform(0.4, 0.8);
  store(random.quaternion(), state.q.data() + 3);
  store(in_cube(random, 2.0), state.u.data());
  store(in_cube(random, 5.0), state.u.data() + 3);
  return state;
}

/// Tests that all lanes lie still after this time.
void expect_rest(LaneTries& tries, double seconds, const std::string& name) {
  tries.begin();
  for (int i = 0; i * tries.world.scenario.stepping.dt < seconds; ++i) ASSERT_TRUE(tries.advance());
  for (int lane = 0; lane < kGroupLanes; ++lane) {
    const BodyState now = tries.body(lane);
    const bool rests = norm(now.velocity) < 1e-5 && norm(now.angular_velocity) < 1e-4;
    EXPECT_TRUE(rests) << name << " lane " << lane;
  }
}

/// 128 boxes, thrown.
TEST_P(Deep, BoxesThatAreThrownComeToRest) {
  for (std::uint64_t k = 0; k < 4; ++k) {
    Random<double> random{RandomKey{2026, 91}, k, 0, derive_stream("contact_deep_test")};
    const auto size = [&] { return random.uniform(0.05, 0.4); };
    const Shape box = make_box(size(), size(), size());
    LaneTries tries(world_of(solid(random.uniform(0.1, 3.0), box), GetParam()));
    for (int lane = 0; lane < kGroupLanes; ++lane) tries.set(lane, thrown(random, tries.nominal));
    expect_rest(tries, 20.0, "world " + std::to_string(k));
  }
}

/// The same for vehicles. A plate on its side rocks for half a minute with any dt, so every lane
/// gets a minute.
TEST_P(Deep, VehiclesThatAreThrownComeToRest) {
  for (const VehicleData& data : {qdrone2(), crazyflie()}) {
    for (std::uint64_t k = 0; k < 4; ++k) {
      Random<double> random{RandomKey{2026, 92}, k, 0, derive_stream("contact_deep_test")};
      LaneTries tries(world_of(make_vehicle(data), GetParam()));
      for (int lane = 0; lane < kGroupLanes; ++lane) tries.set(lane, thrown(random, tries.nominal));
      expect_rest(tries, 60.0, "world " + std::to_string(k));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Steps, Deep, testing::ValuesIn(kSteps));

}  // namespace
}  // namespace skybody::test
