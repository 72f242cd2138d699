// Robots of one free body each, with the data of their fast step. Worlds of such robots need
// neither a tree nor intermediate arrays.
#pragma once

#include <vector>

#include "core/physics/forces/force_accumulators.h"
#include "core/physics/forces/rotor_force.h"
#include "core/physics/world/world.h"

namespace skybody {

/// One robot. Indices are within the blocks of state words.
struct FreeRobot {
  int body = 0, q = 0, u = 0;
  RotorGroup rotors;                ///< all its rotors; `count` is 0 if it has none
  int constants = 0;                ///< first of its kRobotParamCount parameters
  std::vector<int> sites;           ///< indices into World::sites
  bool is_disturbed = false;        ///< has a disturbance, by the nominal parameters
  InertiaStructure shape;           ///< by the nominal parameters
  bool are_rotors_in_rows = false;  ///< exactly four level rotors, in rows, by the nominal
                                    ///< parameters
  bool are_rotors_alike = false;    ///< these are equal, by the nominal parameters

  bool has_four_level_rotors() const { return rotors.is_level && rotors.count == 4; }
  /// The most common kind, by the nominal parameters: the only robot of its world, four equal
  /// rotors in rows, a centre of mass on the z axis, no products of inertia, gravity along z of W,
  /// and no other forces.
  bool is_plain_quadrotor = false;
};

/// All robots of a world. Immutable; refers to the world, which must outlive it.
struct FreeRobots {
  /// @param world  must satisfy is_possible()
  explicit FreeRobots(const World& world);

  /// Whether every robot is one free body without a drive, and the integrator's steps are fixed.
  static bool is_possible(const World& world);

  const World& world;
  double rate = 0.0;         ///< physics steps per second: 1/dt
  double fast_square = 0.0;  ///< fast_spin_square()
  std::vector<FreeRobot> robots;
  std::vector<RotorMount> rotors;  ///< of the world
};

}  // namespace skybody
