#include "core/physics/free_robots.h"

#include <algorithm>

#include "core/physics/force_model.h"
#include "core/physics/pose_math.h"

namespace skybody {

bool FreeRobots::is_possible(const World& world) {
  if (world.scenario.stepping.integrator != IntegratorChoice::kSemiImplicitEuler) return false;
  const auto is_driven = [](DriveKind drive) { return drive != DriveKind::kNone; };
  if (std::any_of(world.drives.begin(), world.drives.end(), is_driven)) return false;
  if (!joints_with_forces(world).empty()) return false;
  return std::all_of(world.bodies.begin(), world.bodies.end(), [](const WorldBody& body) {
    const Joint& joint = body.model->joint;
    return body.parent < 0 && joint.type == JointType::kFree &&
           is_identity(joint.frame_in_parent) && is_identity(joint.frame_in_body);
  });
}

FreeRobots::FreeRobots(const World& w) : world(w), rotors(make_rotor_places(w)) {
  for (std::size_t r = 0; r < w.layout.robots.size(); ++r) {
    const RobotLayout& layout = w.layout.robots[r];
    FreeRobot robot;
    robot.body = layout.first_body;
    robot.q = layout.first_q;
    robot.u = layout.first_u;
    robot.first_rotor = layout.first_rotor;
    robot.rotor_count = layout.rotor_count;
    robot.disturbance = w.layout.disturbance_params[r];
    for (std::size_t s = 0; s < w.sites.size(); ++s) {
      if (w.sites[s].body == robot.body) robot.sites.push_back(static_cast<int>(s));
    }
    robots.push_back(robot);
  }
  for (const ContactGroup& contact : make_contact_groups(w)) {
    robots[static_cast<std::size_t>(w.bodies[static_cast<std::size_t>(contact.body)].robot)]
        .contact = contact;
  }
}

}  // namespace skybody
