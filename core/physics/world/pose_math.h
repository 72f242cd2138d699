// Arithmetic of rigid transforms.
#pragma once

#include "core/base/math/quat.h"
#include "core/model/robot_model.h"

namespace skybody {

/// X_AC from X_AB and X_BC.
inline Pose compose(const Pose& ab, const Pose& bc) {
  return {ab.position + rotate(ab.rotation, bc.position), ab.rotation * bc.rotation};
}

/// Whether the axes coincide to the last bit.
inline bool is_identity(const Quat<double>& r) {
  return r.w == 1.0 && r.x == 0.0 && r.y == 0.0 && r.z == 0.0;
}

/// Whether the frames coincide to the last bit.
inline bool is_identity(const Pose& pose) {
  const Vec3<double>& p = pose.position;
  return p.x == 0.0 && p.y == 0.0 && p.z == 0.0 && is_identity(pose.rotation);
}

}  // namespace skybody
