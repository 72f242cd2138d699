// Composition of rigid transforms.
#pragma once

#include "core/model/robot_model.h"

namespace skybody {

/// X_AC from X_AB and X_BC.
inline Pose compose(const Pose& ab, const Pose& bc) {
  return {ab.position + rotate(ab.rotation, bc.position), ab.rotation * bc.rotation};
}

/// X_BA from X_AB.
inline Pose inverse(const Pose& ab) {
  const Quat<double> rotation = conjugate(ab.rotation);
  return {-rotate(rotation, ab.position), rotation};
}

/// Whether the transform is exactly the identity.
inline bool is_identity(const Pose& pose) {
  const Vec3<double>& p = pose.position;
  const Quat<double>& r = pose.rotation;
  return p.x == 0.0 && p.y == 0.0 && p.z == 0.0 && r.w == 1.0 && r.x == 0.0 && r.y == 0.0 &&
         r.z == 0.0;
}

/// The coordinates in A of a point given in B.
inline Vec3<double> transform(const Pose& ab, const Vec3<double>& point) {
  return ab.position + rotate(ab.rotation, point);
}

/// Mass properties in A, given those in B.
inline MassProperties transform(const Pose& ab, const MassProperties& mass) {
  return {mass.mass, transform(ab, mass.com), rotate_inertia(to_mat3(ab.rotation), mass.inertia)};
}

}  // namespace skybody
