#include "core/policy/layer_weights.h"

#include <cstddef>

namespace skybody {
namespace {

std::vector<float> floats_of(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

}  // namespace

std::vector<float> pack_panels(const std::vector<double>& rows, int outputs, int inputs) {
  std::vector<float> panels;
  panels.reserve(rows.size());
  int first = 0;
  for (const int width : {16, 4, 1}) {
    for (; outputs - first >= width; first += width) {
      for (int k = 0; k < inputs; ++k) {
        for (int o = first; o < first + width; ++o) {
          const auto at = static_cast<std::size_t>(o) * static_cast<std::size_t>(inputs);
          panels.push_back(static_cast<float>(rows[at + static_cast<std::size_t>(k)]));
        }
      }
    }
  }
  return panels;
}

LayerWeights::LayerWeights(const PolicyLayer& layer)
    : weight(pack_panels(layer.weight, layer.weight_rows(), layer.inputs)),
      bias(floats_of(layer.bias)),
      state_bias(floats_of(layer.state_bias)) {
  if (!layer.is_recurrent()) return;
  state_weight = pack_panels(layer.state_weight, layer.weight_rows(), layer.outputs);
}

NormalizationWeights::NormalizationWeights(const PolicyFile& policy)
    : mean(floats_of(policy.mean)),
      scale(floats_of(policy.scale)),
      clip(static_cast<float>(policy.clip)) {
  for (std::size_t k = 0; k < mean.size(); ++k) {
    mean_rest.push_back(static_cast<float>(policy.mean[k] - static_cast<double>(mean[k])));
  }
}

}  // namespace skybody
