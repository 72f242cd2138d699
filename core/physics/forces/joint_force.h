// Forces along a joint's own coordinates: viscous damping on all of them, a spring and travel
// limits on pins and sliders.
#pragma once

#include "core/base/math.h"
#include "core/model/robot_model.h"

namespace skybody {

/// Beyond `lower` or `upper` a spring pushes back and a damper acts, but they never pull inwards.
/// @param q, u  the coordinate [rad] or [m] and its rate
template <class Real>
SKYBODY_INLINE Real limit_force(const JointLimit& limit, const Real& q, const Real& u) {
  const Real zero(0.0);
  const Real below = limit.lower - q, above = q - limit.upper;
  const Real push_up = limit.stiffness * below - limit.damping * u;
  const Real push_down = limit.stiffness * above + limit.damping * u;
  const Real at_lower = select(below > zero, max(push_up, zero), zero);
  const Real at_upper = select(above > zero, max(push_down, zero), zero);
  return at_lower - at_upper;
}

/// Generalised forces of one joint, one per u [N m] or [N]; conjugate to u as JointType defines it.
template <class Real>
SKYBODY_INLINE void joint_force(const Joint& joint, const Real* q, const Real* u, Real* force) {
  for (int i = 0; i < velocity_size(joint.type); ++i) force[i] = -(joint.damping * u[i]);
  if (joint.type != JointType::kPin && joint.type != JointType::kSlider) return;
  force[0] -= joint.stiffness * (q[0] - joint.rest);
  if (joint.limit.enabled) force[0] += limit_force(joint.limit, q[0], u[0]);
}

}  // namespace skybody
