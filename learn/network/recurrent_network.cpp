#include "learn/network/recurrent_network.h"

#include "core/base/math/random.h"
#include "core/base/system/error.h"
#include "learn/network/growing_array.h"

namespace skybody::learn {

RecurrentNetwork::RecurrentNetwork(const RecurrentShape& shape, Isa isa)
    : shape_(shape),
      gru_(shape.inputs, shape.units, isa),
      head_({shape.units, shape.hidden, shape.outputs, shape.activation}, isa) {}

void RecurrentNetwork::initialize(std::span<float> parameters, double last_gain, std::uint64_t key,
                                  std::uint64_t stream) const {
  gru_.initialize(parameters, key, stream ^ derive_stream("gru"));
  head_.initialize(parameters.subspan(gru_.parameter_count()), last_gain, key, stream);
}

void RecurrentNetwork::transpose(std::span<const float> parameters,
                                 TransposedRecurrent& transposed) const {
  gru_.transpose(parameters, transposed.gru);
  head_.transpose(parameters.subspan(gru_.parameter_count()), transposed.head);
}

void RecurrentNetwork::forward(std::span<const float> parameters, const float* x, int x_stride,
                               const Sequences& sequences, const std::uint8_t* begins,
                               float* states, RecurrentActivations& memory, float* y,
                               int y_stride) const {
  gru_.forward(parameters, x, x_stride, sequences, begins, states, memory.gru);
  head_.forward(parameters.subspan(gru_.parameter_count()), memory.gru.outputs.data(),
                gru_.state_stride(), sequences.rows(), memory.head, y, y_stride);
}

void RecurrentNetwork::backward(const TransposedRecurrent& transposed, const float* x, int x_stride,
                                const std::uint8_t* begins, RecurrentActivations& memory,
                                const float* dy, int dy_stride, std::span<float> gradient,
                                float* dx, int dx_stride) const {
  const int stride = gru_.state_stride();
  make_large_enough(memory.d_states, static_cast<std::size_t>(memory.gru.sequences.rows()) *
                                         static_cast<std::size_t>(stride));
  head_.backward(transposed.head, memory.gru.outputs.data(), stride, memory.head, dy, dy_stride,
                 gradient.subspan(gru_.parameter_count()), memory.d_states.data(), stride);
  gru_.backward(transposed.gru, x, x_stride, begins, memory.gru, memory.d_states.data(), stride,
                gradient, dx, dx_stride);
}

std::vector<PolicyLayer> RecurrentNetwork::layers(std::span<const float> parameters) const {
  std::vector<PolicyLayer> all = {gru_.layer(parameters)};
  for (PolicyLayer& layer : head_.layers(parameters.subspan(gru_.parameter_count()))) {
    all.push_back(std::move(layer));
  }
  return all;
}

void RecurrentNetwork::set_layers(std::span<const PolicyLayer> layers,
                                  std::span<float> parameters) const {
  if (layers.empty()) throw Error("a policy without layers is no recurrent network");
  gru_.set_layer(layers[0], parameters);
  head_.set_layers(layers.subspan(1), parameters.subspan(gru_.parameter_count()));
}

}  // namespace skybody::learn
