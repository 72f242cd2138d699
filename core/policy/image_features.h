// Evaluates the convolutions of a policy.
#pragma once

#include <cstdint>
#include <vector>

#include "core/env/column_type.h"
#include "core/io/files/policy_file.h"
#include "core/policy/layer_weights.h"

namespace skybody {

/// The features of an image: the layers of a PolicyImage, evaluated by network_layers.h.
class ImageFeatures {
 public:
  explicit ImageFeatures(const PolicyImage& image);

  int features() const { return image_.features(); }
  /// Does not allocate.
  /// @param pixels    height x width x channels values of `type`
  /// @param features  features() values
  void evaluate(ColumnType type, const std::uint8_t* pixels, float* features);

 private:
  template <class T>
  void scale(const std::uint8_t* pixels);

  PolicyImage image_;
  std::vector<LayerWeights> weights_;
  std::vector<float> values_, next_;  ///< between two layers, as large as the largest
};

}  // namespace skybody
