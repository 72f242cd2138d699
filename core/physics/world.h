// What never changes while environments step: the bodies, rotors and contact points of all robots
// of a scenario in one numbering, and where each value lies in WorldState. Built once, shared by
// all.
#pragma once

#include <memory>
#include <vector>

#include "core/model/layout.h"
#include "core/model/scenario.h"

namespace skybody {

/// A body in the world's numbering.
struct WorldBody {
  int robot = 0;
  int parent = -1;  ///< world body index; -1: the world
  const Body* model = nullptr;
  int q = 0;  ///< first coordinate within the q block
  int u = 0;  ///< first coordinate within the u block
};

/// A rotor in the world's numbering.
struct WorldRotor {
  int robot = 0;
  int body = 0;  ///< world body index
  const Rotor* model = nullptr;
};

/// A sphere that rests on the ground: at an extremity of a collision shape.
struct ContactSphere {
  int body = 0;                        ///< world body index
  Vec3<double> center{0.0, 0.0, 0.0};  ///< in the body's frame [m]
  double radius = 0.0;                 ///< [m]; 0 for the corner of a box
  double stiffness = 0.0;              ///< Hunt-Crossley k [N/m^1.5], from the robot's nominal mass
  double most_damping = 0.0;           ///< m/dt [N s/m]: what a time step can stop, and no more
};

/// Where a controller's wrench acts. Six values each: force [N], then moment [N m].
struct WrenchSite {
  int body = 0;                       ///< world body index
  Vec3<double> point{0.0, 0.0, 0.0};  ///< in the body's frame [m]
  bool at_com = false;     ///< act at the body's present centre of mass instead of `point`
  bool world_axes = true;  ///< axes of force and moment: W, or else the body's
};

/// How a robot's base is driven kinematically by a controller, if at all.
enum class DriveKind { kNone, kVelocity, kPose };

/// Surfaces for Simbody's contact (simbody_contact.h).
class SimbodyContact;

/// Immutable description of one world. Bodies point into `scenario`, which it owns; not copyable.
class World {
 public:
  /// Numbers bodies and rotors, derives contact spheres and the physics part of the layout
  /// (everything but sensors, plugin states, command and action, which core/env appends).
  explicit World(Scenario scenario);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  Scenario scenario;
  Layout layout;
  std::vector<WorldBody> bodies;
  std::vector<WorldRotor> rotors;
  std::vector<ContactSphere> spheres;
  std::shared_ptr<const SimbodyContact> simbody_contact;  ///< null: nothing but the ground to touch
  std::vector<WrenchSite> sites;  ///< set by core/env from the controllers' declarations
  std::vector<DriveKind> drives;  ///< one per robot, likewise
};

/// The surfaces of a world whose bodies are numbered, or null. For World's constructor.
std::shared_ptr<const SimbodyContact> make_simbody_contact(const World& world);

}  // namespace skybody
