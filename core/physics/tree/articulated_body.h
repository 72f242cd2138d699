// Accelerations of a tree of rigid bodies by the articulated-body algorithm, on double and packs:
// R. Featherstone, Rigid Body Dynamics Algorithms, 2008, section 7.3.
//
// All vectors are in W axes. Spatial quantities of a body are about the origin O of its own frame,
// as SpatialForce is. The acceleration `linear` is that of the point O (not Featherstone's spatial
// acceleration). Gravity, the state's velocities and Simbody's body forces therefore need no
// conversion. For one body with mass m, centre of mass c from O and inertia I about O
//   moment = I alpha + m c x a + w x (I w)
//   force  = m a - m c x alpha + m w x (w x c)
#pragma once

#include "core/base/math/mat3.h"
#include "core/physics/bodies/kinematics.h"
#include "core/physics/bodies/spatial_force.h"

namespace skybody {

/// Acceleration of a body and of its frame's origin, W axes.
template <class Real>
struct SpatialAcceleration {
  Vec3<Real> angular;  ///< [rad/s^2]
  Vec3<Real> linear;   ///< [m/s^2]
};

/// Maps accelerations to forces: moment = angular alpha + coupling a, force = coupling^T alpha +
/// linear a.
template <class Real>
struct ArticulatedInertia {
  SymMat3<Real> angular;
  Mat3<Real> coupling;
  SymMat3<Real> linear;

  SKYBODY_INLINE SpatialForce<Real> operator*(const SpatialAcceleration<Real>& a) const {
    return {angular * a.angular + coupling * a.linear,
            transpose_times(coupling, a.angular) + linear * a.linear};
  }
};

/// Inertia of one rigid body.
/// @param com      centre of mass from O, W axes [m]
/// @param inertia  about the centre of mass, W axes [kg m^2]
template <class Real>
SKYBODY_INLINE ArticulatedInertia<Real> rigid_inertia(const Real& mass, const Vec3<Real>& com,
                                                      const SymMat3<Real>& inertia) {
  const Real zero(0.0);
  return {
      inertia + point_inertia(mass, com), skew(com * mass), {mass, mass, mass, zero, zero, zero}};
}

/// Velocity-dependent force of a body: the force that its rotation needs besides its accelerations.
template <class Real>
SKYBODY_INLINE SpatialForce<Real> velocity_force(const Real& mass, const Vec3<Real>& com,
                                                 const SymMat3<Real>& angular,
                                                 const Vec3<Real>& w) {
  return {cross(w, angular * w), cross(w, cross(w, com)) * mass};
}

/// The inertia about a point that moves with the body: O = point + arm.
template <class Real>
SKYBODY_INLINE ArticulatedInertia<Real> shifted(const ArticulatedInertia<Real>& i,
                                                const Vec3<Real>& arm) {
  // With r = skew(arm): r L, and the rows of G r, (r L) r. r G^T = -(G r)^T, since r is skew.
  const Mat3<Real> linear = to_mat3(i.linear);
  const Vec3<Real> x = cross(arm, linear.column(0)), y = cross(arm, linear.column(1)),
                   z = cross(arm, linear.column(2));
  const Mat3<Real> r_linear{{x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z}};
  const Vec3<Real> g0 = cross(i.coupling.row(0), arm), g1 = cross(i.coupling.row(1), arm),
                   g2 = cross(i.coupling.row(2), arm);
  const Vec3<Real> l0 = cross(r_linear.row(0), arm), l1 = cross(r_linear.row(1), arm),
                   l2 = cross(r_linear.row(2), arm);
  const SymMat3<Real> angular{(g0.x + g0.x) + l0.x, (g1.y + g1.y) + l1.y, (g2.z + g2.z) + l2.z,
                              (g0.y + g1.x) + l0.y, (g0.z + g2.x) + l0.z, (g1.z + g2.y) + l1.z};
  return {i.angular - angular, i.coupling + r_linear, i.linear};
}

template <class Real>
SKYBODY_INLINE SpatialForce<Real> shifted(const SpatialForce<Real>& f, const Vec3<Real>& arm) {
  return {f.moment + cross(arm, f.force), f.force};
}

/// Results of one body's elimination, kept for the pass from the base to the leaves.
template <class Real>
struct ArticulatedBodyCache {
  ArticulatedInertia<Real> inertia;  ///< of the body and its subtree
  SpatialForce<Real> bias;           ///< force needed at zero acceleration
  SpatialAcceleration<Real> drift;   ///< acceleration at O with zero udot and a parent at rest
  Vec3<Real> arm;                    ///< from the parent's O to this one
  SpatialAcceleration<Real> column[6];
  SpatialForce<Real> reduced[6];  ///< rows of L^-1 (inertia S)^T
  Real residual[6];               ///< L^-1 (tau - S^T bias)
  Real inverse_pivot[6];
  Real lower[6][6];  ///< L, unit lower triangle
};

/// Columns of S, drift and arm of one joint.
/// @param parent  null where the joint's frame F is fixed to W
/// @param frame   F's axes in W; @param joint M's motion in it; @param body the body's
template <class Real>
SKYBODY_INLINE void open_joint(const TreeBody& tree, const BodyKinematics<Real>* parent,
                               const Mat3<Real>& frame, const JointMotion<Real>& joint,
                               const BodyKinematics<Real>& body, const Real* u,
                               ArticulatedBodyCache<Real>& work) {
  const Real none(0.0);
  const Vec3<Real> zero{none, none, none};
  Mat3<Real> m_axes = body.axes;
  Vec3<Real> lever = zero;  // from M's origin to O
  if (!tree.plain_body) {
    m_axes = body.axes * to_mat3(to_real<Real>(tree.frame_in_body.rotation));
    lever = -(body.axes * to_real<Real>(tree.frame_in_body.position));
  }
  const auto turning = [&](const Vec3<Real>& axis) {
    return SpatialAcceleration<Real>{axis, tree.plain_body ? zero : cross(axis, lever)};
  };
  Vec3<Real> spin_drift = zero;
  switch (tree.type) {
    case JointType::kWeld:
      break;
    case JointType::kFree:
      for (int k = 0; k < 3; ++k) work.column[k] = {zero, frame.column(k)};
      for (int k = 0; k < 3; ++k) work.column[3 + k] = turning(m_axes.column(k));
      break;
    case JointType::kPin:
      work.column[0] = turning(m_axes.column(2));
      break;
    case JointType::kSlider:
      work.column[0] = {zero, frame.column(0)};
      break;
    case JointType::kUniversal:
      work.column[0] = turning(frame.column(0));
      work.column[1] = turning(m_axes.column(1));
      spin_drift = cross(frame.column(0), m_axes.column(1)) * (u[0] * u[1]);
      break;
    case JointType::kBall:
      break;  // ball_joint.h
  }
  work.arm = body.position;
  work.drift = {spin_drift, zero};
  if (parent != nullptr) {
    const Vec3<Real>& w = parent->angular_velocity;
    work.arm = body.position - parent->position;
    work.drift.angular += cross(w, body.angular_velocity - w);
    work.drift.linear =
        cross(w, cross(w, work.arm - lever)) + 2.0 * cross(w, frame * joint.velocity);
  }
  if (!tree.plain_body) {
    const Vec3<Real>& w = body.angular_velocity;
    work.drift.linear += cross(work.drift.angular, lever) + cross(w, cross(w, lever));
  }
}

/// The effect of a joint's coordinates on its body.
template <int N, bool kTurns>
struct JointColumns {
  static constexpr int kCount = N;
  /// Rotations about axes through O: the columns have no linear part.
  static constexpr bool kTurnsAboutOrigin = kTurns;

  template <class Real>
  static SKYBODY_INLINE SpatialForce<Real> force(const ArticulatedInertia<Real>& inertia,
                                                 const SpatialAcceleration<Real>& column) {
    if constexpr (!kTurns) return inertia * column;
    return {inertia.angular * column.angular, transpose_times(inertia.coupling, column.angular)};
  }
  template <class Real>
  static SKYBODY_INLINE Real power(const SpatialAcceleration<Real>& column,
                                   const SpatialForce<Real>& f) {
    if constexpr (kTurns) return dot(column.angular, f.moment);
    return dot(column.angular, f.moment) + dot(column.linear, f.force);
  }
};

/// Eliminates a joint's coordinates from the inertia of its body.
/// @param own  inertias of the coordinates themselves, one each; null: none
template <class Columns, class Real>
SKYBODY_INLINE void eliminate(const Real* own, ArticulatedBodyCache<Real>& work) {
  for (int k = 0; k < Columns::kCount; ++k) {
    SpatialForce<Real> row = Columns::force(work.inertia, work.column[k]);
    Real pivot = Columns::power(work.column[k], row);
    if (own != nullptr) pivot += own[k];
    for (int j = 0; j < k; ++j) {
      // L D: element (k, j) before it is divided by the pivot.
      const Real scaled = Columns::power(work.column[k], work.reduced[j]);
      const Real l = scaled * work.inverse_pivot[j];
      work.lower[k][j] = l;
      row.moment -= work.reduced[j].moment * l;
      row.force -= work.reduced[j].force * l;
      pivot -= l * scaled;
    }
    work.reduced[k] = row;
    work.inverse_pivot[k] = 1.0 / pivot;
  }
}

/// Eliminates a joint's coordinates from the forces on its body.
template <class Columns, class Real>
SKYBODY_INLINE void leave_residual(const Real* joint_force, ArticulatedBodyCache<Real>& work) {
  for (int k = 0; k < Columns::kCount; ++k) {
    Real residual = joint_force[k] - Columns::power(work.column[k], work.bias);
    for (int j = 0; j < k; ++j) residual -= work.lower[k][j] * work.residual[j];
    work.residual[k] = residual;
  }
}

/// Acceleration of a floating body from its articulated inertia and force. Eliminates the linear
/// part first.
template <class Real>
SKYBODY_INLINE SpatialAcceleration<Real> free_acceleration(const ArticulatedInertia<Real>& inertia,
                                                           const SpatialForce<Real>& force) {
  const Ldl3<Real> linear(inertia.linear);
  const Mat3<Real>& c = inertia.coupling;
  // Rows of C L^-1.
  const Vec3<Real> k0 = linear.solve(c.row(0)), k1 = linear.solve(c.row(1)),
                   k2 = linear.solve(c.row(2));
  const SymMat3<Real> through{dot(k0, c.row(0)), dot(k1, c.row(1)), dot(k2, c.row(2)),
                              dot(k0, c.row(1)), dot(k0, c.row(2)), dot(k1, c.row(2))};
  const Vec3<Real> moment =
      force.moment - Vec3<Real>{dot(k0, force.force), dot(k1, force.force), dot(k2, force.force)};
  const Vec3<Real> angular = Ldl3<Real>(inertia.angular - through).solve(moment);
  return {angular, linear.solve(force.force - transpose_times(c, angular))};
}

/// Adds the part of the forces that the joint's coordinates transmit.
template <class Columns, class Real>
SKYBODY_INLINE void pass_on(const ArticulatedBodyCache<Real>& work, SpatialForce<Real>& bias) {
  for (int k = 0; k < Columns::kCount; ++k) {
    const Real rate = work.residual[k] * work.inverse_pivot[k];
    bias.moment += work.reduced[k].moment * rate;
    bias.force += work.reduced[k].force * rate;
  }
}

/// inertia and bias as transmitted through the joint.
template <class Columns, class Real>
SKYBODY_INLINE void reduce(const ArticulatedBodyCache<Real>& work,
                           ArticulatedInertia<Real>& inertia, SpatialForce<Real>& bias) {
  inertia = work.inertia;
  for (int k = 0; k < Columns::kCount; ++k) {
    const Vec3<Real>&m = work.reduced[k].moment, &f = work.reduced[k].force;
    const Vec3<Real> dm = m * work.inverse_pivot[k], df = f * work.inverse_pivot[k];
    inertia.angular = inertia.angular - SymMat3<Real>{m.x * dm.x, m.y * dm.y, m.z * dm.z,
                                                      m.x * dm.y, m.x * dm.z, m.y * dm.z};
    inertia.linear = inertia.linear - SymMat3<Real>{f.x * df.x, f.y * df.y, f.z * df.z,
                                                    f.x * df.y, f.x * df.z, f.y * df.z};
    inertia.coupling =
        inertia.coupling - Mat3<Real>{{m.x * df.x, m.x * df.y, m.x * df.z, m.y * df.x, m.y * df.y,
                                       m.y * df.z, m.z * df.x, m.z * df.y, m.z * df.z}};
  }
  const SpatialForce<Real> drifting = inertia * work.drift;
  bias = {work.bias.moment + drifting.moment, work.bias.force + drifting.force};
  pass_on<Columns>(work, bias);
}

/// udot of a joint. `a` is the body's acceleration for udot = 0; the contribution of udot is added
/// to it.
template <class Columns, class Real>
SKYBODY_INLINE void substitute(const ArticulatedBodyCache<Real>& work, SpatialAcceleration<Real>& a,
                               Real* udot) {
  for (int k = 0; k < Columns::kCount; ++k) {
    const SpatialForce<Real>& row = work.reduced[k];
    const Real carried = dot(a.angular, row.moment) + dot(a.linear, row.force);
    udot[k] = (work.residual[k] - carried) * work.inverse_pivot[k];
  }
  for (int k = Columns::kCount - 2; k >= 0; --k) {
    for (int j = k + 1; j < Columns::kCount; ++j) udot[k] -= work.lower[j][k] * udot[j];
  }
  for (int k = 0; k < Columns::kCount; ++k) {
    a.angular += work.column[k].angular * udot[k];
    if constexpr (!Columns::kTurnsAboutOrigin) a.linear += work.column[k].linear * udot[k];
  }
}

}  // namespace skybody
