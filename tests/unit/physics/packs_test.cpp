// Groups in packs have the bits of their environments one by one: whatever the tree, the
// instruction set and the neighbours.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "core/base/isa.h"
#include "core/physics/world/lane_values.h"
#include "tests/unit/physics/random_trees.h"
#include "tests/unit/physics/two_ways.h"

namespace skybody::test {
namespace {

constexpr std::uint32_t kAll = ~0u >> (32 - kGroupLanes);
constexpr std::uint32_t kSome = 0x6bff4f6b;  // now and then a part only

/// With joints that are sprung and limited, and rotors with every effect on two of the bodies.
RobotModel busy(RobotModel model, Random<double>& random) {
  for (Body& body : model.bodies) {
    if (random.uniform() < 0.5) body.collisions.push_back(make_box(0.2, 0.1, 0.15));
    if (body.joint.parent < 0 || random.uniform() < 0.5) continue;
    body.joint.constants[kJointDamping] = 0.01;
    body.joint.constants[kJointStiffness] = 2.0;
    body.joint.limit = {true, -0.2, 0.2};
    body.joint.constants[kLimitStiffness] = 50.0;
    body.joint.constants[kLimitDamping] = 0.1;
  }
  for (int i = 0; i < 4; ++i) {
    Rotor rotor;
    rotor.name = "rotor_" + std::to_string(i);
    rotor.body = random.uniform() < 0.7 ? 0 : static_cast<int>(model.bodies.size()) - 1;
    rotor.position = in_cube(random, 0.2);
    rotor.axis = random.uniform() < 0.5 ? Vec3<double>{0, 0, 1}
                                        : rotate(random.quaternion(), Vec3<double>{0, 0, 1});
    rotor.direction = i % 2 == 0 ? 1 : -1;
    rotor.constants[kThrustConstant] = 2e-6;
    rotor.constants[kMomentConstant] = 3e-8;
    rotor.constants[kDragConstant] = random.uniform() < 0.5 ? 2e-5 : 0.0;
    rotor.constants[kRollingMomentConstant] = random.uniform() < 0.5 ? 1e-6 : 0.0;
    rotor.constants[kRotorInertia] = random.uniform() < 0.5 ? 5e-6 : 0.0;
    rotor.constants[kMaxSpeed] = 2200.0;
    rotor.constants[kTauUp] = random.uniform() < 0.2 ? 0.0 : 0.0125;
    rotor.constants[kTauDown] = 0.025;
    model.rotors.push_back(rotor);
  }
  return model;
}

LaneState random_lane(Random<double>& random, const World& world, bool drawn) {
  LaneState state;
  write_default_state(world, state);
  state.params = nominal_params(world);
  random_state(random, world, state.q, state.u);
  if (world.bodies[0].model->joint.type == JointType::kFree) {
    state.q[2] = random.uniform(-0.05, 1.0);  // some touch the ground
  }
  for (double& w : state.rotor_speed) w = random.uniform(0.0, 1500.0);
  for (double& w : state.rotor_command) w = random.uniform(-100.0, 3000.0);
  for (double& f : state.wrench) f = random.uniform(-1.0, 1.0);
  for (double& r : state.joint_command) r = random.uniform(-1.0, 1.0);
  for (double& r : state.joint_state) r = random.uniform(-1.0, 1.0);
  for (double& v : state.held[SKYBODY_HELD_WIND]) v = random.uniform(-5.0, 5.0);
  for (double& f : state.held[SKYBODY_HELD_WRENCH]) f = max(0.0, random.uniform(-1.0, 1.0));
  for (double& c : state.held[SKYBODY_HELD_BODY_DRAG]) c = max(0.0, random.uniform(-0.05, 0.05));
  for (double& g : state.held[SKYBODY_HELD_ROTOR_GAIN]) g = random.uniform(0.0, 2.0);
  for (double& w : state.held[SKYBODY_HELD_ROTOR_LIMIT]) w += random.uniform(0.0, 300.0);
  for (double& r : state.held[SKYBODY_HELD_ROTOR_RATE]) {
    if (random.uniform() < 0.5) r = random.uniform(-4000.0, 4000.0);
  }
  if (!drawn) return state;
  for (double& p : state.params) p *= random.uniform(0.95, 1.05);
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {  // some are 0
    const int count = joint_constant_count(world.bodies[i].model->joint);
    for (int k = 0; k < count; ++k) {
      state.params[static_cast<std::size_t>(world.layout.joint_params[i] + k)] +=
          max(0.0, random.uniform(-0.5, 0.5));
    }
  }
  return state;
}

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
    const auto integrator =
        k % 3 == 0 ? IntegratorChoice::kRk4 : IntegratorChoice::kSemiImplicitEuler;
    const World world = make_world(
        make_scenario(busy(random_tree(random), random), integrator), [k](WorldPlan& plan) {
          if (k % 4 == 0)
            plan.sites = {{0, {0.1, 0, 0}, true, false}, {0, {0, 0, 0.1}, false, true}};
        });
    TwoWays ways(world);
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      ways.set(lane, random_lane(random, world, k % 2 == 0 && lane % 3 != 0));
    }
    ways.refresh(kAll);
    std::uint32_t lanes = kAll;
    for (int step = 0; step < 20; ++step) {
      const std::uint32_t some = step % 5 == 4 ? lanes & kSome : lanes;
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
    const auto integrator =
        k % 3 == 0 ? IntegratorChoice::kRk4 : IntegratorChoice::kSemiImplicitEuler;
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
    ways.refresh(kAll);
    std::uint32_t lanes = kAll;
    for (int step = 0; step < 10; ++step) {
      const std::uint32_t some = step % 5 == 4 ? lanes & kSome : lanes;
      const std::uint32_t through =
          ways.advance(some, "world " + std::to_string(k) + ", step " + std::to_string(step));
      if (testing::Test::HasFatalFailure()) return;
      lanes &= ~(some & ~through);
    }
  }
}

/// A drive in every joint that may have one, of any mode.
std::vector<JointDrive> drives_for(Random<double>& random, const Topology& world) {
  std::vector<JointDrive> drives;
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    const JointType type = world.bodies[i].model->joint.type;
    if (type == JointType::kBall || type == JointType::kFree) continue;
    for (int k = 0; k < velocity_size(type); ++k) {
      const auto mode = static_cast<JointMode>(static_cast<int>(random.uniform() * 3.0));
      drives.push_back({static_cast<int>(i), k, mode, random.uniform(), random.uniform(),
                        random.uniform(), random.uniform() < 0.5 ? 0.0 : 0.01});
    }
  }
  return drives;
}

TEST_P(Packs, HaveTheBitsOfEnvironmentsOneByOneWithJointDrives) {
  for (std::uint64_t k = 0; k < 24; ++k) {
    Random<double> random{RandomKey{2026, 17}, k, 0, derive_stream("packs_test")};
    const auto integrator =
        k % 3 == 0 ? IntegratorChoice::kRk4 : IntegratorChoice::kSemiImplicitEuler;
    const Topology topology(make_scenario(busy(random_tree(random), random), integrator));
    WorldPlan plan(topology);
    plan.joint_drives = drives_for(random, topology);
    const World world(topology, plan);
    TwoWays ways(world);
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      ways.set(lane, random_lane(random, world, k % 2 == 0 && lane % 3 != 0));
    }
    ways.refresh(kAll);
    std::uint32_t lanes = kAll;
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
  ways.refresh(kAll);
  EXPECT_EQ(ways.advance(kAll, "both"), kAll & ~(1u << 2 | 1u << 21));
  weightless.params = nominal_params(world);  // and comes back
  ways.set(21, weightless);
  ways.refresh(1u << 21);
  EXPECT_EQ(ways.advance(1u << 21, "mended"), 1u << 21);
}

/// @param world  of one free body
void expect_same_bits_shared_or_not(const World& world, Random<double>& random) {
  TwoWays ways(world);
  const LaneState state = random_lane(random, world, false);
  for (int lane = 0; lane < kGroupLanes; ++lane) ways.set(lane, state);
  ways.refresh(kAll);
  for (int step = 0; step < 5; ++step) ways.advance(kAll, "shared");
  ways.set(7, random_lane(random, world, true));
  ways.refresh(1u << 7);
  for (int step = 0; step < 5; ++step) ways.advance(kAll, "one drawn");
  LaneState aside = random_lane(random, world, true);  // its centre of mass is off the z axis
  aside.params[static_cast<std::size_t>(world.layout.body_params[0]) + kCom] += 0.01;
  ways.set(12, aside);
  ways.refresh(1u << 12);
  for (int step = 0; step < 5; ++step) ways.advance(kAll, "one off the axis");
  ways.set(7, state);
  ways.set(12, state);
  ways.refresh(1u << 7 | 1u << 12);
  for (int step = 0; step < 5; ++step) ways.advance(kAll, "shared again");
}

TEST_P(Packs, HaveTheSameBitsWhetherALaneSharesItsConstantsOrNot) {
  Random<double> random{RandomKey{2026, 13}, 0, 0, derive_stream("packs_test")};
  for (const bool is_busy : {false, true}) {  // four level rotors; more, of any kind
    const RobotModel vehicle = make_vehicle(qdrone2());
    const World world(make_scenario(is_busy ? busy(vehicle, random) : vehicle));
    expect_same_bits_shared_or_not(world, random);
  }
}

/// Two or three robots, now and then beside an obstacle.
Scenario several(Random<double>& random, IntegratorChoice integrator) {
  Scenario scenario = make_scenario(busy(random_tree(random), random), integrator);
  scenario.robots.push_back(scenario.robots[0]);
  scenario.robots.push_back(scenario.robots[0]);
  scenario.robots[1].model = busy(make_vehicle(qdrone2()), random);
  scenario.robots[1].name = "s";
  scenario.robots[2].model = make_vehicle(crazyflie());
  scenario.robots[2].name = "t";
  if (random.uniform() < 0.5) scenario.robots.pop_back();
  if (random.uniform() < 0.5) return scenario;
  scenario.obstacles.push_back({"wall", make_box(0.5, 3.0, 3.0)});
  scenario.obstacles[0].shape.pose.position = {4.0, 0.0, 0.0};
  return scenario;
}

/// Free bases somewhere near x = 2 k, or in one lane of three crowded together.
LaneState scattered_lane(Random<double>& random, const World& world, bool drawn, bool crowded) {
  LaneState state = random_lane(random, world, drawn);
  for (const WorldBody& body : world.bodies) {
    if (body.model->joint.type != JointType::kFree) continue;
    const double x = crowded ? 0.0 : 2.0 * body.robot;
    store(Vec3<double>{x, 0.0, 0.5} + in_cube(random, 0.5), state.q.data() + body.q);
  }
  return state;
}

TEST_P(Packs, HandLanesOverToSimbodyEachForItself) {
  int mixed = 0, changes = 0;
  for (std::uint64_t k = 0; k < 4; ++k) {
    Random<double> random{RandomKey{2026, 14}, k, 0, derive_stream("packs_test")};
    const World world(several(
        random, k % 3 == 0 ? IntegratorChoice::kRk4 : IntegratorChoice::kSemiImplicitEuler));
    TwoWays ways(world);
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      ways.set(lane, scattered_lane(random, world, k % 2 == 0 && lane % 3 != 0, lane % 3 == 1));
    }
    ways.refresh(kAll);
    std::uint32_t lanes = kAll, before = 0;
    for (int step = 0; step < 40; ++step) {
      const std::uint32_t some = step % 5 == 4 ? lanes & kSome : lanes;
      const std::uint32_t through =
          ways.advance(some, "world " + std::to_string(k) + ", step " + std::to_string(step));
      if (testing::Test::HasFatalFailure()) return;
      const std::uint32_t on_simbody = ways.packs.stepper->on_simbody();
      mixed += on_simbody != 0 && on_simbody != some;
      changes += step > 0 && some == lanes && ((on_simbody ^ before) & some) != 0;
      before = on_simbody;
      lanes &= ~(some & ~through);
    }
  }
  EXPECT_GT(mixed, 80) << "lanes of one group went both ways";
  EXPECT_GT(changes, 5) << "and changed over";
}

TEST_P(Packs, LeaveTheOthersAloneWhereOneFailsOnSimbody) {
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
  ways.refresh(kAll);
  EXPECT_EQ(ways.advance(kAll, "two fail"), kAll & ~(1u << 2 | 1u << 4));
  EXPECT_EQ(ways.packs.stepper->on_simbody(), 0x55555555u);
  EXPECT_EQ(ways.packs.stepper->counts().simbody, 16u);
  EXPECT_EQ(ways.packs.stepper->counts().tree, 16u);
  ways.advance(kAll & ~(1u << 2 | 1u << 4), "and the others go on");
}

INSTANTIATE_TEST_SUITE_P(Isas, Packs, testing::ValuesIn(kIsas),
                         [](const auto& isa) { return std::string(name(isa.param)); });

}  // namespace
}  // namespace skybody::test
