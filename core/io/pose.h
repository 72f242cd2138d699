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

/// The point with coordinates `point` in B, seen from A.
inline Vec3<double> transform(const Pose& ab, const Vec3<double>& point) {
  return ab.position + rotate(ab.rotation, point);
}

/// Mass properties given in B, in A.
inline MassProperties transform(const Pose& ab, const MassProperties& mass) {
  return {mass.mass, transform(ab, mass.com), rotate_inertia(to_mat3(ab.rotation), mass.inertia)};
}

}  // namespace skybody
