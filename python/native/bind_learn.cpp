#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <string>
#include <vector>

#include "learn/hyperparameter_text.h"
#include "learn/network/adam.h"
#include "learn/network/image_encoder.h"
#include "learn/network/network.h"
#include "learn/network/recurrent_network.h"
#include "python/native/arrays.h"
#include "python/native/bindings.h"

namespace skybody::python {
namespace {

using learn::Adam;
using learn::ImageEncoder;
using learn::Network;
using learn::RecurrentNetwork;

std::int64_t extent(std::size_t size) { return static_cast<std::int64_t>(size); }

template <class Net>
Values<float> read_parameters(const Net& network, nb::handle parameters) {
  return read_array<float>(parameters, "parameters", {extent(network.parameter_count())});
}

/// Runs forward() on the rows of x.
std::vector<float> outputs_of(const Network& network, std::span<const float> parameters,
                              const Values<float>& x, learn::NetworkActivations& memory) {
  const learn::NetworkShape& shape = network.shape();
  std::vector<float> y(x.rows() * static_cast<std::size_t>(shape.outputs));
  network.forward(parameters, x.span().data(), shape.inputs, static_cast<int>(x.rows()), memory,
                  y.data(), shape.outputs);
  return y;
}

nb::object forward(const Network& network, nb::handle parameters, nb::handle x) {
  const Values<float> weights = read_parameters(network, parameters);
  const Values<float> rows = read_array<float>(x, "x", {-1, network.shape().inputs});
  learn::NetworkActivations memory;
  const std::vector<float> y = outputs_of(network, weights.span(), rows, memory);
  return copy_of<float>(y, {rows.rows(), static_cast<std::size_t>(network.shape().outputs)});
}

nb::tuple backward(const Network& network, nb::handle parameters, nb::handle x, nb::handle dy) {
  const learn::NetworkShape& shape = network.shape();
  const Values<float> weights = read_parameters(network, parameters);
  const Values<float> rows = read_array<float>(x, "x", {-1, shape.inputs});
  const Values<float> slopes = read_array<float>(dy, "dy", {extent(rows.rows()), shape.outputs});
  learn::NetworkActivations memory;
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

template <class Net>
nb::object initial_parameters(const Net& network, double last_gain, std::uint64_t seed) {
  std::vector<float> parameters(network.parameter_count());
  network.initialize(parameters, last_gain, seed, 0);
  return copy_of<float>(parameters, {parameters.size()});
}

template <class Net>
nb::list layers(const Net& network, nb::handle parameters) {
  nb::list result;
  for (const PolicyLayer& layer : network.layers(read_parameters(network, parameters).span())) {
    result.append(tuple_of(layer));
  }
  return result;
}

/// Arguments of a recurrent network's calls, and the results of forward().
struct RecurrentCall {
  Values<float> parameters, x, states;
  learn::Sequences sequences;
  std::vector<std::uint8_t> begins;
  std::vector<float> y, last;
  learn::RecurrentActivations memory;

  RecurrentCall(const RecurrentNetwork& network, nb::handle parameters_in, nb::handle x_in,
                nb::handle begins_in, nb::handle states_in)
      : parameters(read_parameters(network, parameters_in)),
        x(read_array<float>(x_in, "x", {-1, -1, network.shape().inputs})),
        states(read_array<float>(states_in, "states", {extent(x.rows()), network.shape().units})) {
    const auto units = static_cast<std::size_t>(network.shape().units);
    const auto stride = static_cast<std::size_t>(network.state_stride());
    const std::size_t rows = x.span().size() / static_cast<std::size_t>(network.shape().inputs);
    sequences.count = static_cast<int>(x.rows());
    sequences.steps = static_cast<int>(rows / std::max<std::size_t>(1, x.rows()));
    begins = read_mask(begins_in, "begins", extent(rows));
    y.resize(rows * static_cast<std::size_t>(network.shape().outputs));
    last.resize(x.rows() * stride);
    for (std::size_t k = 0; k < x.rows(); ++k) {
      std::copy_n(states.span().data() + k * units, units, last.data() + k * stride);
    }
    network.forward(parameters.span(), x.span().data(), network.shape().inputs, sequences,
                    begins.data(), last.data(), memory, y.data(), network.shape().outputs);
  }

  nb::object rows_of(const std::vector<float>& values, int width) const {
    return copy_of<float>(
        values, {static_cast<std::size_t>(sequences.count),
                 static_cast<std::size_t>(sequences.steps), static_cast<std::size_t>(width)});
  }
};

nb::object recurrent_forward(const RecurrentNetwork& network, nb::handle parameters, nb::handle x,
                             nb::handle begins, nb::handle states) {
  const RecurrentCall call(network, parameters, x, begins, states);
  return call.rows_of(call.y, network.shape().outputs);
}

nb::tuple recurrent_backward(const RecurrentNetwork& network, nb::handle parameters, nb::handle x,
                             nb::handle begins, nb::handle states, nb::handle dy) {
  RecurrentCall call(network, parameters, x, begins, states);
  const int inputs = network.shape().inputs, outputs = network.shape().outputs;
  const Values<float> slopes =
      read_array<float>(dy, "dy", {call.sequences.count, call.sequences.steps, outputs});
  learn::TransposedRecurrent transposed;
  network.transpose(call.parameters.span(), transposed);
  std::vector<float> gradient(network.parameter_count()), dx(call.x.span().size());
  network.backward(transposed, call.x.span().data(), inputs, call.begins.data(), call.memory,
                   slopes.span().data(), outputs, gradient, dx.data(), inputs);
  return nb::make_tuple(copy_of<float>(gradient, {gradient.size()}), call.rows_of(dx, inputs));
}

/// Pixels of float images (rows, height, width, channels), and the features of these.
struct EncoderCall {
  Values<float> parameters, x;
  learn::EncoderActivations memory;
  std::vector<float> y;

  EncoderCall(const ImageEncoder& encoder, nb::handle parameters_in, nb::handle x_in)
      : parameters(read_parameters(encoder, parameters_in)),
        x(read_array<float>(
            x_in, "x",
            {-1, encoder.format().height, encoder.format().width, encoder.format().channels})),
        y(x.rows() * static_cast<std::size_t>(encoder.features())) {
    encoder.forward(parameters.span(), reinterpret_cast<const std::uint8_t*>(x.span().data()),
                    nullptr, static_cast<int>(x.rows()), memory, y.data(), encoder.features());
  }
};

nb::object encode(const ImageEncoder& encoder, nb::handle parameters, nb::handle x) {
  const EncoderCall call(encoder, parameters, x);
  return copy_of<float>(call.y, {call.x.rows(), static_cast<std::size_t>(encoder.features())});
}

nb::object encoder_gradient(const ImageEncoder& encoder, nb::handle parameters, nb::handle x,
                            nb::handle dy) {
  EncoderCall call(encoder, parameters, x);
  const Values<float> slopes =
      read_array<float>(dy, "dy", {extent(call.x.rows()), encoder.features()});
  learn::TransposedEncoder transposed;
  encoder.transpose(call.parameters.span(), transposed);
  std::vector<float> gradient(encoder.parameter_count());
  encoder.backward(transposed, call.memory, slopes.span().data(), encoder.features(), gradient);
  return copy_of<float>(gradient, {gradient.size()});
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

void bind_network(nb::module_& m) {
  nb::class_<Network>(m, "Network",
                      "A multilayer perceptron of the native learners, in float32. Its parameters "
                      "are one array, in the order of the kernels: see `layers()`.")
      .def(
          "__init__",
          [](Network* self, int inputs, const std::vector<int>& hidden, int outputs,
             const std::string& activation) {
            new (self) Network({inputs, hidden, outputs, learn::hidden_activation(activation)},
                               best_isa());
          },
          nb::arg("inputs"), nb::arg("hidden"), nb::arg("outputs"), nb::arg("activation") = "tanh")
      .def_prop_ro("parameter_count", &Network::parameter_count)
      .def("initial_parameters", &initial_parameters<Network>, nb::arg("last_gain"),
           nb::arg("seed"), "Orthogonal weights, zero biases.")
      .def("layers", &layers<Network>, nb::arg("parameters"),
           nb::sig("def layers(self, parameters: object) -> list[tuple[typing.Any, ...]]"),
           "(weight, bias, activation) of each layer, as a policy file has them.")
      .def("forward", &forward, nb::arg("parameters"), nb::arg("x"),
           nb::sig("def forward(self, parameters: object, x: object) -> typing.Any"),
           "Outputs (rows, outputs) of x (rows, inputs).")
      .def("backward", &backward, nb::arg("parameters"), nb::arg("x"), nb::arg("dy"),
           nb::sig("def backward(self, parameters: object, x: object, dy: object) -> "
                   "tuple[typing.Any, typing.Any]"),
           "Gradients of sum(outputs * dy) at the parameters and at x.");
}

void bind_recurrent_network(nb::module_& m) {
  nb::class_<RecurrentNetwork>(m, "RecurrentNetwork",
                               "Gated recurrent units, then dense layers on their states. Arrays "
                               "of rows are (sequences, steps, ...).")
      .def(
          "__init__",
          [](RecurrentNetwork* self, int inputs, int units, const std::vector<int>& hidden,
             int outputs, const std::string& activation) {
            new (self) RecurrentNetwork(
                {inputs, units, hidden, outputs, learn::hidden_activation(activation)}, best_isa());
          },
          nb::arg("inputs"), nb::arg("units"), nb::arg("hidden"), nb::arg("outputs"),
          nb::arg("activation") = "tanh")
      .def_prop_ro("parameter_count", &RecurrentNetwork::parameter_count)
      .def("initial_parameters", &initial_parameters<RecurrentNetwork>, nb::arg("last_gain"),
           nb::arg("seed"), "Orthogonal weights, zero biases.")
      .def("layers", &layers<RecurrentNetwork>, nb::arg("parameters"),
           nb::sig("def layers(self, parameters: object) -> list[tuple[typing.Any, ...]]"),
           "Each layer, as `read_policy_file` gives them.")
      .def("forward", &recurrent_forward, nb::arg("parameters"), nb::arg("x"), nb::arg("begins"),
           nb::arg("states"),
           nb::sig("def forward(self, parameters: object, x: object, begins: object, states: "
                   "object) -> typing.Any"),
           "Outputs of x; states (sequences, units) at the beginning; `begins`, one value a row: "
           "an episode begins, the state before is zero.")
      .def("backward", &recurrent_backward, nb::arg("parameters"), nb::arg("x"), nb::arg("begins"),
           nb::arg("states"), nb::arg("dy"),
           nb::sig("def backward(self, parameters: object, x: object, begins: object, states: "
                   "object, dy: object) -> tuple[typing.Any, typing.Any]"),
           "Gradients of sum(outputs * dy) at the parameters and at x.");
}

void bind_encoder(nb::module_& m) {
  nb::class_<ImageEncoder>(m, "ImageEncoder",
                           "Convolutions and a dense layer on images of float32, whose pixels are "
                           "clipped to 0..1.")
      .def(
          "__init__",
          [](ImageEncoder* self, int height, int width, int channels,
             const std::vector<int>& cnn_channels, const std::vector<int>& cnn_kernels,
             const std::vector<int>& cnn_strides, bool same_padding, int features,
             const std::string& activation) {
            new (self)
                ImageEncoder({learn::PixelType::kFloat32, height, width, channels, 0.0f, 1.0f},
                             {cnn_channels, cnn_kernels, cnn_strides, same_padding, features,
                              learn::hidden_activation(activation)},
                             best_isa());
          },
          nb::arg("height"), nb::arg("width"), nb::arg("channels"), nb::arg("cnn_channels"),
          nb::arg("cnn_kernels"), nb::arg("cnn_strides"), nb::arg("same_padding"),
          nb::arg("features"), nb::arg("activation") = "tanh")
      .def_prop_ro("parameter_count", &ImageEncoder::parameter_count)
      .def(
          "initial_parameters",
          [](const ImageEncoder& encoder, std::uint64_t seed) {
            std::vector<float> parameters(encoder.parameter_count());
            encoder.initialize(parameters, seed, 0);
            return copy_of<float>(parameters, {parameters.size()});
          },
          nb::arg("seed"), "Orthogonal weights, zero biases.")
      .def("layers", &layers<ImageEncoder>, nb::arg("parameters"),
           nb::sig("def layers(self, parameters: object) -> list[tuple[typing.Any, ...]]"),
           "Each layer, as `read_policy_file` gives them.")
      .def("forward", &encode, nb::arg("parameters"), nb::arg("x"),
           nb::sig("def forward(self, parameters: object, x: object) -> typing.Any"),
           "Features (rows, features) of x (rows, height, width, channels).")
      .def("backward", &encoder_gradient, nb::arg("parameters"), nb::arg("x"), nb::arg("dy"),
           nb::sig("def backward(self, parameters: object, x: object, dy: object) -> typing.Any"),
           "Gradient of sum(features * dy) at the parameters.");
}

void bind_adam(nb::module_& m) {
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

}  // namespace

void bind_learn(nb::module_& m) {
  bind_network(m);
  bind_recurrent_network(m);
  bind_encoder(m);
  bind_adam(m);
}

}  // namespace skybody::python
