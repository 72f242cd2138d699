// Forces along a joint's own coordinates: viscous damping on all joints, a spring on pins and
// sliders, and the law of the latters' stops, which step/joint_stops.h applies.
#pragma once

#include "core/base/math/math.h"
#include "core/model/robot_model.h"

namespace skybody {

/// Whether a joint has travel limits with a spring and a damper beyond them.
inline bool has_stops(const Joint& joint) {
  const bool has_one_coordinate = joint.type == JointType::kPin || joint.type == JointType::kSlider;
  return has_one_coordinate && joint.limit.enabled;
}

/// Spring and damper force beyond `lower` or `upper`. It never points out of the range.
/// @param constants  the joint's, a pointer or a view
/// @param q, u       the coordinate [rad] or [m] and its rate
template <class Real, class Constants>
SKYBODY_INLINE Real limit_force(const JointLimit& limit, const Constants& constants, const Real& q,
                                const Real& u) {
  const Real zero(0.0);
  const Real stiffness = constants[kLimitStiffness], damping = constants[kLimitDamping];
  const Real below = limit.lower - q, above = q - limit.upper;
  const Real push_up = stiffness * below - damping * u;
  const Real push_down = stiffness * above + damping * u;
  const Real at_lower = select(below > zero, max(push_up, zero), zero);
  const Real at_upper = select(above > zero, max(push_down, zero), zero);
  return at_lower - at_upper;
}

/// Generalised forces of one joint without its stops, one per u [N m] or [N]; conjugate to u as
/// defined by JointType. Constants of 0 give exactly +0.
/// @param constants  its joint_constant_count() values, at least one
template <class Real, class Constants>
SKYBODY_INLINE void joint_force(const Joint& joint, const Constants& constants, const Real* q,
                                const Real* u, Real* force) {
  const Real damping = constants[kJointDamping];
  for (int i = 0; i < velocity_size(joint.type); ++i) force[i] = 0.0 - damping * u[i];
  if (joint.type != JointType::kPin && joint.type != JointType::kSlider) return;
  force[0] -= constants[kJointStiffness] * (q[0] - constants[kJointRest]);
}

}  // namespace skybody
