// The images of a slice's rollout, as bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "core/batch/pool.h"
#include "learn/network/image_rows.h"
#include "learn/ppo/ppo_setup.h"

namespace skybody::learn {

/// Images in the types of their columns. They become floats only for the rows of one pass through a
/// network. Without images all functions do nothing.
class RolloutImages {
 public:
  /// @param rows  of the rollout, with the last observations
  RolloutImages(const PpoSetup& setup, int envs, std::size_t rows);

  /// The current images: the pool's, or a batch's, which must outlive the use.
  void look_at(const Pool& pool);
  void look_at(const Batch& batch);
  /// Copies the current images to a step's rows, from `first` on.
  void write(std::size_t first);
  /// Copies the last image of an environment's ended episode to place `place`.
  void keep_last(const Batch& batch, int env, std::size_t place);

  /// Rows first, first + 1, ...
  ImageRows rows(std::size_t first) const { return {images_.data(), first, nullptr}; }
  /// Rows order[0], order[1], ...
  ImageRows rows(const int* order) const { return {images_.data(), 0, order}; }
  /// Places first, first + 1, ... of keep_last().
  ImageRows last(std::size_t first) const { return {last_.data(), first, nullptr}; }

 private:
  std::size_t envs_;
  std::vector<std::size_t> bytes_;  ///< of each image
  std::vector<AlignedArray<std::uint8_t>> images_, last_, own_;
  std::vector<const std::uint8_t*> current_;
};

}  // namespace skybody::learn
