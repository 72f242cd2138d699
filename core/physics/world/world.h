// What never changes while environments step: the bodies, rotors and contact points of all robots
// of a scenario in one numbering, and where each value lies in state words. Shared by all.
//
// Plugins are configured by the numbering and say then what the world has to hold for them. So it
// is made in two steps: Topology, what plugins ask for (WorldPlan), World. Both classes are
// immutable.
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <utility>
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

/// Where a controller's wrench acts. Six values each: force [N], then moment [N m].
struct WrenchSite {
  int body = 0;                       ///< world body index
  Vec3<double> point{0.0, 0.0, 0.0};  ///< in the body's frame [m]
  bool at_com = false;     ///< act at the body's present centre of mass instead of `point`
  bool world_axes = true;  ///< axes of force and moment: W, or else the body's
};

/// What the command of a joint's drive means.
enum class JointMode { kPosition, kVelocity, kEffort };

/// A drive of one coordinate of a joint. With r the command behind its lag, q and u of the
/// coordinate, the effort [N m] or [N] is, held to [-effort_limit, effort_limit],
///   kPosition  stiffness (r - q) - damping u
///   kVelocity  damping (r - u)
///   kEffort    r
struct JointDrive {
  int body = 0;        ///< world body index: its inboard joint, a pin, slider or universal joint
  int coordinate = 0;  ///< of a universal joint 0 or 1
  JointMode mode = JointMode::kEffort;
  double stiffness = 0.0;     ///< [N m/rad] or [N/m]
  double damping = 0.0;       ///< [N m s/rad] or [N s/m]
  double effort_limit = 0.0;  ///< [N m] or [N]; may be infinite
  double tau = 0.0;           ///< time constant of the first-order lag [s]; 0: none
  double low = -INFINITY;     ///< bounds to which the command is held
  double high = INFINITY;
};

/// How a robot's base is driven kinematically by a controller, if at all.
enum class DriveKind { kNone, kVelocity, kPose };

/// The 13 values of a drive: velocity of the base's origin and angular velocity in base axes, then
/// the base's pose in W (quaternion w x y z).
enum DriveValue : int {
  kDriveVelocity = 0,
  kDriveAngularVelocity = 3,
  kDrivePosition = 6,
  kDriveRotation = 9,
  kDriveSize = 13
};

/// The bodies and rotors of all robots in one numbering. Copies share the scenario.
class Topology {
  std::shared_ptr<const Scenario> owner_;

 public:
  explicit Topology(Scenario scenario_in);

  const Scenario& scenario;
  const std::vector<WorldBody> bodies;  ///< each body's model lies in the scenario; so do rotors'
  const std::vector<WorldRotor> rotors;
};

/// What a World gets beside its topology.
struct WorldPlan {
  /// The values that physics needs; no sites, no drives, nothing held.
  explicit WorldPlan(const Topology& topology);

  Layout layout;  ///< without offsets, and without the sizes of wrench, drive, joint drives, held
                  ///< inputs and params
  std::vector<WrenchSite> sites;
  std::vector<DriveKind> drives;  ///< one per robot
  std::vector<JointDrive> joint_drives;
  std::array<bool, SKYBODY_HELD_COUNT> holds{};  ///< inputs that effects hold
};

/// Complete description of one world. Not copyable.
class World : public Topology {
 public:
  /// Joint drives that no joint can have are our bug (std::logic_error).
  World(const Topology& topology, WorldPlan plan);
  /// Without plugins.
  explicit World(const Topology& topology) : World(topology, WorldPlan(topology)) {}
  explicit World(Scenario scenario_in) : World(Topology(std::move(scenario_in))) {}
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  const Layout layout;
  const std::vector<WrenchSite> sites;  ///< of the controllers that give wrenches, in their order
  const std::vector<DriveKind> drives;  ///< one per robot
  const std::vector<JointDrive> joint_drives;  ///< at most one per coordinate
};

/// Bristles of friction that an environment keeps (contact/contact_law.h): one for each point of
/// each solid, and where there is more than the ground to touch one for each edge. For World's
/// constructor, in contact/contact_scene.cpp.
int count_bristles(const Topology& topology);

}  // namespace skybody
