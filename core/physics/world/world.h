// The constant description of a world, shared by all environments: bodies, rotors and contact
// points of all robots of a scenario in one numbering, and the location of each value in state
// words.
//
// Plugins need the numbering to be configured, and then state their needs. A world is therefore
// built in this order:
// 1. Topology: the numbering.
// 2. WorldPlan: the plugins' needs.
// 3. World: topology, final layout and plan.
// Topology and World are immutable.
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/model/scenario.h"
#include "core/model/state_layout.h"

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

/// Point of action of a controller's wrench. Six values each: force [N], then moment [N m].
struct WrenchSite {
  int body = 0;                       ///< world body index
  Vec3<double> point{0.0, 0.0, 0.0};  ///< in the body's frame [m]
  bool at_com = false;     ///< act at the body's current centre of mass instead of `point`
  bool world_axes = true;  ///< axes of force and moment: W, or the body's
};

/// Meaning of a joint drive's command.
enum class JointMode { kPosition, kVelocity, kEffort };

/// A drive of one coordinate of a joint. With r the command after the lag, and q and u of the
/// coordinate, the effort [N m] or [N], clamped to [-effort_limit, effort_limit], is
///   kPosition  stiffness (r - q) - damping u
///   kVelocity  damping (r - u)
///   kEffort    r
struct JointDrive {
  int body = 0;        ///< world body index: its inboard joint, a pin, slider or universal joint
  int coordinate = 0;  ///< 0; of a universal joint 0 or 1
  JointMode mode = JointMode::kEffort;
  double stiffness = 0.0;     ///< [N m/rad] or [N/m]
  double damping = 0.0;       ///< [N m s/rad] or [N s/m]
  double effort_limit = 0.0;  ///< [N m] or [N]; may be infinite
  double tau = 0.0;           ///< time constant of the first-order lag [s]; 0: none
  double low = -INFINITY;     ///< bounds of the command
  double high = INFINITY;
};

/// Kinematic drive of a robot's base by a controller, if any.
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
  const std::vector<WorldBody> bodies;  ///< each body's model lies in the scenario; each rotor's,
                                        ///< too
  const std::vector<WorldRotor> rotors;
};

/// A World's input besides its topology.
struct WorldPlan {
  /// The values that physics needs; no sites, no drives, no held inputs.
  explicit WorldPlan(const Topology& topology);

  StateLayout layout;  ///< without offsets, and without the sizes of wrench, drive, joint drives,
                       ///< held inputs and params
  std::vector<WrenchSite> sites;
  std::vector<DriveKind> drives;  ///< one per robot
  std::vector<JointDrive> joint_drives;
  std::array<bool, SKYBODY_HELD_COUNT> holds{};  ///< the held inputs
};

/// Complete description of one world. Not copyable.
class World : public Topology {
 public:
  /// Throws std::logic_error (an internal error) for joint drives that their joint cannot have.
  World(const Topology& topology, WorldPlan plan);
  /// A world without plugins.
  explicit World(const Topology& topology) : World(topology, WorldPlan(topology)) {}
  explicit World(Scenario scenario_in) : World(Topology(std::move(scenario_in))) {}
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  const StateLayout layout;
  const std::vector<WrenchSite> sites;  ///< of the controllers that output wrenches, in their order
  const std::vector<DriveKind> drives;  ///< one per robot
  const std::vector<JointDrive> joint_drives;  ///< at most one per coordinate
};

/// Number of friction bristles of an environment (contact/normal_and_friction_law.h): one per point
/// of each contact shape and, if there is more to touch than the ground, one per edge. Used by
/// World's constructor, defined in contact/contact_scene.cpp.
int count_bristles(const Topology& topology);

}  // namespace skybody
