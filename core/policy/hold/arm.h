// Geometry and statics of an arm, for the hold baseline: revolute and prismatic joints, each with a
// position drive, from a robot's base to a tool.
#pragma once

#include <vector>

#include "core/physics/world/lane_state.h"
#include "core/physics/world/world.h"

namespace skybody {

/// State of an environment for the hold baseline, without goals.
struct KnownState {
  const World& world;
  const std::vector<BodyState>& bodies;
  const std::vector<double>& params;
  Vec3<double> gravity;  ///< W [m/s^2]

  const double* body_params(int body) const;
};

/// The centre of mass of world bodies `first` to `first + count - 1`, W [m].
Vec3<double> center_of_mass(const KnownState& now, int first, int count);

/// A chain of driven joints from the base of a robot to a point of one of its bodies.
class Arm {
 public:
  /// An arm without joints, which cannot reach.
  Arm() = default;
  /// @param base, body  world body indices
  /// @param point       of `body`, in its frame [m]
  /// @param drives      of the robot's joints
  Arm(const World& world, int base, int body, const Vec3<double>& point,
      const std::vector<JointDrive>& drives);

  /// Whether there are joints between base and body, and each has a position drive.
  bool can_reach() const { return !joints_.empty(); }

  /// Positions of the joints, from the base on, that bring the point to `target`, in axes and
  /// origin of the base [m]. They lie within the drives' bounds. The search starts at the
  /// scenario's positions and returns the nearest positions that it finds.
  std::vector<double> reach(const Vec3<double>& target) const;

  /// The point with these joint positions, in axes and origin of the base [m].
  Vec3<double> place(const std::vector<double>& positions) const;

  /// The command that brings joint `k` to `position`: it adds the drive's deflection under the
  /// weight that the joint carries.
  double command(const KnownState& now, std::size_t k, double position) const;

  /// Index of a drive's joint within the arm, from the base on; -1: not a joint of the arm.
  int joint_of(const JointDrive& drive) const;

 private:
  struct Posture;
  Posture posture(const std::vector<double>& positions) const;

  const World* world_ = nullptr;
  Vec3<double> point_{0.0, 0.0, 0.0};
  std::vector<JointDrive> joints_;  ///< from the base on
};

}  // namespace skybody
