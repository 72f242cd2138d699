// Transformations of COLLADA's nodes. Internal to core/io.
#pragma once

#include "core/base/math/mat3.h"
#include "core/io/urdf/mesh_dae_document.h"

namespace skybody {

/// x -> linear x + shift.
struct DaeTransform {
  Mat3<double> linear = Mat3<double>::identity();
  Vec3<double> shift{0.0, 0.0, 0.0};

  friend Vec3<double> operator*(const DaeTransform& a, const Vec3<double>& v) {
    return a.linear * v + a.shift;
  }
  /// Applies b first, then a.
  friend DaeTransform operator*(const DaeTransform& a, const DaeTransform& b) {
    return {a.linear * b.linear, a * b.shift};
  }
};

/// The transformation of <matrix>, <rotate>, <translate>, <scale> or <lookat>; identity for other
/// elements.
/// @throws MeshError  also for <skew>
DaeTransform read_dae_transform(const tinyxml2::XMLElement& element);

}  // namespace skybody
