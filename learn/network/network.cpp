#include "learn/network/network.h"

#include <algorithm>
#include <string>

#include "core/base/system/error.h"
#include "learn/network/epilogues.h"
#include "learn/network/growing_array.h"
#include "learn/network/initial_weights.h"
#include "learn/network/kernels/kernels.h"

namespace skybody::learn {
namespace {

constexpr int kMostUnits = 1 << 24;  // as in a policy file
constexpr double kHiddenGain = 1.4142135623730951;

// Rows per chunk that goes through all layers: few enough to keep a layer's values in half of a
// small L2 cache, and enough to reuse each loaded weight often.
constexpr int kChunkValues = 1 << 16, kLeastChunk = 48, kMostChunk = 192;

/// Rows of outputs at a distance of a multiple of 2048 bytes would compete for the same few sets of
/// the L1 cache.
int row_stride(int padded) { return padded % 512 == 0 ? padded + kPad : padded; }

std::size_t area(int rows, int stride) {
  return static_cast<std::size_t>(rows) * static_cast<std::size_t>(stride);
}

void copy_rows(const float* from, int from_stride, int rows, int width, float* to, int to_stride) {
  for (std::ptrdiff_t r = 0; r < rows; ++r) {
    std::copy_n(from + r * from_stride, width, to + r * to_stride);
  }
}

}  // namespace

Network::Network(const NetworkShape& shape, Isa isa) : shape_(shape), kernels_(&kernels_of(isa)) {
  if (shape.activation == Activation::kNone && !shape.hidden.empty()) {
    throw Error("a network's hidden layers have the activation `none`; allowed: tanh, relu, elu");
  }
  int inputs = shape.inputs;
  for (const int units : shape.hidden) {
    add_layer(inputs, units, shape.activation);
    inputs = units;
  }
  add_layer(inputs, shape.outputs, Activation::kNone);
  chunk_ =
      std::clamp(kChunkValues / std::max(widest_stride(), shape.inputs), kLeastChunk, kMostChunk);
}

void Network::add_layer(int inputs, int outputs, Activation activation) {
  for (const int size : {inputs, outputs}) {
    if (size < 1 || size > kMostUnits) {
      throw Error("a layer of a network is " + std::to_string(inputs) + " x " +
                  std::to_string(outputs) + "; allowed: 1.." + std::to_string(kMostUnits) +
                  " inputs and outputs");
    }
  }
  Layer layer;
  layer.weight = {inputs, outputs};
  layer.weight_at = parameter_count_;
  layer.bias_at = layer.weight_at + layer.weight.size();
  layer.stride = row_stride(layer.weight.padded_columns());
  layer.activation = activation;
  parameter_count_ = layer.bias_at + static_cast<std::size_t>(layer.weight.padded_columns());
  layers_.push_back(layer);
}

int Network::widest_stride() const {
  int widest = 0;
  for (const Layer& layer : layers_) widest = std::max(widest, layer.stride);
  return widest;
}

void Network::initialize(std::span<float> parameters, double last_gain, std::uint64_t key,
                         std::uint64_t stream) const {
  std::fill_n(parameters.begin(), parameter_count_, 0.0f);
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    const PanelMatrix& weight = layers_[k].weight;
    const double gain = k + 1 == layers_.size() ? last_gain : kHiddenGain;
    const std::vector<double> values =
        orthogonal_matrix(weight.rows, weight.columns, {key, stream, k});
    float* to = parameters.data() + layers_[k].weight_at;
    for (int i = 0; i < weight.rows; ++i) {
      for (int o = 0; o < weight.columns; ++o) {
        const std::size_t from = static_cast<std::size_t>(i) * weight.columns + o;
        to[weight.at(i, o)] = static_cast<float>(gain * values[from]);
      }
    }
  }
}

void Network::transpose(std::span<const float> parameters, TransposedWeights& transposed) const {
  transposed.layers.resize(layers_.size());
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    const PanelMatrix& weight = layers_[k].weight;
    make_large_enough(transposed.layers[k], weight.transposed().size());
    learn::transpose(weight, parameters.data() + layers_[k].weight_at, transposed.layers[k].data());
  }
}

Network::Rows Network::input_of(std::size_t layer, const Rows& x,
                                const NetworkActivations& memory) const {
  if (layer == 0) return x;
  return {memory.outputs[layer - 1].data(), layers_[layer - 1].stride};
}

void Network::forward(std::span<const float> parameters, const float* x, int x_stride, int rows,
                      NetworkActivations& memory, float* y, int y_stride) const {
  memory.rows = rows;
  memory.outputs.resize(layers_.size());
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    make_large_enough(memory.outputs[k], area(rows, layers_[k].stride));
  }
  for (int first = 0; first < rows; first += chunk_) {
    forward_rows(parameters, {x, x_stride}, first, std::min(chunk_, rows - first), memory);
  }
  copy_rows(memory.outputs.back().data(), layers_.back().stride, rows, shape_.outputs, y, y_stride);
}

void Network::forward_rows(std::span<const float> parameters, const Rows& x, int first, int rows,
                           NetworkActivations& memory) const {
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    const Layer& layer = layers_[k];
    const Rows input = input_of(k, x, memory);
    const std::ptrdiff_t row = first;
    kernels_->multiply({
        .x = input.data + row * input.stride,
        .x_stride = input.stride,
        .rows = rows,
        .inner = layer.weight.rows,
        .weight = parameters.data() + layer.weight_at,
        .columns = layer.weight.padded_columns(),
        .start = parameters.data() + layer.bias_at,
        .y = memory.outputs[k].data() + row * layer.stride,
        .y_stride = layer.stride,
        .epilogue = epilogue_of(layer.activation),
    });
  }
}

void Network::backward(const TransposedWeights& transposed, const float* x, int x_stride,
                       NetworkActivations& memory, const float* dy, int dy_stride,
                       std::span<float> gradient, float* dx, int dx_stride) const {
  const int stride = std::max(widest_stride(), row_stride(padded(shape_.inputs)));
  make_large_enough(memory.gradient, area(chunk_, stride));
  make_large_enough(memory.gradient_before, area(chunk_, stride));
  const Layer& last = layers_.back();
  for (int first = 0; first < memory.rows; first += chunk_) {
    const int rows = std::min(chunk_, memory.rows - first);
    const std::ptrdiff_t row = first;
    std::fill_n(memory.gradient.data(), static_cast<std::ptrdiff_t>(rows) * last.stride, 0.0f);
    copy_rows(dy + row * dy_stride, dy_stride, rows, shape_.outputs, memory.gradient.data(),
              last.stride);
    backward_rows(transposed, {x, x_stride}, first, rows, memory, gradient,
                  dx == nullptr ? nullptr : dx + row * dx_stride, dx_stride);
  }
}

void Network::backward_rows(const TransposedWeights& transposed, const Rows& x, int first, int rows,
                            NetworkActivations& memory, std::span<float> gradient, float* dx,
                            int dx_stride) const {
  for (std::size_t k = layers_.size(); k-- > 0;) {
    const Layer& layer = layers_[k];
    const Rows input = input_of(k, x, memory);
    kernels_->outer({
        .x = input.data + static_cast<std::ptrdiff_t>(first) * input.stride,
        .x_stride = input.stride,
        .d = memory.gradient.data(),
        .d_stride = layer.stride,
        .rows = rows,
        .inner = layer.weight.rows,
        .columns = layer.weight.padded_columns(),
        .gradient = gradient.data() + layer.weight_at,
        .bias = gradient.data() + layer.bias_at,
    });
    if (k == 0 && dx == nullptr) return;
    propagate(transposed, k, first, rows, memory);
    std::swap(memory.gradient, memory.gradient_before);
  }
  copy_rows(memory.gradient.data(), row_stride(padded(shape_.inputs)), rows, shape_.inputs, dx,
            dx_stride);
}

/// From the gradient at a layer's sums to the gradient at the previous layer's sums.
void Network::propagate(const TransposedWeights& transposed, std::size_t layer, int first, int rows,
                        NetworkActivations& memory) const {
  const PanelMatrix turned = layers_[layer].weight.transposed();
  const Rows output = input_of(layer, {nullptr, 0}, memory);
  kernels_->multiply({
      .x = memory.gradient.data(),
      .x_stride = layers_[layer].stride,
      .rows = rows,
      .inner = turned.rows,
      .weight = transposed.layers[layer].data(),
      .columns = turned.padded_columns(),
      .start = nullptr,
      .y = memory.gradient_before.data(),
      .y_stride = row_stride(turned.padded_columns()),
      .epilogue = layer == 0 ? Epilogue::kNone : slope_of(layers_[layer - 1].activation),
      .output =
          layer == 0 ? nullptr : output.data + static_cast<std::ptrdiff_t>(first) * output.stride,
      .output_stride = output.stride,
  });
}

std::vector<PolicyLayer> Network::layers(std::span<const float> parameters) const {
  std::vector<PolicyLayer> result;
  for (const Layer& layer : layers_) {
    PolicyLayer& to = result.emplace_back();
    to.inputs = layer.weight.rows;
    to.outputs = layer.weight.columns;
    to.activation = layer.activation;
    for (int o = 0; o < to.outputs; ++o) {
      for (int i = 0; i < to.inputs; ++i) {
        to.weight.push_back(
            static_cast<double>(parameters[layer.weight_at + layer.weight.at(i, o)]));
      }
      to.bias.push_back(
          static_cast<double>(parameters[layer.bias_at + static_cast<std::size_t>(o)]));
    }
  }
  return result;
}

void Network::set_layers(std::span<const PolicyLayer> layers, std::span<float> parameters) const {
  bool fits = layers.size() == layers_.size();
  for (std::size_t k = 0; fits && k < layers_.size(); ++k) {
    fits = layers[k].inputs == layers_[k].weight.rows &&
           layers[k].outputs == layers_[k].weight.columns &&
           layers[k].activation == layers_[k].activation;
  }
  if (!fits) throw Error("a policy's layers differ in number, size or activation from a network's");
  std::fill_n(parameters.begin(), parameter_count_, 0.0f);
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    const Layer& layer = layers_[k];
    auto from = layers[k].weight.begin();
    for (int o = 0; o < layer.weight.columns; ++o) {
      for (int i = 0; i < layer.weight.rows; ++i) {
        parameters[layer.weight_at + layer.weight.at(i, o)] = static_cast<float>(*from++);
      }
      parameters[layer.bias_at + static_cast<std::size_t>(o)] =
          static_cast<float>(layers[k].bias[static_cast<std::size_t>(o)]);
    }
  }
}

}  // namespace skybody::learn
