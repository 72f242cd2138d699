#include "core/physics/step/free_robots.h"

#include <algorithm>

#include "core/physics/forces/force_model.h"
#include "core/physics/step/integration_rules.h"
#include "core/physics/world/pose_math.h"

namespace skybody {

bool FreeRobots::is_possible(const World& world) {
  if (is_error_controlled(world.scenario.stepping.integrator)) return false;
  if (!world.scenario.couplings.empty()) return false;
  const auto is_driven = [](DriveKind drive) { return drive != DriveKind::kNone; };
  if (std::any_of(world.drives.begin(), world.drives.end(), is_driven)) return false;
  const auto turns_back = [](const WorldRotor& rotor) { return rotor.model->is_reversible(); };
  if (std::any_of(world.rotors.begin(), world.rotors.end(), turns_back)) return false;
  return std::all_of(world.bodies.begin(), world.bodies.end(), [](const WorldBody& body) {
    const Joint& joint = body.model->joint;
    return body.parent < 0 && joint.type == JointType::kFree &&
           is_identity(joint.frame_in_parent) && is_identity(joint.frame_in_body);
  });
}

namespace {

/// FreeRobot::are_rotors_alike.
/// @param places  of all rotors of the world
/// @param params  nominal parameters
bool are_nominally_alike(const RotorGroup& group, const std::vector<RotorMount>& places,
                         const double* params) {
  double factors[4 * kRotorFactorCount];
  for (int i = 0; i < 4; ++i) {
    const RotorMount& place = places[static_cast<std::size_t>(group.first + i)];
    make_rotor_factors(params + place.params, place, factors + kRotorFactorCount * i);
  }
  return are_alike(static_cast<const double*>(factors));
}

bool is_plain(const World& world, const FreeRobot& robot) {
  const Vec3<double> gravity = world.scenario.gravity();
  return world.layout.robots.size() == 1 && robot.are_rotors_alike && robot.shape.is_axial &&
         robot.shape.has_no_products && gravity.x == 0.0 && gravity.y == 0.0 &&
         !robot.is_disturbed && robot.sites.empty();
}

}  // namespace

FreeRobots::FreeRobots(const World& w)
    : world(w),
      rate(1.0 / w.scenario.stepping.dt),
      fast_square(fast_spin_square(w.scenario.stepping.dt)),
      rotors(make_rotor_places(w)) {
  for (std::size_t r = 0; r < w.layout.robots.size(); ++r) {
    const RobotLayout& layout = w.layout.robots[r];
    FreeRobot robot;
    robot.body = layout.first_body;
    robot.q = layout.first_q;
    robot.u = layout.first_u;
    robot.constants = w.layout.robot_params[r];
    for (std::size_t s = 0; s < w.sites.size(); ++s) {
      if (w.sites[s].body == robot.body) robot.sites.push_back(static_cast<int>(s));
    }
    const MassProperties& mass = w.bodies[static_cast<std::size_t>(robot.body)].model->mass;
    robot.shape.is_axial = mass.com.x == 0.0 && mass.com.y == 0.0;
    robot.shape.has_no_products =
        !is_not_zero(Vec3<double>{mass.inertia.xy, mass.inertia.xz, mass.inertia.yz});
    for (int k = kDisturbanceForce; k <= kDisturbanceMomentLast; ++k) {
      robot.is_disturbed |= w.scenario.robots[r].constants[static_cast<std::size_t>(k)] != 0.0;
    }
    robots.push_back(robot);
  }
  const std::vector<double> params = w.layout.nominal_params();
  for (const RotorGroup& group : make_rotor_groups(w)) {
    FreeRobot& robot =
        robots[static_cast<std::size_t>(w.bodies[static_cast<std::size_t>(group.body)].robot)];
    robot.rotors = group;
    robot.are_rotors_in_rows =
        robot.has_four_level_rotors() && are_in_rows(rotors.data() + group.first, params.data());
    robot.are_rotors_alike =
        robot.are_rotors_in_rows && are_nominally_alike(group, rotors, params.data());
    robot.is_plain_quadrotor = is_plain(w, robot);
  }
}

}  // namespace skybody
