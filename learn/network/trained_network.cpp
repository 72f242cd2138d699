#include "learn/network/trained_network.h"

#include <algorithm>

namespace skybody::learn {

TrainedNetwork::TrainedNetwork(const NetworkShape& shape, double max_grad_norm, Isa isa)
    : network_(shape, isa),
      parameters_(network_.parameter_count()),
      adam_(network_.parameter_count(), max_grad_norm, isa) {
  prepare();
}

void TrainedNetwork::initialize(double last_gain, std::uint64_t key, std::uint64_t stream) {
  network_.initialize({parameters_.data(), parameters_.size()}, last_gain, key, stream);
  prepare();
}

void TrainedNetwork::forward(const float* x, int x_stride, int rows, float* y) {
  network_.forward(parameters(), x, x_stride, rows, activations_, y, network_.shape().outputs);
}

void TrainedNetwork::backward(const float* x, int x_stride, const float* dy, float* dx) {
  network_.backward(transposed_, x, x_stride, activations_, dy, network_.shape().outputs,
                    adam_.gradient(), dx, x_stride);
}

double TrainedNetwork::step(double learning_rate) {
  const double norm = step_and_prepare(learning_rate);
  std::fill(adam_.gradient().begin(), adam_.gradient().end(), 0.0f);
  return norm;
}

double TrainedNetwork::step(std::span<const float* const> gradients, double learning_rate) {
  adam_.sum(gradients);
  return step_and_prepare(learning_rate);
}

double TrainedNetwork::step_and_prepare(double learning_rate) {
  const double norm = adam_.step({parameters_.data(), parameters_.size()}, learning_rate);
  prepare();
  return norm;
}

}  // namespace skybody::learn
