// Triangles of a mesh, laid out for the kernels.
#pragma once

#include <span>
#include <vector>

#include "core/base/math/vec3.h"

namespace skybody::render {

/// Immutable; shapes of many environments share it.
class Mesh {
 public:
  /// @param corners  nine numbers per triangle: x, y, z of each corner [m]
  /// @param scale    factors of x, y, z
  /// @param texture  six numbers per triangle: u to the right and v up of each corner; or none
  Mesh(std::span<const float> corners, const Vec3<double>& scale,
       std::span<const float> texture = {});

  int count() const { return count_; }  ///< number of triangles
  /// Coordinate k (0 ... 8: x, y, z of each corner) of all triangles, up to whole packs; triangles
  /// beyond the last one have no extent.
  const float* coordinate(int k) const {
    return corners_.data() + static_cast<std::size_t>(k) * stride_;
  }
  /// kTexturePoints numbers per triangle; null: none.
  const float* texture() const { return texture_.empty() ? nullptr : texture_.data(); }
  /// The box about it, in its frame [m].
  const Vec3<double>& center() const { return center_; }
  const Vec3<double>& half() const { return half_; }

 private:
  void set_texture(std::span<const float> points);

  int count_;
  std::size_t stride_;
  std::vector<float> corners_, texture_;
  Vec3<double> center_, half_;
};

}  // namespace skybody::render
