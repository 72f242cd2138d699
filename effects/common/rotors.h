// Robots with rotors and their hover speeds, for an effect's configure().
#pragma once

#include <skybody/plugin.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace skybody::effect {

/// Indices of the robots called `names`, in their order; without names all with rotors.
/// @param effect  name of the effect, for messages
/// @throws std::runtime_error if one of them has no rotors, is unknown or named twice, or if no
///     robot has rotors
inline std::vector<int> robots_with_rotors(const Setup& setup,
                                           const std::vector<std::string>& names,
                                           const std::string& effect) {
  std::vector<int> chosen;
  for (const std::string& name : names) {
    const int robot = setup.robot(name);
    for (const int other : chosen) {
      if (other != robot) continue;
      refuse("`robots` names `", name, "` twice: name each robot once");
    }
    if (setup.robots()[robot].rotor_count == 0) {
      refuse("robot `", name, "` has no rotors, which ", effect,
             " acts on: leave it out of `robots`, or give it a rotors file");
    }
    chosen.push_back(robot);
  }
  for (int r = 0; names.empty() && r < setup.robots().size(); ++r) {
    if (setup.robots()[r].rotor_count > 0) chosen.push_back(r);
  }
  if (chosen.empty()) {
    refuse("no robot has rotors, which ", effect,
           " acts on: give one a rotors file, or leave the effect out");
  }
  return chosen;
}

/// The same for an effect that does not support reversible rotors.
/// @throws std::runtime_error as above, or if one of the robots has a reversible rotor
inline std::vector<int> robots_with_one_way_rotors(const Setup& setup,
                                                   const std::vector<std::string>& names,
                                                   const std::string& effect) {
  const std::vector<int> chosen = robots_with_rotors(setup, names, effect);
  for (const int robot : chosen) {
    for (const RotorInfo& rotor : setup.rotors_of(robot)) {
      if (!(rotor.min_speed < 0.0)) continue;
      refuse("rotor `", rotor.name, "` of robot `", setup.robots()[robot].name,
             "` turns backwards, too (min_speed ", rotor.min_speed, "), which ", effect,
             " does not know: leave the robot out of `robots`");
    }
  }
  return chosen;
}

/// Nominal weight of a robot [N]; 0 for a fixed base, which the rotors need not carry.
inline double weight(const Setup& setup, int robot) {
  const RobotInfo& r = setup.robots()[robot];
  if (r.fixed_base != 0) return 0.0;
  double mass = 0.0;
  for (int b = r.first_body; b < r.first_body + r.body_count; ++b) mass += setup.bodies()[b].mass;
  const double* g = setup.gravity();
  return mass * norm(Vec3<double>{g[0], g[1], g[2]});
}

/// Rotor speed at which the robot's rotors carry its nominal weight, equal for all, with thrust
/// along gravity [rad/s]; 0 for a robot with a fixed base.
inline double hover_speed(const Setup& setup, int robot) {
  double thrust_constants = 0.0;
  for (const RotorInfo& rotor : setup.rotors_of(robot)) {
    thrust_constants += rotor.constants[SKYBODY_ROTOR_THRUST_CONSTANT];
  }
  return thrust_constants > 0.0 ? sqrt(weight(setup, robot) / thrust_constants) : 0.0;
}

}  // namespace skybody::effect
