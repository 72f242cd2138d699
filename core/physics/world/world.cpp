#include "core/physics/world/world.h"

#include "core/base/system/error.h"
#include "core/physics/world/pose_math.h"
#include "core/physics/world/world_layout.h"

namespace skybody {
namespace {

std::vector<WorldBody> number_bodies(const Scenario& scenario) {
  std::vector<WorldBody> bodies;
  int robot = 0, next_q = 0, next_u = 0;
  for (const RobotUse& use : scenario.robots) {
    const int first = static_cast<int>(bodies.size());
    for (const Body& body : use.model.bodies) {
      const int parent = body.joint.parent < 0 ? -1 : first + body.joint.parent;
      bodies.push_back({robot, parent, &body, next_q, next_u});
      next_q += position_size(body.joint.type);
      next_u += velocity_size(body.joint.type);
    }
    ++robot;
  }
  return bodies;
}

std::vector<WorldRotor> number_rotors(const Scenario& scenario) {
  std::vector<WorldRotor> rotors;
  int robot = 0, first_body = 0;
  for (const RobotUse& use : scenario.robots) {
    for (const Rotor& rotor : use.model.rotors) {
      rotors.push_back({robot, first_body + rotor.body, &rotor});
    }
    first_body += static_cast<int>(use.model.bodies.size());
    ++robot;
  }
  return rotors;
}

/// A free base's q must be its pose in W and its u its velocity, because plugins write them as
/// such.
void demand_plain_free_bases(const Topology& topology) {
  int robot = -1;
  for (const WorldBody& body : topology.bodies) {
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

/// The drives, checked: each must have a coordinate of its own.
std::vector<JointDrive> checked_drives(const Topology& topology, std::vector<JointDrive> drives) {
  for (std::size_t i = 0; i < drives.size(); ++i) {
    const JointDrive& drive = drives[i];
    const Body& body = *topology.bodies.at(static_cast<std::size_t>(drive.body)).model;
    const JointType type = body.joint.type;
    SKYBODY_DEMAND(
        type == JointType::kPin || type == JointType::kSlider || type == JointType::kUniversal,
        "a drive in the joint of '" + body.name + "', which has no single coordinates");
    SKYBODY_DEMAND(drive.coordinate >= 0 && drive.coordinate < velocity_size(type),
                   "a drive of a coordinate that the joint of '" + body.name + "' does not have");
    for (std::size_t k = 0; k < i; ++k) {
      SKYBODY_DEMAND(drives[k].body != drive.body || drives[k].coordinate != drive.coordinate,
                     "two drives of one coordinate of '" + body.name + "'");
    }
  }
  return drives;
}

}  // namespace

Topology::Topology(Scenario scenario_in)
    : owner_(std::make_shared<const Scenario>(std::move(scenario_in))),
      scenario(*owner_),
      bodies(number_bodies(scenario)),
      rotors(number_rotors(scenario)) {
  demand_plain_free_bases(*this);
}

WorldPlan::WorldPlan(const Topology& topology)
    : layout(physics_layout(topology)), drives(topology.scenario.robots.size(), DriveKind::kNone) {}

World::World(const Topology& topology, WorldPlan plan)
    : Topology(topology),
      layout(finish_layout(plan)),
      sites(std::move(plan.sites)),
      drives(std::move(plan.drives)),
      joint_drives(checked_drives(topology, std::move(plan.joint_drives))) {}

}  // namespace skybody
