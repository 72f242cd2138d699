#include "render/mesh.h"

#include <algorithm>
#include <cmath>

#include "render/kernels/kernel_table.h"

namespace skybody::render {

Mesh::Mesh(std::span<const float> corners, const Vec3<double>& scale,
           std::span<const float> texture)
    : count_(static_cast<int>(corners.size() / 9)),
      stride_((static_cast<std::size_t>(count_) + kMostLanes - 1) / kMostLanes * kMostLanes),
      corners_(9 * stride_) {
  const double factor[3] = {scale.x, scale.y, scale.z};
  double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
    for (std::size_t k = 0; k < 9; ++k) {
      const double value = factor[k % 3] * static_cast<double>(corners[9 * i + k]);
      corners_[k * stride_ + i] = static_cast<float>(value);
      low[k % 3] = std::min(low[k % 3], value);
      high[k % 3] = std::max(high[k % 3], value);
    }
  }
  center_ = {0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])};
  half_ = {0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1]), 0.5 * (high[2] - low[2])};
  if (texture.size() == 6 * static_cast<std::size_t>(count_)) set_texture(texture);
}

/// With the change of the points by a metre, as the root of the ratio of areas.
void Mesh::set_texture(std::span<const float> points) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
    const auto corner = [&](std::size_t k) {
      const auto at = [&](std::size_t axis) {
        return static_cast<double>(corners_[(3 * k + axis) * stride_ + i]);
      };
      return Vec3<double>{at(0), at(1), at(2)};
    };
    const auto point = [&](std::size_t k) {
      return Vec3<double>{points[6 * i + 2 * k], points[6 * i + 2 * k + 1], 0.0};
    };
    const double area = norm(cross(corner(1) - corner(0), corner(2) - corner(0)));
    const double covered = norm(cross(point(1) - point(0), point(2) - point(0)));
    for (std::size_t k = 0; k < 6; ++k) texture_.push_back(points[6 * i + k]);
    texture_.push_back(static_cast<float>(std::sqrt(covered / std::max(area, 1e-30))));
  }
}

}  // namespace skybody::render
