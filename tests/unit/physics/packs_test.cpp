// Groups in packs have the bits of their environments one by one, for any tree, instruction set and
// neighbours.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "core/base/simd/isa.h"
#include "core/physics/contact/manifold.h"
#include "tests/unit/physics/random_worlds.h"
#include "tests/unit/physics/two_ways.h"

namespace skybody::test {
namespace {

class Packs : public testing::TestWithParam<Isa> {
 protected:
  void SetUp() override {
    if (!machine_has(GetParam())) GTEST_SKIP() << "this machine has no " << name(GetParam());
    if (const char* value = std::getenv("SKYBODY_ISA")) before_ = value;
    setenv("SKYBODY_ISA", name(GetParam()), 1);
  }
  void TearDown() override { setenv("SKYBODY_ISA", before_.c_str(), 1); }

 private:
  std::string before_;
};

TEST_P(Packs, HaveTheBitsOfEnvironmentsOneByOne) {
  for (std::uint64_t k = 0; k < 60; ++k) {
    Random<double> random{RandomKey{2026, 11}, k, 0, derive_stream("packs_test")};
    const auto integrator = kFixedSteps[k % 3];
    const World world = make_world(
        make_scenario(busy(random_tree(random), random), integrator), [k](WorldPlan& plan) {
          if (k % 4 == 0)
            plan.sites = {{0, {0.1, 0, 0}, true, false}, {0, {0, 0, 0.1}, false, true}};
        });
    TwoWays ways(world);
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      ways.set(lane, random_lane(random, world, k % 2 == 0 && lane % 3 != 0));
    }
    ways.refresh(kAllLanes);
    std::uint32_t lanes = kAllLanes;
    for (int step = 0; step < 20; ++step) {
      const std::uint32_t some = step % 5 == 4 ? lanes & kSomeLanes : lanes;
      const std::uint32_t through =
          ways.advance(some, "tree " + std::to_string(k) + ", step " + std::to_string(step));
      if (testing::Test::HasFatalFailure()) return;
      lanes &= ~(some & ~through);
    }
  }
}

TEST_P(Packs, HaveTheBitsOfEnvironmentsOneByOneWithHeldInputs) {
  for (std::uint64_t k = 0; k < 24; ++k) {
    Random<double> random{RandomKey{2026, 16}, k, 0, derive_stream("packs_test")};
    const auto integrator = kFixedSteps[k % 3];
    const RobotModel model = k % 2 == 0 ? make_vehicle(qdrone2()) : random_tree(random);
    const World world =
        make_world(make_scenario(busy(model, random), integrator), [k](WorldPlan& plan) {
          const bool all = k < 6;
          for (std::size_t i = 0; i < plan.holds.size(); ++i) plan.holds[i] = all || k % 6 == i;
        });
    TwoWays ways(world);
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      ways.set(lane, random_lane(random, world, k % 4 < 2 && lane % 3 != 0));
    }
    ways.refresh(kAllLanes);
    std::uint32_t lanes = kAllLanes;
    for (int step = 0; step < 10; ++step) {
      const std::uint32_t some = step % 5 == 4 ? lanes & kSomeLanes : lanes;
      const std::uint32_t through =
          ways.advance(some, "world " + std::to_string(k) + ", step " + std::to_string(step));
      if (testing::Test::HasFatalFailure()) return;
      lanes &= ~(some & ~through);
    }
  }
}

TEST_P(Packs, HaveTheBitsOfEnvironmentsOneByOneWithJointDrives) {
  for (std::uint64_t k = 0; k < 24; ++k) {
    Random<double> random{RandomKey{2026, 17}, k, 0, derive_stream("packs_test")};
    const auto integrator = kFixedSteps[k % 3];
    const Topology topology(make_scenario(busy(random_tree(random), random), integrator));
    WorldPlan plan(topology);
    plan.joint_drives = drives_for(random, topology);
    const World world(topology, plan);
    TwoWays ways(world);
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      ways.set(lane, random_lane(random, world, k % 2 == 0 && lane % 3 != 0));
    }
    ways.refresh(kAllLanes);
    std::uint32_t lanes = kAllLanes;
    for (int step = 0; step < 10; ++step) {
      lanes = ways.advance(lanes, "tree " + std::to_string(k) + ", step " + std::to_string(step));
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

TEST_P(Packs, LeaveALaneThatFailsAsItWasAndTheOthersGoOn) {
  Random<double> random{RandomKey{2026, 12}, 0, 0, derive_stream("packs_test")};
  const World world(make_scenario(make_vehicle(qdrone2())));
  TwoWays ways(world);
  for (int lane = 0; lane < kGroupLanes; ++lane) ways.set(lane, random_lane(random, world, false));
  LaneState broken = random_lane(random, world, false);
  broken.u[0] = kInfinity;
  ways.set(2, broken);
  LaneState weightless = random_lane(random, world, false);
  weightless.params[static_cast<std::size_t>(world.layout.body_params[0]) + kMass] = -1.0;
  ways.set(21, weightless);
  ways.refresh(kAllLanes);
  EXPECT_EQ(ways.advance(kAllLanes, "both"), kAllLanes & ~(1u << 2 | 1u << 21));
  weightless.params = nominal_params(world);  // and recovers
  ways.set(21, weightless);
  ways.refresh(1u << 21);
  EXPECT_EQ(ways.advance(1u << 21, "mended"), 1u << 21);
}

/// @param world  of one free body
void expect_same_bits_shared_or_not(const World& world, Random<double>& random) {
  TwoWays ways(world);
  const LaneState state = random_lane(random, world, false);
  for (int lane = 0; lane < kGroupLanes; ++lane) ways.set(lane, state);
  ways.refresh(kAllLanes);
  for (int step = 0; step < 5; ++step) ways.advance(kAllLanes, "shared");
  ways.set(7, random_lane(random, world, true));
  ways.refresh(1u << 7);
  for (int step = 0; step < 5; ++step) ways.advance(kAllLanes, "one drawn");
  LaneState aside = random_lane(random, world, true);  // its centre of mass is off the z axis
  aside.params[static_cast<std::size_t>(world.layout.body_params[0]) + kCom] += 0.01;
  ways.set(12, aside);
  ways.refresh(1u << 12);
  for (int step = 0; step < 5; ++step) ways.advance(kAllLanes, "one off the axis");
  LaneState uneven = random_lane(random, world, true);  // its hubs are at different heights
  uneven.params[static_cast<std::size_t>(world.layout.rotor_params[1]) + kRotorPosition + 2] += 0.1;
  ways.set(20, uneven);
  ways.refresh(1u << 20);
  for (int step = 0; step < 5; ++step) ways.advance(kAllLanes, "one with uneven hubs");
  for (const int lane : {7, 12, 20}) ways.set(lane, state);
  ways.refresh(1u << 7 | 1u << 12 | 1u << 20);
  for (int step = 0; step < 5; ++step) ways.advance(kAllLanes, "shared again");
}

TEST_P(Packs, HaveTheSameBitsWhetherALaneSharesItsConstantsOrNot) {
  Random<double> random{RandomKey{2026, 13}, 0, 0, derive_stream("packs_test")};
  for (const bool is_busy : {false, true}) {  // four level rotors; more, of any kind
    const RobotModel vehicle = make_vehicle(qdrone2());
    const World world(make_scenario(is_busy ? busy(vehicle, random) : vehicle));
    expect_same_bits_shared_or_not(world, random);
  }
}

// Some lanes spin fast, others do not: neighbours of either kind change nothing.
TEST_P(Packs, HaveTheBitsOfEnvironmentsOneByOneWhereSomeSpinFast) {
  for (std::uint64_t k = 0; k < 30; ++k) {
    Random<double> random{RandomKey{2026, 35}, k, 0, derive_stream("packs_test")};
    const RobotModel vehicle = make_vehicle(qdrone2());
    const RobotModel model = k % 5 == 0   ? vehicle
                             : k % 5 == 1 ? busy(vehicle, random)
                                          : busy(random_tree(random), random);
    const World world(make_scenario(
        model, k % 4 == 0 ? IntegratorChoice::kSemiImplicitEuler : IntegratorChoice::kMidpoint));
    TwoWays ways(world);
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      LaneState state = random_lane(random, world, k % 2 == 0 && lane % 3 != 0);
      const bool is_fast =
          lane % 4 == 0 && (k % 3 != 1 || lane < 8);  // otherwise only in few packs
      const double scale = is_fast ? random.uniform(2.0, 300.0) : 1.0;
      for (double& u : state.u) u *= scale;
      ways.set(lane, state);
    }
    ways.refresh(kAllLanes);
    std::uint32_t lanes = kAllLanes;
    for (int step = 0; step < 10; ++step) {
      lanes &= ways.advance(lanes, "world " + std::to_string(k) + ", step " + std::to_string(step));
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

/// Every fourth lane has contacts without dissipation, which use a separate procedure.
void choose_dissipation(const World& world, int lane, LaneState& state) {
  if (lane % 4 != 2) return;
  state.params[static_cast<std::size_t>(world.layout.world_params) + kDissipation] = 0.0;
}

/// Free bases near x = 2 k, or, in one lane of three, crowded together.
LaneState scattered_lane(Random<double>& random, const World& world, bool drawn, bool crowded) {
  LaneState state = random_lane(random, world, drawn);
  for (const WorldBody& body : world.bodies) {
    if (body.model->joint.type != JointType::kFree) continue;
    const double x = crowded ? 0.0 : 2.0 * body.robot;
    store(Vec3<double>{x, 0.0, 0.5} + in_cube(random, 0.5), state.q.data() + body.q);
  }
  return state;
}

TEST_P(Packs, TouchEachLaneForItself) {
  int mixed = 0, changes = 0;
  for (std::uint64_t k = 0; k < 4; ++k) {
    Random<double> random{RandomKey{2026, 14}, k, 0, derive_stream("packs_test")};
    const World world(several(random, kFixedSteps[k % 3]));
    TwoWays ways(world);
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      LaneState state = scattered_lane(random, world, k % 2 == 0 && lane % 3 != 0, lane % 3 == 1);
      choose_dissipation(world, lane, state);
      ways.set(lane, state);
    }
    ways.refresh(kAllLanes);
    std::uint32_t lanes = kAllLanes, before = 0;
    for (int step = 0; step < 40; ++step) {
      const std::uint32_t some = step % 5 == 4 ? lanes & kSomeLanes : lanes;
      const std::uint32_t through =
          ways.advance(some, "world " + std::to_string(k) + ", step " + std::to_string(step));
      if (testing::Test::HasFatalFailure()) return;
      const std::uint32_t near = ways.packs.stepper->near();
      mixed += near != 0 && near != some;
      changes += step > 0 && some == lanes && ((near ^ before) & some) != 0;
      before = near;
      lanes &= ~(some & ~through);
    }
  }
  EXPECT_GT(mixed, 80) << "in some lanes of a group something was near";
  EXPECT_GT(changes, 5) << "for a while";
}

/// Two bodies of two shapes each between a slope, hills, a bar and a pole.
Scenario among_shapes(Random<double>& random, IntegratorChoice integrator, int k) {
  const Shape shapes[] = {make_box(0.3, 0.2, 0.1), make_capsule(0.06, 0.3),
                          make_cylinder(0.12, 0.1), make_sphere(0.1)};
  Scenario scenario;
  for (int robot = 0; robot < 2; ++robot) {
    RobotModel model = make_free_body(1.0, diagonal(0.01, 0.012, 0.015));
    for (int i = 0; i < 2; ++i) {
      Shape shape = shapes[(k + robot + 2 * i) % 4];
      shape.pose = {in_cube(random, 0.1), random.quaternion()};
      model.bodies[0].collisions.push_back(shape);
    }
    if (robot == 0) {
      scenario = make_scenario(model, integrator);
    } else {
      scenario.robots.push_back(scenario.robots[0]);
      scenario.robots[1].model = model;
      scenario.robots[1].name = "s";
    }
  }
  scenario.contact.ground = k % 2 == 0;
  const auto add = [&](const char* name, Shape shape, const Pose& pose) {
    shape.pose = pose;
    scenario.obstacles.push_back({name, shape});
  };
  const Shape hills = make_height_field(
      3.0, 4.0, 13, 17, [&](double, double) { return random.uniform(-0.15, 0.15); });
  add("hills", hills, {{0, 0, 0.1}, from_rpy(0.1, -0.1, 0.3)});
  add("slope", make_plane(), {{0, 0, -0.2}, from_rpy(0.4, 0.2, 0.0)});
  add("bar", make_capsule(0.1, 1.5), {{0, 0.2, 0.4}, from_rpy(1.5, 0.0, 0.4)});
  add("pole", make_cylinder(0.1, 2.0), {{0.4, 0, 0.5}, {1, 0, 0, 0}});
  return scenario;
}

TEST_P(Packs, TouchPlanesHillsAndCapsulesEachLaneForItself) {
  int near = 0;
  for (int k = 0; k < 3; ++k) {
    Random<double> random{RandomKey{2026, 18}, static_cast<std::uint64_t>(k), 0,
                          derive_stream("packs_test")};
    const World world(among_shapes(random, kFixedSteps[k % 3], k));
    TwoWays ways(world);
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      LaneState state = random_lane(random, world, k < 2 && lane % 3 != 0);
      for (int robot = 0; robot < 2; ++robot) {
        store(Vec3<double>{0, 0, 0.5} + in_cube(random, 0.4), state.q.data() + 7 * robot);
      }
      choose_dissipation(world, lane, state);
      ways.set(lane, state);
    }
    ways.refresh(kAllLanes);
    std::uint32_t lanes = kAllLanes;
    for (int step = 0; step < 10; ++step) {
      const std::uint32_t some = step % 5 == 4 ? lanes & kSomeLanes : lanes;
      const std::uint32_t through =
          ways.advance(some, "world " + std::to_string(k) + ", step " + std::to_string(step));
      if (testing::Test::HasFatalFailure()) return;
      near += ways.packs.stepper->near() != 0;
      lanes &= ~(some & ~through);
    }
    EXPECT_EQ(lanes, kAllLanes);
  }
  EXPECT_GT(near, 25);
}

/// A body on `count` balls in a ring.
RobotModel on_balls(int count) {
  RobotModel model = make_free_body(1.0, diagonal(0.01, 0.01, 0.02));
  for (int i = 0; i < count; ++i) {
    const SinCos<double> angle = sincos(i * (kTwoPi / count));
    Shape ball = make_sphere(0.01);
    ball.pose.position = {0.15 * angle.cos, 0.15 * angle.sin, 0.0};
    model.bodies[0].collisions.push_back(ball);
  }
  return model;
}

// A body's mass is divided among its contacts in each lane, of which there may be more than the
// list keeps.
TEST_P(Packs, ShareMassesByThePlacesOfEachLane) {
  for (const int count : {6, 40, kKeptPlaces + 60}) {
    Random<double> random{RandomKey{2026, 36}, static_cast<std::uint64_t>(count), 0,
                          derive_stream("packs_test")};
    Scenario scenario = make_scenario(on_balls(count));
    scenario.robots.push_back(scenario.robots[0]);
    scenario.robots[1].name = "s";
    scenario.robots[1].model = on_balls(3);
    const World world(scenario);
    TwoWays ways(world);
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      LaneState state = random_lane(random, world, false);
      const double tilt = 0.2 * (lane % 3);
      for (int robot = 0; robot < 2; ++robot) {
        const double height = random.uniform(0.0, 0.012) + 0.15 * tilt + 0.02 * robot;
        store(Vec3<double>{0.1 * robot, 0.0, height}, state.q.data() + 7 * robot);
        store(from_rpy(tilt, 0.1 * tilt, 0.0), state.q.data() + 7 * robot + 3);
      }
      choose_dissipation(world, lane, state);
      ways.set(lane, state);
    }
    ways.refresh(kAllLanes);
    for (int step = 0; step < 8; ++step) {
      const auto name = std::to_string(count) + " balls, step " + std::to_string(step);
      EXPECT_EQ(ways.advance(kAllLanes, name), kAllLanes);
      if (testing::Test::HasFatalFailure()) return;
      EXPECT_EQ(ways.packs.stepper->near(), kAllLanes);
    }
  }
}

TEST_P(Packs, LeaveTheOthersAloneWhereOneFailsInContact) {
  Random<double> random{RandomKey{2026, 15}, 0, 0, derive_stream("packs_test")};
  Scenario scenario = make_scenario(make_vehicle(qdrone2()));
  scenario.robots.push_back(scenario.robots[0]);
  scenario.robots[1].name = "s";
  const World world(std::move(scenario));
  TwoWays ways(world);
  for (int lane = 0; lane < kGroupLanes; ++lane) {
    LaneState state = random_lane(random, world, false);
    store(Vec3<double>{0.0, 0.0, 1.0}, state.q.data());
    store(Vec3<double>{lane % 2 == 0 ? 0.3 : 3.0, 0.0, 1.0}, state.q.data() + 7);
    if (lane == 2) state.u[0] = kInfinity;
    if (lane == 4) {
      state.params[static_cast<std::size_t>(world.layout.body_params[1]) + kMass] = -1.0;
    }
    ways.set(lane, state);
  }
  ways.refresh(kAllLanes);
  EXPECT_EQ(ways.advance(kAllLanes, "two fail"), kAllLanes & ~(1u << 2 | 1u << 4));
  EXPECT_EQ(ways.packs.stepper->near(), 0x55555555u & ~(1u << 4));
  EXPECT_EQ(ways.packs.stepper->counts().near, 15u);
  EXPECT_EQ(ways.packs.stepper->counts().all, 32u);
  ways.advance(kAllLanes & ~(1u << 2 | 1u << 4), "and the others go on");
}

INSTANTIATE_TEST_SUITE_P(Isas, Packs, testing::ValuesIn(kIsas),
                         [](const auto& isa) { return std::string(name(isa.param)); });

}  // namespace
}  // namespace skybody::test
