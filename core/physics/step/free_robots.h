// Robots that are one free body each, with what their quick step reads: worlds of such robots need
// neither a tree nor an intermediate array.
#pragma once

#include <vector>

#include "core/physics/forces/force_accumulators.h"
#include "core/physics/forces/rotor_force.h"
#include "core/physics/world/world.h"

namespace skybody {

/// One robot. Places are within the blocks of state words.
struct FreeRobot {
  int body = 0, q = 0, u = 0;
  RotorGroup rotors;                ///< all of them; none where `count` is 0
  int constants = 0;                ///< first of its kRobotParamCount parameters
  std::vector<int> sites;           ///< within World::sites
  bool is_disturbed = false;        ///< likewise
  InertiaStructure shape;           ///< by the nominal parameters
  bool are_rotors_in_rows = false;  ///< four level ones, and no others, by the nominal parameters
  bool are_rotors_alike = false;    ///< and these by the nominal parameters

  bool has_four_level_rotors() const { return rotors.is_level && rotors.count == 4; }
  /// The commonest kind, by the nominal parameters: the only robot of its world, four rotors alike
  /// in rows, a diagonal inertia below or above the origin, gravity along z of W, and no force on
  /// it but these.
  bool is_plain_quadrotor = false;
};

/// All robots of a world. Immutable; refers to the world, which must outlive it.
struct FreeRobots {
  /// @param world  is_possible
  explicit FreeRobots(const World& world);

  /// Whether every robot is one free body that no drive moves, and the integrator's steps are
  /// fixed.
  static bool is_possible(const World& world);

  const World& world;
  double rate = 0.0;         ///< physics steps a second: 1/dt
  double fast_square = 0.0;  ///< fast_spin_square()
  std::vector<FreeRobot> robots;
  std::vector<RotorMount> rotors;  ///< of the world
};

}  // namespace skybody
