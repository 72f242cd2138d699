#include "core/physics/forces/force_model.h"

namespace skybody {

bool are_in_rows(const RotorMount* rotors, const double* params) {
  const Vec3<double> first = hub_of<double>(params + rotors[0].params);
  const auto is_at = [&](const RotorMount& rotor, double x_sign, double y_sign) {
    const Vec3<double> hub = hub_of<double>(params + rotor.params);
    return hub.x == x_sign * first.x && hub.y == y_sign * first.y &&
           rotor.direction == x_sign * y_sign * rotors[0].direction;
  };
  return is_at(rotors[1], 1, -1) && is_at(rotors[2], -1, 1) && is_at(rotors[3], -1, -1);
}

RotorMount make_rotor_place(const World& world, std::size_t index) {
  const Rotor& rotor = *world.rotors[index].model;
  return {rotor.axis, static_cast<double>(rotor.direction), world.layout.rotor_params[index]};
}

std::vector<RotorMount> make_rotor_places(const World& world) {
  std::vector<RotorMount> places;
  for (std::size_t i = 0; i < world.rotors.size(); ++i) {
    places.push_back(make_rotor_place(world, i));
  }
  return places;
}

std::vector<RotorGroup> make_rotor_groups(const World& world) {
  std::vector<RotorGroup> groups;
  for (std::size_t i = 0; i < world.rotors.size(); ++i) {
    const WorldRotor& rotor = world.rotors[i];
    if (groups.empty() || groups.back().body != rotor.body) {
      groups.push_back({rotor.body, static_cast<int>(i), 0, true});
    }
    RotorGroup& group = groups.back();
    ++group.count;
    const Vec3<double>& n = rotor.model->axis;
    const double height = world.rotors[static_cast<std::size_t>(group.first)].model->position().z;
    group.is_level &= n.x == 0.0 && n.y == 0.0 && n.z == 1.0 && rotor.model->position().z == height;
  }
  return groups;
}

ForceModel::ForceModel(const World& world)
    : world_(world), rotors_(make_rotor_places(world)), rotor_groups_(make_rotor_groups(world)) {
  for (const RobotLayout& robot : world.layout.robots) bases_.push_back(robot.first_body);
  for (const JointDrive& drive : world.joint_drives) {
    const WorldBody& body = world.bodies[static_cast<std::size_t>(drive.body)];
    joint_drives_.push_back({drive, make_lag_factors(drive.tau, world.scenario.stepping.dt),
                             body.q + drive.coordinate, body.u + drive.coordinate});
  }
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    if (joint_constant_count(world.bodies[i].model->joint) > 0) {
      joints_.push_back(static_cast<int>(i));
    }
  }
}

}  // namespace skybody
