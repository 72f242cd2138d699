// Hand-written adjoint of torque-free motion (bodies/torque_free.h). Names as in
// free_robot_adjoint.h: a value `x` has the adjoint `to_x`. On double and packs.
#pragma once

#include "core/physics/bodies/torque_free.h"
#include "core/physics/step/rotation_adjoint.h"

namespace skybody {

/// A body after free motion for a time, and the adjoint of that motion.
template <class Real>
class TorqueFreeAdjoint {
 public:
  /// @param inertia, com  as in TorqueFreeCall; the others at the start of the time
  /// @param mask  lanes that move
  SKYBODY_INLINE TorqueFreeAdjoint(const SymMat3<Real>& inertia, const Vec3<Real>& com,
                                   const Real& time, const MaskOf<Real>& mask,
                                   const Quat<Real>& rotation_before,
                                   const Vec3<Real>& velocity_before, const Vec3<Real>& spin_before)
      : rotation(rotation_before),
        velocity(velocity_before),
        spin(spin_before),
        inertia_(inertia),
        com_(com),
        time_(time),
        mask_(mask),
        first_rotation_(rotation_before),
        first_spin_(spin_before),
        parts_(inertia, spin_before, time) {
    Vec3<Real> position = SpatialForce<Real>::zero().force;
    TorqueFreeCall<Real>{inertia_, com_, time_, mask_, position, rotation, velocity, spin}.run();
  }

  // At the end.
  Quat<Real> rotation;
  Vec3<Real> velocity, spin;

  /// Converts adjoints of the end to those of the start, in place; that of the position is the same
  /// for both.
  SKYBODY_INLINE void pull_back(const Vec3<Real>& to_position, Quat<Real>& to_rotation,
                                Vec3<Real>& to_velocity, Vec3<Real>& to_spin) const {
    const Vec3<Real> last_lever = cross(spin, com_);
    to_rotation = sum(to_rotation, pull_back_axes(rotation, outer(-to_position, com_) -
                                                                outer(to_velocity, last_lever)));
    to_spin -= cross(com_, transpose_times(to_mat3(rotation), to_velocity));
    to_velocity += to_position * time_;
    pull_back_turn(to_rotation, to_spin);
    const Vec3<Real> first_lever = cross(first_spin_, com_);
    to_rotation =
        sum(to_rotation, pull_back_axes(first_rotation_, outer(to_position, com_) +
                                                             outer(to_velocity, first_lever)));
    to_spin += cross(com_, transpose_times(to_mat3(first_rotation_), to_velocity));
  }

 private:
  /// Substep by substep, from the last one: the midpoint rule with negative time is its own
  /// inverse.
  SKYBODY_INLINE void pull_back_turn(Quat<Real>& to_rotation, Vec3<Real>& to_spin) const {
    const Real& half = parts_.half;
    Quat<Real> q = rotation;
    Vec3<Real> w = spin;
    Real to_half(0.0);
#pragma GCC unroll 1
    for (int p = 0; p < kTorqueFreeParts; ++p) {
      const auto is_active = logical_and(mask_, parts_.count > static_cast<double>(p));
      if (none(is_active)) break;
      MidpointSpin<Real> part(inertia_, w, -half);
      part.invert(inertia_, half);
      const Quat<Real> turn = part.turn(half);
      const Quat<Real> before = normalized(q * conjugate(turn));
      const Quat<Real> to_turned = pull_back_norm(to_rotation, q, 1.0 / sqrt(squared_norm(turn)));
      const Quat<Real> to_turn = conjugate(before) * to_turned;
      const Vec3<Real> to_angle{to_turn.x, to_turn.y, to_turn.z};
      const Vec3<Real> to_mean = to_angle * half + (to_spin + to_spin);
      const Vec3<Real> to_error =
          part.row_x * to_mean.x + part.row_y * to_mean.y + part.row_z * to_mean.z;
      const Real more = dot(to_angle, part.mean) - dot(to_error, cross(part.mean, part.momentum));
      to_half = select(is_active, to_half + more, to_half);
      to_spin = select(is_active, inertia_ * to_error - to_spin, to_spin);
      to_rotation = select(is_active, to_turned * conjugate(turn), to_rotation);
      q = select(is_active, before, q);
      w = select(is_active, (part.mean + part.mean) - w, w);
    }
    parts_.pull_back(inertia_, first_spin_, to_half, to_spin);
  }

  const SymMat3<Real>& inertia_;
  const Vec3<Real>& com_;
  Real time_;
  MaskOf<Real> mask_;
  Quat<Real> first_rotation_;
  Vec3<Real> first_spin_;
  TorqueFreeSubsteps<Real> parts_;
};

}  // namespace skybody
