#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "learn/network/adam.h"
#include "learn/network/network.h"
#include "python/native/arrays.h"
#include "python/native/bindings.h"

namespace skybody::python {
namespace {

using learn::Adam;
using learn::Network;

Activation activation_of(const std::string& wanted) {
  std::string allowed;
  for (std::size_t k = 1; k < std::size(kActivationNames); ++k) {
    if (wanted == kActivationNames[k]) return static_cast<Activation>(k);
    allowed += (k > 1 ? ", " : "") + std::string(kActivationNames[k]);
  }
  throw Error("`activation` is `" + wanted + "`; allowed: " + allowed);
}

std::int64_t extent(std::size_t size) { return static_cast<std::int64_t>(size); }

Values<float> read_parameters(const Network& network, nb::handle parameters) {
  return read_array<float>(parameters, "parameters", {extent(network.parameter_count())});
}

/// Runs forward() on the rows of x.
std::vector<float> outputs_of(const Network& network, std::span<const float> parameters,
                              const Values<float>& x, learn::NetworkMemory& memory) {
  const learn::NetworkShape& shape = network.shape();
  std::vector<float> y(x.rows() * static_cast<std::size_t>(shape.outputs));
  network.forward(parameters, x.span().data(), shape.inputs, static_cast<int>(x.rows()), memory,
                  y.data(), shape.outputs);
  return y;
}

nb::object forward(const Network& network, nb::handle parameters, nb::handle x) {
  const Values<float> weights = read_parameters(network, parameters);
  const Values<float> rows = read_array<float>(x, "x", {-1, network.shape().inputs});
  learn::NetworkMemory memory;
  const std::vector<float> y = outputs_of(network, weights.span(), rows, memory);
  return copy_of<float>(y, {rows.rows(), static_cast<std::size_t>(network.shape().outputs)});
}

nb::tuple backward(const Network& network, nb::handle parameters, nb::handle x, nb::handle dy) {
  const learn::NetworkShape& shape = network.shape();
  const Values<float> weights = read_parameters(network, parameters);
  const Values<float> rows = read_array<float>(x, "x", {-1, shape.inputs});
  const Values<float> slopes = read_array<float>(dy, "dy", {extent(rows.rows()), shape.outputs});
  learn::NetworkMemory memory;
  outputs_of(network, weights.span(), rows, memory);
  learn::TransposedWeights transposed;
  network.transpose(weights.span(), transposed);
  std::vector<float> gradient(network.parameter_count());
  std::vector<float> dx(rows.span().size());
  network.backward(transposed, rows.span().data(), shape.inputs, memory, slopes.span().data(),
                   shape.outputs, gradient, dx.data(), shape.inputs);
  return nb::make_tuple(copy_of<float>(gradient, {gradient.size()}),
                        copy_of<float>(dx, {rows.rows(), static_cast<std::size_t>(shape.inputs)}));
}

nb::object initial_parameters(const Network& network, double last_gain, std::uint64_t seed) {
  std::vector<float> parameters(network.parameter_count());
  network.initialize(parameters, last_gain, seed, 0);
  return copy_of<float>(parameters, {parameters.size()});
}

nb::list layers(const Network& network, nb::handle parameters) {
  nb::list result;
  for (const PolicyLayer& layer : network.layers(read_parameters(network, parameters).span())) {
    result.append(
        nb::make_tuple(copy_of<double>(layer.weight, {static_cast<std::size_t>(layer.outputs),
                                                      static_cast<std::size_t>(layer.inputs)}),
                       copy_of<double>(layer.bias, {layer.bias.size()}), name(layer.activation)));
  }
  return result;
}

nb::object step(Adam& adam, nb::handle gradient, double learning_rate, nb::handle parameters) {
  const auto count = extent(adam.size());
  const Values<float> slopes = read_array<float>(gradient, "gradient", {count});
  const Values<float> before = read_array<float>(parameters, "parameters", {count});
  std::vector<float> after(before.span().begin(), before.span().end());
  std::copy(slopes.span().begin(), slopes.span().end(), adam.gradient().begin());
  adam.step(after, learning_rate);
  return copy_of<float>(after, {after.size()});
}

}  // namespace

void bind_learn(nb::module_& m) {
  nb::class_<Network>(m, "Network",
                      "A multilayer perceptron of the native learners, in float32. Its parameters "
                      "are one array, in the order of the kernels: see `layers()`.")
      .def(
          "__init__",
          [](Network* self, int inputs, const std::vector<int>& hidden, int outputs,
             const std::string& activation) {
            new (self) Network({inputs, hidden, outputs, activation_of(activation)}, best_isa());
          },
          nb::arg("inputs"), nb::arg("hidden"), nb::arg("outputs"), nb::arg("activation") = "tanh")
      .def_prop_ro("parameter_count", &Network::parameter_count)
      .def("initial_parameters", &initial_parameters, nb::arg("last_gain"), nb::arg("seed"),
           "Orthogonal weights, zero biases.")
      .def("layers", &layers, nb::arg("parameters"),
           nb::sig("def layers(self, parameters: object) -> list[tuple[typing.Any, ...]]"),
           "(weight, bias, activation) of each layer, as a policy file has them.")
      .def("forward", &forward, nb::arg("parameters"), nb::arg("x"),
           nb::sig("def forward(self, parameters: object, x: object) -> typing.Any"),
           "Outputs (rows, outputs) of x (rows, inputs).")
      .def("backward", &backward, nb::arg("parameters"), nb::arg("x"), nb::arg("dy"),
           nb::sig("def backward(self, parameters: object, x: object, dy: object) -> "
                   "tuple[typing.Any, typing.Any]"),
           "Gradients of sum(outputs * dy) at the parameters and at x.");
  nb::class_<Adam>(m, "Adam", "The optimiser of the native learners.")
      .def(
          "__init__",
          [](Adam* self, std::size_t size, double max_grad_norm) {
            new (self) Adam(size, max_grad_norm, best_isa());
          },
          nb::arg("size"), nb::arg("max_grad_norm"))
      .def("step", &step, nb::arg("gradient"), nb::arg("learning_rate"), nb::arg("parameters"),
           nb::sig("def step(self, gradient: object, learning_rate: float, parameters: object) -> "
                   "typing.Any"),
           "Parameters after a step; the gradient is scaled down to `max_grad_norm`.");
}

}  // namespace skybody::python
