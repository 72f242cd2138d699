#include "core/policy/network_evaluator.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/policy/network_layers.h"

namespace skybody {
namespace {

/// An agent with a whole row.
PolicyAgent all_of(const PolicyFile& policy) {
  PolicyAgent all;
  all.observation.resize(static_cast<std::size_t>(policy.observation_size));
  all.action.resize(static_cast<std::size_t>(policy.action_size));
  std::iota(all.observation.begin(), all.observation.end(), 0);
  std::iota(all.action.begin(), all.action.end(), 0);
  return all;
}

}  // namespace

NetworkEvaluator::NetworkEvaluator(PolicyFile policy) : policy_(std::move(policy)) {
  agents_ = policy_.agents.empty() ? std::vector{all_of(policy_)} : policy_.agents;
  for (const PolicyImage& image : policy_.images) image_features_.emplace_back(image);
  features_.resize(static_cast<std::size_t>(policy_.feature_size()));
  normalization_ = NormalizationWeights(policy_);
  int width = policy_.input_size() + policy_.feature_size();
  std::size_t sums = 0;
  for (const PolicyLayer& layer : policy_.layers) {
    width = std::max(width, layer.outputs);
    weights_.emplace_back(layer);
    if (!layer.is_recurrent()) continue;
    state_size_ += layer.state_size();
    sums = std::max(sums, 2 * layer.bias.size());
  }
  values_.resize(static_cast<std::size_t>(width));
  next_.resize(values_.size());
  sums_.resize(sums);
}

void NetworkEvaluator::see(std::span<const ImageView> images) {
  float* feature = features_.data();
  for (std::size_t k = 0; k < images.size(); ++k) {
    image_features_[k].evaluate(images[k].type, images[k].pixels, feature);
    feature += image_features_[k].features();
  }
}

/// From values_ to next_.
void NetworkEvaluator::evaluate(std::size_t index, float* state) {
  const PolicyLayer& layer = policy_.layers[index];
  const LayerWeights& w = weights_[index];
  if (layer.is_recurrent()) {
    const auto advance = layer.kind == LayerKind::kGru ? layer_gru : layer_lstm;
    advance(w.weight.data(), w.bias.data(), w.state_weight.data(), w.state_bias.data(),
            layer.inputs, layer.outputs, values_.data(), state, sums_.data());
    std::copy_n(state, layer.outputs, next_.data());
  } else {
    layer_dense(w.weight.data(), w.bias.data(), layer.inputs, layer.outputs,
                static_cast<int>(layer.activation), values_.data(), next_.data());
  }
}

std::span<const float> NetworkEvaluator::evaluate(const PolicyAgent& agent,
                                                  std::span<const float> observation,
                                                  float* states) {
  for (std::size_t k = 0; k < agent.observation.size(); ++k) {
    values_[k] = observation[static_cast<std::size_t>(agent.observation[k])];
  }
  const NormalizationWeights& n = normalization_;
  if (!n.mean.empty()) {
    layer_normalize(values_.data(), n.mean.data(), n.mean_rest.data(), n.scale.data(), n.clip,
                    static_cast<int>(n.mean.size()), values_.data());
  }
  std::copy(features_.begin(), features_.end(),
            values_.begin() + static_cast<std::ptrdiff_t>(agent.observation.size()));
  for (std::size_t k = 0; k < policy_.layers.size(); ++k) {
    evaluate(k, states);
    states += policy_.layers[k].state_size();
    values_.swap(next_);
  }
  const auto outputs = std::span(values_).first(agent.action.size());
  if (policy_.squash == ActionSquash::kTanh) {
    for (float& value : outputs) value = layer_tanh(value);
  }
  return outputs;
}

}  // namespace skybody
