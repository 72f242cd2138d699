#include "render/mesh.h"

#include <algorithm>
#include <cmath>

#include "render/kernels/kernel_table.h"

namespace skybody::render {

Mesh::Mesh(std::span<const float> corners, const Vec3<double>& scale)
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
}

}  // namespace skybody::render
