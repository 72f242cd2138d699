#include "learn/network/policy_network.h"

#include <algorithm>

#include "core/base/math/random.h"
#include "learn/network/growing_array.h"
#include "learn/network/panel_matrix.h"
#include "learn/network/product.h"

namespace skybody::learn {
namespace {

std::variant<Network, RecurrentNetwork> make_network(const RecurrentShape& shape, Isa isa) {
  if (shape.units > 0) return RecurrentNetwork(shape, isa);
  return Network({shape.inputs, shape.hidden, shape.outputs, shape.activation}, isa);
}

std::vector<ImageEncoder> make_encoders(const NetworkInputs& inputs, const Hyperparameters& hyper,
                                        Isa isa) {
  std::vector<ImageEncoder> encoders;
  for (const ImageFormat& format : inputs.images) {
    encoders.emplace_back(format, encoder_shape(hyper), isa);
  }
  return encoders;
}

std::vector<std::size_t> find_begins(const std::vector<ImageEncoder>& encoders) {
  std::vector<std::size_t> begins = {0};
  for (const ImageEncoder& encoder : encoders) {
    begins.push_back(begins.back() + encoder.parameter_count());
  }
  return begins;
}

int width_of(const NetworkInputs& inputs, const std::vector<ImageEncoder>& encoders) {
  int width = inputs.values;
  for (const ImageEncoder& encoder : encoders) width += encoder.features();
  return width;
}

}  // namespace

EncoderShape encoder_shape(const Hyperparameters& hyper) {
  return {hyper.cnn_channels,     hyper.cnn_kernels,  hyper.cnn_strides,
          hyper.cnn_same_padding, hyper.cnn_features, hyper.activation};
}

PolicyNetwork::PolicyNetwork(const NetworkInputs& inputs, int outputs, const Hyperparameters& hyper,
                             int units, Isa isa)
    : values_(inputs.values),
      encoders_(make_encoders(inputs, hyper, isa)),
      begins_(find_begins(encoders_)),
      shape_{width_of(inputs, encoders_), units, hyper.hidden, outputs, hyper.activation},
      input_stride_(padded(shape_.inputs)),
      network_(make_network(shape_, isa)) {}

std::size_t PolicyNetwork::parameter_count() const {
  return network_at() +
         std::visit([](const auto& network) { return network.parameter_count(); }, network_);
}

void PolicyNetwork::initialize(std::span<float> parameters, double last_gain, std::uint64_t key,
                               std::uint64_t stream) const {
  for (std::size_t k = 0; k < encoders_.size(); ++k) {
    encoders_[k].initialize(parameters.subspan(begins_[k]), key,
                            stream ^ (derive_stream("images") + k));
  }
  const std::span<float> rest = parameters.subspan(network_at());
  std::visit([&](const auto& network) { network.initialize(rest, last_gain, key, stream); },
             network_);
}

void PolicyNetwork::transpose(std::span<const float> parameters, Transposed& transposed) const {
  transposed.encoders.resize(encoders_.size());
  for (std::size_t k = 0; k < encoders_.size(); ++k) {
    encoders_[k].transpose(parameters.subspan(begins_[k]), transposed.encoders[k]);
  }
  const std::span<const float> rest = parameters.subspan(network_at());
  if (const auto* recurrent = std::get_if<RecurrentNetwork>(&network_)) {
    recurrent->transpose(rest, transposed.recurrent);
  } else {
    std::get<Network>(network_).transpose(rest, transposed.dense);
  }
}

/// Rows of the values, followed by the features of the images.
PolicyNetwork::Rows PolicyNetwork::add_features(std::span<const float> parameters,
                                                const Rows& values, int rows,
                                                const ImageRows& images, Memory& memory) const {
  if (encoders_.empty()) return values;
  memory.encoders.resize(encoders_.size());
  make_large_enough(memory.inputs, product(rows, input_stride_));
  for (int r = 0; r < rows; ++r) {
    std::copy_n(values.x + product(r, values.stride), values_,
                memory.inputs.data() + product(r, input_stride_));
  }
  float* features = memory.inputs.data() + values_;
  for (std::size_t k = 0; k < encoders_.size(); ++k) {
    const auto bytes = static_cast<std::size_t>(encoders_[k].format().bytes());
    encoders_[k].forward(parameters.subspan(begins_[k]),
                         images.columns[k].data() + images.first * bytes, images.order, rows,
                         memory.encoders[k], features, input_stride_);
    features += encoders_[k].features();
  }
  return {memory.inputs.data(), input_stride_};
}

void PolicyNetwork::forward(std::span<const float> parameters, const float* x, int x_stride,
                            const PolicySteps& steps, Memory& memory, float* y,
                            int y_stride) const {
  const int rows = steps.sequences.rows();
  const Rows inputs = add_features(parameters, {x, x_stride}, rows, steps.images, memory);
  const std::span<const float> rest = parameters.subspan(network_at());
  if (const auto* recurrent = std::get_if<RecurrentNetwork>(&network_)) {
    recurrent->forward(rest, inputs.x, inputs.stride, steps.sequences, steps.begins, steps.states,
                       memory.recurrent, y, y_stride);
  } else {
    std::get<Network>(network_).forward(rest, inputs.x, inputs.stride, rows, memory.dense, y,
                                        y_stride);
  }
}

void PolicyNetwork::backward(const Transposed& transposed, const float* x, int x_stride,
                             const PolicySteps& steps, Memory& memory, const float* dy,
                             int dy_stride, std::span<float> gradient, float* dx,
                             int dx_stride) const {
  const bool has_images = !encoders_.empty();
  if (has_images) {
    make_large_enough(memory.d_inputs, product(steps.sequences.rows(), input_stride_));
  }
  const Rows inputs = has_images ? Rows{memory.inputs.data(), input_stride_} : Rows{x, x_stride};
  float* d_inputs = has_images ? memory.d_inputs.data() : dx;
  const int d_stride = has_images ? input_stride_ : dx_stride;
  const std::span<float> rest = gradient.subspan(network_at());
  if (const auto* recurrent = std::get_if<RecurrentNetwork>(&network_)) {
    recurrent->backward(transposed.recurrent, inputs.x, inputs.stride, steps.begins,
                        memory.recurrent, dy, dy_stride, rest, d_inputs, d_stride);
  } else {
    std::get<Network>(network_).backward(transposed.dense, inputs.x, inputs.stride, memory.dense,
                                         dy, dy_stride, rest, d_inputs, d_stride);
  }
  if (!has_images) return;
  for (int r = 0; dx != nullptr && r < steps.sequences.rows(); ++r) {
    std::copy_n(d_inputs + product(r, input_stride_), values_, dx + product(r, dx_stride));
  }
  const float* d_features = d_inputs + values_;
  for (std::size_t k = 0; k < encoders_.size(); ++k) {
    encoders_[k].backward(transposed.encoders[k], memory.encoders[k], d_features, input_stride_,
                          gradient.subspan(begins_[k]));
    d_features += encoders_[k].features();
  }
}

std::vector<PolicyLayer> PolicyNetwork::layers(std::span<const float> parameters) const {
  const std::span<const float> rest = parameters.subspan(network_at());
  return std::visit([&](const auto& network) { return network.layers(rest); }, network_);
}

std::vector<std::vector<PolicyLayer>> PolicyNetwork::image_layers(
    std::span<const float> parameters) const {
  std::vector<std::vector<PolicyLayer>> result;
  for (std::size_t k = 0; k < encoders_.size(); ++k) {
    result.push_back(encoders_[k].layers(parameters.subspan(begins_[k])));
  }
  return result;
}

}  // namespace skybody::learn
