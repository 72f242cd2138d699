#include "learn/ppo/policy_network.h"

namespace skybody::learn {
namespace {

std::variant<Network, RecurrentNetwork> make_network(const RecurrentShape& shape, Isa isa) {
  if (shape.units > 0) return RecurrentNetwork(shape, isa);
  return Network({shape.inputs, shape.hidden, shape.outputs, shape.activation}, isa);
}

}  // namespace

PolicyNetwork::PolicyNetwork(int inputs, int outputs, const Hyperparameters& hyper, Isa isa)
    : shape_{inputs, hyper.recurrent_units, hyper.hidden, outputs, hyper.activation},
      network_(make_network(shape_, isa)) {}

std::size_t PolicyNetwork::parameter_count() const {
  return std::visit([](const auto& network) { return network.parameter_count(); }, network_);
}

void PolicyNetwork::initialize(std::span<float> parameters, double last_gain, std::uint64_t key,
                               std::uint64_t stream) const {
  std::visit([&](const auto& network) { network.initialize(parameters, last_gain, key, stream); },
             network_);
}

void PolicyNetwork::transpose(std::span<const float> parameters, Transposed& transposed) const {
  if (const auto* recurrent = std::get_if<RecurrentNetwork>(&network_)) {
    recurrent->transpose(parameters, transposed.recurrent);
  } else {
    std::get<Network>(network_).transpose(parameters, transposed.dense);
  }
}

void PolicyNetwork::forward(std::span<const float> parameters, const float* x, int x_stride,
                            const PolicySteps& steps, Memory& memory, float* y,
                            int y_stride) const {
  if (const auto* recurrent = std::get_if<RecurrentNetwork>(&network_)) {
    recurrent->forward(parameters, x, x_stride, steps.sequences, steps.begins, steps.states,
                       memory.recurrent, y, y_stride);
  } else {
    std::get<Network>(network_).forward(parameters, x, x_stride, steps.sequences.rows(),
                                        memory.dense, y, y_stride);
  }
}

void PolicyNetwork::backward(const Transposed& transposed, const float* x, int x_stride,
                             const PolicySteps& steps, Memory& memory, const float* dy,
                             int dy_stride, std::span<float> gradient) const {
  if (const auto* recurrent = std::get_if<RecurrentNetwork>(&network_)) {
    recurrent->backward(transposed.recurrent, x, x_stride, steps.begins, memory.recurrent, dy,
                        dy_stride, gradient);
  } else {
    std::get<Network>(network_).backward(transposed.dense, x, x_stride, memory.dense, dy, dy_stride,
                                         gradient);
  }
}

std::vector<PolicyLayer> PolicyNetwork::layers(std::span<const float> parameters) const {
  return std::visit([&](const auto& network) { return network.layers(parameters); }, network_);
}

}  // namespace skybody::learn
