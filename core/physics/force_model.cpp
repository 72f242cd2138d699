#include "core/physics/force_model.h"

namespace skybody {
namespace {

bool has_joint_force(const Joint& joint) {
  return joint.damping != 0.0 || joint.stiffness != 0.0 || joint.limit.enabled;
}

}  // namespace

ForceModel::ForceModel(const World& world) : world_(world) {
  for (const RobotLayout& robot : world.layout.robots) bases_.push_back(robot.first_body);
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    if (has_joint_force(world.bodies[i].model->joint)) stiff_joints_.push_back(static_cast<int>(i));
  }
  for (std::size_t i = 0; i < world.rotors.size(); ++i) {
    const int body = world.rotors[i].body;
    if (rotor_groups_.empty() || rotor_groups_.back().body != body) {
      rotor_groups_.push_back({body, static_cast<int>(i), 0});
    }
    ++rotor_groups_.back().count;
    const Rotor& rotor = *world.rotors[i].model;
    const Vec3<double>& n = rotor.axis;
    rotors_.push_back({rotor.position, n, static_cast<double>(rotor.direction),
                       n.x == 0.0 && n.y == 0.0 && n.z == 1.0, world.layout.rotor_params[i]});
  }
  for (std::size_t i = 0; i < world.spheres.size(); ++i) {
    const ContactSphere& sphere = world.spheres[i];
    if (sphere_groups_.empty() || sphere_groups_.back().body != sphere.body) {
      sphere_groups_.push_back({sphere.body, static_cast<int>(i), 0, 0.0});
    }
    SphereGroup& group = sphere_groups_.back();
    ++group.count;
    // A little more than the exact distance: rounding must never leave out a sphere that touches.
    group.reach = max(group.reach, 1.000001 * (norm(sphere.center) + sphere.radius));
  }
}

}  // namespace skybody
