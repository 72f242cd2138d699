#include "core/physics/step/free_robots.h"

#include <algorithm>

#include "core/physics/bodies/pose_math.h"
#include "core/physics/forces/force_model.h"
#include "core/physics/step/step_rules.h"

namespace skybody {

bool FreeRobots::is_possible(const World& world) {
  if (is_error_controlled(world.scenario.stepping.integrator)) return false;
  const auto is_driven = [](DriveKind drive) { return drive != DriveKind::kNone; };
  if (std::any_of(world.drives.begin(), world.drives.end(), is_driven)) return false;
  return std::all_of(world.bodies.begin(), world.bodies.end(), [](const WorldBody& body) {
    const Joint& joint = body.model->joint;
    return body.parent < 0 && joint.type == JointType::kFree &&
           is_identity(joint.frame_in_parent) && is_identity(joint.frame_in_body);
  });
}

namespace {

/// The square of a unit quaternion's norm after an Euler step of half the angle `half`.
double square_after(double half) { return 1.0 + half * half; }

}  // namespace

FreeRobots::FreeRobots(const World& w)
    : world(w),
      rate(1.0 / w.scenario.stepping.dt),
      largest_square(square_after(0.5 * w.scenario.stepping.dt * kLargestState)),
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
  for (const RotorGroup& group : make_rotor_groups(w)) {
    robots[static_cast<std::size_t>(w.bodies[static_cast<std::size_t>(group.body)].robot)].rotors =
        group;
  }
  for (const ContactGroup& contact : make_contact_groups(w)) {
    robots[static_cast<std::size_t>(w.bodies[static_cast<std::size_t>(contact.body)].robot)]
        .contact = contact;
  }
}

}  // namespace skybody
