// Torque-free motion of one rigid body over a given time. On double, packs and dual numbers.
//
// The rotation uses the implicit midpoint rule for Euler's equations, and a matching rotation
// update (E. Hairer, C. Lubich, G. Wanner, "Geometric Numerical Integration", 2006, sections IV.2
// and VII.5). With w the spin in body axes, I the inertia, R the attitude and h one substep of the
// time:
//
//   I (w1 - w0) = -h' wm x (I wm),   wm = (w0 + w1) / 2
//   R1 = R0 Q,   Q the rotation of the quaternion (1, h'/2 wm)
//   h' = (2 / s) tan(s h / 2),   s = w.Iw / |Iw|
//
// It conserves the energy w.Iw / 2 and the angular momentum R I w (in W) exactly, for any h; s is
// constant, too. A steady rotation about a principal axis, where s is the spin, has the exact
// angle.
#pragma once

#include "core/base/math/dual.h"
#include "core/physics/bodies/kinematics.h"

namespace skybody {

/// Maximum angle per substep [rad]. The error of Newton's method, started at w0, is then (0.1)^15
/// after three iterations.
inline constexpr double kTorqueFreeAngle = 0.2;
/// Maximum number of substeps. Beyond 12.8 rad the body rotates for a shorter time: its phase,
/// which is meaningless at such steps, is lost; momentum and energy are not.
inline constexpr int kTorqueFreeParts = 64;

/// The implicit midpoint rule over one substep.
template <class Real>
struct MidpointSpin {
  Vec3<Real> mean, momentum;       ///< wm, I wm
  Vec3<Real> row_x, row_y, row_z;  ///< of the inverse of I + h'/2 d(w x I w)/dw

  /// @param start  w0; @param half  h'/2
  SKYBODY_INLINE MidpointSpin(const SymMat3<Real>& inertia, const Vec3<Real>& start,
                              const Real& half)
      : mean(start), momentum(inertia * start) {
    const Vec3<Real> before = momentum;
    constexpr int kNewtonSteps = 3;
#pragma GCC unroll 1
    for (int i = 0; i < kNewtonSteps; ++i) {
      invert(inertia, half);
      const Vec3<Real> error = (momentum - before) + cross(mean, momentum) * half;
      mean -= Vec3<Real>{dot(row_x, error), dot(row_y, error), dot(row_z, error)};
      momentum = inertia * mean;
    }
  }

  /// The body's rotation in the substep, of any norm.
  SKYBODY_INLINE Quat<Real> turn(const Real& half) const {
    return {Real(1.0), mean.x * half, mean.y * half, mean.z * half};
  }

  /// Inverts the residual's derivative at `mean`.
  SKYBODY_INLINE void invert(const SymMat3<Real>& i, const Real& half) {
    const Vec3<Real>&w = mean, &y = momentum;
    const Real zero(0.0);
    const Vec3<Real> a{i.xx, i.xy, i.xz}, b{i.xy, i.yy, i.yz}, c{i.xz, i.yz, i.zz};
    const Vec3<Real> x = a + (cross(w, a) - Vec3<Real>{zero, y.z, -y.y}) * half;
    const Vec3<Real> v = b + (cross(w, b) - Vec3<Real>{-y.z, zero, y.x}) * half;
    const Vec3<Real> z = c + (cross(w, c) - Vec3<Real>{y.y, -y.x, zero}) * half;
    row_x = cross(v, z);
    const Real scale = 1.0 / dot(x, row_x);
    row_x *= scale;
    row_y = cross(z, x) * scale;
    row_z = cross(x, v) * scale;
  }
};

/// Substeps of a time, and h'.
template <class Real>
struct TorqueFreeSubsteps {
  Real count;           ///< number of substeps
  Real half;            ///< h'/2 of each [s]
  Real half_of;         ///< h/2 of each [s]
  Real squared;         ///< s^2 [rad^2/s^2]
  MaskOf<Real> is_cut;  ///< the rotation exceeds the maximum number of substeps

  SKYBODY_INLINE TorqueFreeSubsteps(const SymMat3<Real>& inertia, const Vec3<Real>& spin,
                                    const Real& time) {
    const Vec3<Real> momentum = inertia * spin;
    const Real size = norm(spin) * abs(time);
    count = clamp(floor(size * (1.0 / kTorqueFreeAngle)) + 1.0, 1.0, double{kTorqueFreeParts});
    constexpr double kMostAngle = kTorqueFreeAngle * kTorqueFreeParts;
    is_cut = size > kMostAngle;
    half_of = time * (0.5 * select(is_cut, kMostAngle / size, Real(1.0))) / count;
    const Real share = dot(spin, momentum) / max(dot(momentum, momentum), 1e-300);
    squared = share * dot(spin, momentum);
    const Real x2 = squared * (half_of * half_of);
    half = half_of * (1.0 + x2 * (1.0 / 3 + x2 * (2.0 / 15 + x2 * (17.0 / 315))));
  }

  /// Reverse mode: adds the gradient through `half` to to_spin.
  SKYBODY_INLINE void pull_back(const SymMat3<Real>& inertia, const Vec3<Real>& spin,
                                const Real& to_half, Vec3<Real>& to_spin) const {
    const Vec3<Real> momentum = inertia * spin;
    const Real share = dot(spin, momentum) / max(dot(momentum, momentum), 1e-300);
    const Real square = half_of * half_of, x2 = squared * square;
    const Real slope = 1.0 / 3 + x2 * (4.0 / 15 + x2 * (17.0 / 105));
    const Real to_share = (to_half * half_of) * (square * slope) * share;
    to_spin += momentum * (4.0 * to_share) - (inertia * momentum) * (2.0 * share * to_share);
    if (none(is_cut)) return;
    const Real to_time = to_half * (half + half_of * (2.0 * x2 * slope)) / dot(spin, spin);
    to_spin -= spin * select(is_cut, to_time, Real(0.0));
  }
};

/// A body in free motion. Refers to its arguments.
template <class Real>
struct TorqueFreeCall {
  const SymMat3<Real>& inertia;  ///< about the centre of mass, body axes
  const Vec3<Real>& com;         ///< from the origin, body axes
  const Real& time;              ///< [s]
  const MaskOf<Real>& mask;      ///< lanes that move; others stay unchanged
  Vec3<Real>& position;          ///< of the origin
  Quat<Real>& rotation;          ///< W from B, unit
  Vec3<Real>& velocity;          ///< of the origin, W axes
  Vec3<Real>& spin;              ///< body axes

  /// The centre of mass keeps its velocity; the body rotates about it.
  SKYBODY_INLINE void run() const {
    const Vec3<Real> arm = rotate(rotation, com);
    const Vec3<Real> com_velocity = velocity + rotate(rotation, cross(spin, com));
    turn();
    const Vec3<Real> moved = (position + com_velocity * time) + (arm - rotate(rotation, com));
    position = select(mask, moved, position);
    velocity = select(mask, com_velocity - rotate(rotation, cross(spin, com)), velocity);
  }

 private:
  SKYBODY_INLINE void turn() const {
    const TorqueFreeSubsteps<Real> parts(inertia, spin, time);
#pragma GCC unroll 1
    for (int p = 0; p < kTorqueFreeParts; ++p) {
      const auto is_active = logical_and(mask, parts.count > static_cast<double>(p));
      if (none(is_active)) break;
      const MidpointSpin<Real> part(inertia, spin, parts.half);
      rotation = select(is_active, normalized(rotation * part.turn(parts.half)), rotation);
      spin = select(is_active, (part.mean + part.mean) - spin, spin);
    }
  }
};

/// Runs a call with the number type of the width.
using TorqueFreeFunction = void(const void* call);

/// @param lanes  1: doubles; otherwise packs
TorqueFreeFunction* torque_free_function(int lanes);

/// Calls a function that all kernels share; dual numbers run inline.
template <class Real>
SKYBODY_INLINE void move_freely(const TorqueFreeCall<Real>& call) {
  if constexpr (kIsDual<Real>) {
    call.run();
  } else {
    torque_free_function(kLanesOf<Real>)(&call);
  }
}

}  // namespace skybody
