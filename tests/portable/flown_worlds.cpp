#include "tests/portable/flown_worlds.h"

#include <cstdint>
#include <utility>

#include "core/physics/bodies/kinematics.h"
#include "core/physics/world/lane_values.h"
#include "tests/unit/physics/random_worlds.h"

namespace skybody::test {
namespace {

IntegratorChoice integrator_of(int k) { return kFixedSteps[k % 3]; }

std::unique_ptr<const World> new_world(Scenario scenario,
                                       const std::function<void(WorldPlan&)>& prepare = {}) {
  return std::unique_ptr<const World>(new World(make_world(std::move(scenario), prepare)));
}

/// Any tree, sometimes with two wrenches on its base.
std::unique_ptr<const World> make_tree_world(Random<double>& random, int k) {
  return new_world(make_scenario(busy(random_tree(random), random), integrator_of(k)),
                   [k](WorldPlan& plan) {
                     if (k % 4 != 0) return;
                     plan.sites = {{0, {0.1, 0, 0}, true, false}, {0, {0, 0, 0.1}, false, true}};
                   });
}

/// Trees and free robots with held effect inputs: all of them, or a single one.
std::unique_ptr<const World> make_held_world(Random<double>& random, int k) {
  const RobotModel model = k % 2 == 0 ? make_vehicle(qdrone2()) : random_tree(random);
  return new_world(make_scenario(busy(model, random), integrator_of(k)), [k](WorldPlan& plan) {
    const int count = static_cast<int>(plan.holds.size());
    for (int i = 0; i < count; ++i) {
      plan.holds[static_cast<std::size_t>(i)] = k < count || k % count == i;
    }
  });
}

std::unique_ptr<const World> make_joint_drive_world(Random<double>& random, int k) {
  const Topology topology(make_scenario(busy(random_tree(random), random), integrator_of(k)));
  WorldPlan plan(topology);
  plan.joint_drives = drives_for(random, topology);
  return std::make_unique<const World>(topology, std::move(plan));
}

/// The free base of a tree moves by commanded motion.
std::unique_ptr<const World> make_base_drive_world(Random<double>& random, int k) {
  RobotModel model = random_tree(random);
  Joint& joint = model.bodies[0].joint;
  joint.type = JointType::kFree;
  joint.frame_in_parent = joint.frame_in_body = Pose{};
  return new_world(make_scenario(busy(std::move(model), random), integrator_of(k)),
                   [k](WorldPlan& plan) {
                     plan.drives = {k % 2 == 0 ? DriveKind::kVelocity : DriveKind::kPose};
                   });
}

/// One free body with four or six level rotors, which have separate code.
std::unique_ptr<const World> make_level_world(Random<double>&, int k) {
  const VehicleData vehicles[] = {qdrone2(), crazyflie(), hummingbird(), firefly()};
  return new_world(make_scenario(make_vehicle(vehicles[k % 4]), integrator_of(k)));
}

/// One free body with rotors of any kind added to the level ones. Every second body is flat: one
/// moment of inertia exceeds the sum of the other two by round-off, which checked_mass.h corrects.
std::unique_ptr<const World> make_free_world(Random<double>& random, int k) {
  RobotModel model = make_vehicle(qdrone2());
  if (k % 2 == 1) {
    const SymMat3<double> flat = diagonal(0.01, 0.02, 0.03 * (1.0 + 5e-7));
    model.bodies[0].mass.inertia = rotate_inertia(to_mat3(random.quaternion()), flat);
  }
  return new_world(make_scenario(busy(std::move(model), random), integrator_of(k)));
}

/// Distance between robots [m]: no robot comes near another.
constexpr double kFarApart = 1000.0;

/// Two or three robots, sometimes with an obstacle: free robots on the ground, or a tree among them
/// without ground, because contact with it could break its joints.
std::unique_ptr<const World> make_several_world(Random<double>& random, int k) {
  Scenario scenario = several(random, integrator_of(k));
  if (k % 2 == 0) scenario.robots[0].model = make_vehicle(firefly());
  scenario.contact.ground = k % 2 == 0;
  for (Obstacle& obstacle : scenario.obstacles) obstacle.shape.pose.position.x = -kFarApart;
  return new_world(std::move(scenario));
}

/// Targets of drives, slightly away from the bases' positions, and velocities.
void draw_drives(Random<double>& random, const World& world, LaneState& state) {
  double* drive = state.drive.data();
  for (std::size_t r = 0; r < world.drives.size(); ++r) {
    if (world.drives[r] == DriveKind::kNone) continue;
    const double* base = state.q.data() + world.layout.robots[r].first_q;
    store(in_cube(random, 2.0), drive + kDriveVelocity);
    store(in_cube(random, 2.0), drive + kDriveAngularVelocity);
    store(load_vec3(base) + in_cube(random, 0.002), drive + kDrivePosition);
    const Vec3<double> turn = in_cube(random, 0.001);
    store(normalized(load_quat(base + 3) * Quat<double>{1.0, turn.x, turn.y, turn.z}),
          drive + kDriveRotation);
    drive += kDriveSize;
  }
}

std::vector<LaneState> draw_lanes(Random<double>& random, const World& world, int k) {
  std::vector<LaneState> lanes;
  for (int lane = 0; lane < kGroupLanes; ++lane) {
    LaneState state = random_lane(random, world, k % 2 == 0 && lane % 3 != 0);
    for (const WorldBody& body : world.bodies) {
      if (world.scenario.robots.size() == 1 || body.model->joint.type != JointType::kFree) continue;
      state.q[static_cast<std::size_t>(body.q)] += kFarApart * body.robot;
    }
    draw_drives(random, world, state);
    lanes.push_back(std::move(state));
  }
  return lanes;
}

/// Worlds of one kind.
struct Kind {
  const char* name;
  int count;
  std::unique_ptr<const World> (*make)(Random<double>& random, int k);
};

constexpr Kind kKinds[] = {
    {"tree", 24, make_tree_world},
    {"held", 24, make_held_world},
    {"joint_drive", 12, make_joint_drive_world},
    {"base_drive", 8, make_base_drive_world},
    {"level_rotors", 12, make_level_world},
    {"free_robot", 8, make_free_world},
    {"several_robots", 6, make_several_world},
};

}  // namespace

std::vector<FlownWorld> make_flown_worlds() {
  std::vector<FlownWorld> worlds;
  for (const Kind& kind : kKinds) {
    for (int k = 0; k < kind.count; ++k) {
      Random<double> random{RandomKey{2026, 18}, static_cast<std::uint64_t>(k), 0,
                            derive_stream(kind.name)};
      FlownWorld flown{kind.name + std::string("_") + std::to_string(k), kind.make(random, k), {}};
      flown.lanes = draw_lanes(random, *flown.world, k);
      worlds.push_back(std::move(flown));
    }
  }
  return worlds;
}

}  // namespace skybody::test
