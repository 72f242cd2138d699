// Geometry and statics of an arm, for the hold baseline: revolute and prismatic joints, each with a
// position drive, from a robot's base to a tool.
#pragma once

#include <vector>

#include "core/physics/world/lane_state.h"
#include "core/physics/world/world.h"

namespace skybody {

/// What hold knows of an environment beside its goals.
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

  /// Positions of the joints, from the base on, that bring the point to `target`, axes and origin
  /// of the base [m]; within the drives' bounds, and as near as a search from the scenario's
  /// positions comes.
  std::vector<double> reach(const Vec3<double>& target) const;

  /// Where the point is with these positions, axes and origin of the base [m].
  Vec3<double> place(const std::vector<double>& positions) const;

  /// The command that brings joint `k` to `position`: what its drive gives way under the weight of
  /// what it carries is added.
  double command(const KnownState& now, std::size_t k, double position) const;

  /// Of drive `drive`: its place among the joints, from the base on; -1: it is none of the arm's.
  int joint_of(const JointDrive& drive) const;

 private:
  struct Posture;
  Posture posture(const std::vector<double>& positions) const;

  const World* world_ = nullptr;
  Vec3<double> point_{0.0, 0.0, 0.0};
  std::vector<JointDrive> joints_;  ///< from the base on
};

}  // namespace skybody
