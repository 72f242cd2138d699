// Weights of a policy's layers as network_layers.h reads them.
#pragma once

#include <vector>

#include "core/io/files/policy_file.h"

namespace skybody {

/// A matrix of outputs x inputs, given row by row, as panels of floats (network_layers.h).
std::vector<float> pack_panels(const std::vector<double>& rows, int outputs, int inputs);

/// The numbers of a layer.
struct LayerWeights {
  explicit LayerWeights(const PolicyLayer& layer);

  std::vector<float> weight, bias;
  std::vector<float> state_weight, state_bias;  ///< of a recurrent layer; else empty
};

/// The numbers of a policy's normalization; empty without one.
struct NormalizationWeights {
  NormalizationWeights() = default;
  explicit NormalizationWeights(const PolicyFile& policy);

  std::vector<float> mean, mean_rest;  ///< their sums are the means
  std::vector<float> scale;
  float clip = 0.0f;
};

}  // namespace skybody
