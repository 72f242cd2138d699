// Evaluates the convolutions of a policy.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/env/column_type.h"
#include "core/io/files/policy_file.h"

namespace skybody {

/// The features of an image: the layers of a PolicyImage, in double. Sums run from left to right,
/// as in NetworkPolicy.
class ImageFeatures {
 public:
  explicit ImageFeatures(const PolicyImage& image);

  int features() const { return image_.features(); }
  /// Does not allocate.
  /// @param pixels    height x width x channels values of `type`
  /// @param features  features() values
  void evaluate(ColumnType type, const std::uint8_t* pixels, double* features);

 private:
  template <class T>
  void scale(const std::uint8_t* pixels);
  void convolve(const PolicyLayer& layer, const std::vector<double>& weight);

  PolicyImage image_;
  std::vector<std::vector<double>> weights_;  ///< of each layer, window_size() x outputs
  std::vector<double> values_, next_;         ///< between two layers, as large as the largest
};

}  // namespace skybody
