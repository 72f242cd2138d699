#include "core/physics/world.h"

#include "core/base/error.h"
#include "core/physics/contact_spheres.h"
#include "core/physics/pose_math.h"
#include "core/physics/world_layout.h"

namespace skybody {
namespace {

void number_bodies(World& world, int robot, int& next_q, int& next_u) {
  const RobotModel& model = world.scenario.robots[robot].model;
  const int first = static_cast<int>(world.bodies.size());
  for (const Body& body : model.bodies) {
    const int parent = body.joint.parent < 0 ? -1 : first + body.joint.parent;
    world.bodies.push_back({robot, parent, &body, next_q, next_u});
    next_q += position_size(body.joint.type);
    next_u += velocity_size(body.joint.type);
  }
  for (const Rotor& rotor : model.rotors) {
    world.rotors.push_back({robot, first + rotor.body, &rotor});
  }
}

/// A free base's q is its pose in W, its u its velocity: plugins write them as such.
void demand_plain_free_bases(const World& world) {
  int robot = -1;
  for (const WorldBody& body : world.bodies) {
    const bool base = body.robot != robot;
    robot = body.robot;
    const Joint& joint = body.model->joint;
    if (joint.type != JointType::kFree || body.parent >= 0) continue;
    SKYBODY_DEMAND(base, "body '" + body.model->name + "' moves freely and is not the base");
    SKYBODY_DEMAND(is_identity(joint.frame_in_parent) && is_identity(joint.frame_in_body),
                   "the joint frames of the free base '" + body.model->name +
                       "' are not those of W and of the body");
  }
}

}  // namespace

World::World(Scenario scenario_in) : scenario(std::move(scenario_in)) {
  int next_q = 0, next_u = 0;
  const int robots = static_cast<int>(scenario.robots.size());
  for (int robot = 0; robot < robots; ++robot) number_bodies(*this, robot, next_q, next_u);
  demand_plain_free_bases(*this);
  drives.assign(robots, DriveKind::kNone);
  if (scenario.contact.ground) spheres = make_contact_spheres(*this);
  simbody_contact = make_simbody_contact(*this);
  add_physics_layout(*this);
  finish_layout(*this);
}

}  // namespace skybody
