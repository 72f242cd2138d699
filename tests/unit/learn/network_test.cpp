// The oracle is a network in double, written index by index. Finite differences check the oracle's
// gradient.
#include "learn/network/network.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/math/hash.h"
#include "core/base/system/error.h"
#include "learn/network/adam.h"
#include "tests/unit/learn/isas.h"

namespace skybody::learn {
namespace {

using Matrix = std::vector<std::vector<double>>;

double activate(double x, Activation activation) {
  if (activation == Activation::kTanh) return std::tanh(x);
  if (activation == Activation::kRelu) return std::max(x, 0.0);
  if (activation == Activation::kElu) return x > 0.0 ? x : std::expm1(x);
  return x;
}

double slope(double x, Activation activation) {
  if (activation == Activation::kTanh) return 1.0 - std::pow(std::tanh(x), 2);
  if (activation == Activation::kRelu) return x > 0.0 ? 1.0 : 0.0;
  if (activation == Activation::kElu) return x > 0.0 ? 1.0 : std::exp(x);
  return 1.0;
}

/// The oracle's results for some rows: outputs, and gradients of sum(outputs * dy).
struct Answer {
  Matrix y, dx;
  std::vector<PolicyLayer> gradient;
};

Answer reference(const std::vector<PolicyLayer>& layers, const Matrix& x, const Matrix& dy) {
  Answer answer;
  answer.gradient = layers;
  for (PolicyLayer& layer : answer.gradient) {
    std::fill(layer.weight.begin(), layer.weight.end(), 0.0);
    std::fill(layer.bias.begin(), layer.bias.end(), 0.0);
  }
  for (std::size_t r = 0; r < x.size(); ++r) {
    Matrix values = {x[r]}, sums;
    for (const PolicyLayer& layer : layers) {
      std::vector<double>& sum = sums.emplace_back(layer.bias);
      std::vector<double> value;
      for (int o = 0; o < layer.outputs; ++o) {
        for (int i = 0; i < layer.inputs; ++i) {
          sum[o] += layer.weight[o * layer.inputs + i] * values.back()[i];
        }
        value.push_back(activate(sum[o], layer.activation));
      }
      values.push_back(value);
    }
    answer.y.push_back(values.back());
    if (dy.empty()) continue;
    std::vector<double> gradient = dy[r];
    for (std::size_t k = layers.size(); k-- > 0;) {
      const PolicyLayer& layer = layers[k];
      std::vector<double> before(static_cast<std::size_t>(layer.inputs), 0.0);
      for (int o = 0; o < layer.outputs; ++o) {
        const double d = gradient[o] * slope(sums[k][o], layer.activation);
        answer.gradient[k].bias[o] += d;
        for (int i = 0; i < layer.inputs; ++i) {
          answer.gradient[k].weight[o * layer.inputs + i] += d * values[k][i];
          before[i] += d * layer.weight[o * layer.inputs + i];
        }
      }
      gradient = before;
    }
    answer.dx.push_back(gradient);
  }
  return answer;
}

std::vector<float> flat(const Matrix& rows, int stride) {
  std::vector<float> values(rows.size() * static_cast<std::size_t>(stride), 77.0f);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t k = 0; k < rows[r].size(); ++k) {
      values[r * static_cast<std::size_t>(stride) + k] = static_cast<float>(rows[r][k]);
    }
  }
  return values;
}

Matrix random_rows(int rows, int width, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<float> normal;
  Matrix result(static_cast<std::size_t>(rows));
  for (auto& row : result) {
    for (int k = 0; k < width; ++k) row.push_back(static_cast<double>(normal(generator)));
  }
  return result;
}

/// A network with its parameters and all buffers of its calls.
struct Subject {
  Network network;
  std::vector<float> parameters, gradient;
  TransposedWeights transposed;
  NetworkActivations memory;

  Subject(const NetworkShape& shape, Isa isa)
      : network(shape, isa),
        parameters(network.parameter_count()),
        gradient(network.parameter_count()) {
    network.initialize(parameters, 1.0, 5, 7);
    // Biases that are not zero.
    auto layers = network.layers(parameters);
    for (PolicyLayer& layer : layers) {
      for (int o = 0; o < layer.outputs; ++o) layer.bias[o] = 0.1 * ((o % 7) - 3);
    }
    network.set_layers(layers, parameters);
    network.transpose(parameters, transposed);
  }

  std::vector<float> forward(const std::vector<float>& x, int stride, int rows) {
    const int outputs = network.shape().outputs;
    std::vector<float> y(static_cast<std::size_t>(rows * outputs));
    network.forward(parameters, x.data(), stride, rows, memory, y.data(), outputs);
    return y;
  }
  std::vector<float> backward(const std::vector<float>& x, int stride,
                              const std::vector<float>& dy) {
    const int inputs = network.shape().inputs, outputs = network.shape().outputs;
    std::vector<float> dx(static_cast<std::size_t>(memory.rows * inputs));
    network.backward(transposed, x.data(), stride, memory, dy.data(), outputs, gradient, dx.data(),
                     inputs);
    return dx;
  }
};

/// Float sums of n terms of size s have errors of about sqrt(n) s 2^-24; 30 of these are allowed.
void expect_near(const std::vector<float>& values, const Matrix& wanted, double scale,
                 const std::string& what) {
  const std::size_t width = wanted[0].size();
  for (std::size_t r = 0; r < wanted.size(); ++r) {
    for (std::size_t k = 0; k < width; ++k) {
      ASSERT_NEAR(static_cast<double>(values[r * width + k]), wanted[r][k], 2e-6 * scale)
          << what << ", row " << r << ", column " << k;
    }
  }
}

Matrix rows_of(const std::vector<PolicyLayer>& layers) {
  std::vector<double> all;
  for (const PolicyLayer& layer : layers) {
    all.insert(all.end(), layer.weight.begin(), layer.weight.end());
    all.insert(all.end(), layer.bias.begin(), layer.bias.end());
  }
  return {all};
}

std::vector<float> floats_of(const Matrix& rows) {
  return flat(rows, static_cast<int>(rows[0].size()));
}

void expect_as_reference(const NetworkShape& shape, int rows, Isa isa) {
  SCOPED_TRACE(std::string(name(isa)) + ", " + std::to_string(rows) + " rows");
  Subject subject(shape, isa);
  const int stride = shape.inputs + 3;
  const Matrix x = random_rows(rows, shape.inputs, 1), dy = random_rows(rows, shape.outputs, 2);
  const std::vector<float> x_floats = flat(x, stride), dy_floats = flat(dy, shape.outputs);
  const auto layers = subject.network.layers(subject.parameters);
  const Answer wanted = reference(layers, x, dy);
  expect_near(subject.forward(x_floats, stride, rows), wanted.y, 10.0, "output");
  expect_near(subject.backward(x_floats, stride, dy_floats), wanted.dx, 10.0, "dx");
  expect_near(floats_of(rows_of(subject.network.layers(subject.gradient))),
              rows_of(wanted.gradient), 10.0 * rows, "gradient");
}

/// Central differences of the oracle itself.
TEST(NetworkReference, HasTheGradientOfFiniteDifferences) {
  for (const Activation activation : {Activation::kTanh, Activation::kElu}) {
    Subject subject({3, {5, 4}, 2, activation}, best_isa());
    const Matrix x = random_rows(4, 3, 1), dy = random_rows(4, 2, 2);
    auto layers = subject.network.layers(subject.parameters);
    const Answer answer = reference(layers, x, dy);
    const auto loss = [&] {
      const Matrix y = reference(layers, x, {}).y;
      double sum = 0.0;
      for (std::size_t r = 0; r < y.size(); ++r) {
        for (std::size_t k = 0; k < y[r].size(); ++k) sum += y[r][k] * dy[r][k];
      }
      return sum;
    };
    for (std::size_t k = 0; k < layers.size(); ++k) {
      for (std::size_t i = 0; i < layers[k].weight.size(); ++i) {
        double& weight = layers[k].weight[i];
        const double kept = weight, step = 1e-5;
        weight = kept + step;
        const double above = loss();
        weight = kept - step;
        const double below = loss();
        weight = kept;
        // Truncation of order step^2, cancellation of order 1e-16 / step.
        ASSERT_NEAR((above - below) / (2.0 * step), answer.gradient[k].weight[i], 1e-8);
      }
    }
  }
}

TEST(Network, IsTheReferenceForAnyNumberOfRows) {
  for (const Isa isa : isas()) {
    for (int rows = 1; rows <= 17; ++rows) {
      expect_as_reference({22, {64, 64}, 4, Activation::kTanh}, rows, isa);
    }
  }
}

TEST(Network, IsTheReferenceForAnySizes) {
  const NetworkShape shapes[] = {
      {1, {}, 1, Activation::kTanh},          {1, {1}, 1, Activation::kRelu},
      {7, {16}, 17, Activation::kElu},        {33, {31, 15, 49}, 3, Activation::kRelu},
      {130, {65, 100}, 70, Activation::kElu}, {5, {200, 128}, 16, Activation::kTanh},
      {20, {512, 33}, 2, Activation::kRelu},
  };
  for (const Isa isa : isas()) {
    for (const NetworkShape& shape : shapes) expect_as_reference(shape, 13, isa);
  }
}

TEST(Network, IsTheReferenceOverSeveralChunks) {
  expect_as_reference({40, {96}, 5, Activation::kTanh}, 401, best_isa());
}

/// Outputs, gradient and dx of some rows, in calls of at most `at_most` rows.
std::vector<float> everything(const NetworkShape& shape, Isa isa, int rows, int at_most) {
  Subject subject(shape, isa);
  const Matrix x = random_rows(rows, shape.inputs, 3), dy = random_rows(rows, shape.outputs, 4);
  std::vector<float> all;
  for (int first = 0; first < rows; first += at_most) {
    const int last = std::min(rows, first + at_most);
    const Matrix some(x.begin() + first, x.begin() + last);
    const Matrix some_dy(dy.begin() + first, dy.begin() + last);
    const std::vector<float> values = flat(some, shape.inputs);
    for (const float y : subject.forward(values, shape.inputs, last - first)) all.push_back(y);
    subject.backward(values, shape.inputs, flat(some_dy, shape.outputs));
  }
  all.insert(all.end(), subject.gradient.begin(), subject.gradient.end());
  return all;
}

TEST(Network, GivesTheSameBitsForAnySplitOfTheRows) {
  for (const Isa isa : isas()) {
    for (const NetworkShape& shape : {NetworkShape{22, {64, 64}, 4, Activation::kTanh},
                                      NetworkShape{300, {130}, 3, Activation::kElu}}) {
      const std::vector<float> whole = everything(shape, isa, 230, 230);
      for (const int at_most : {1, 5, 64, 97, 200}) {
        EXPECT_EQ(whole, everything(shape, isa, 230, at_most)) << name(isa) << " " << at_most;
      }
    }
  }
}

TEST(Network, GivesTheSameBitsOnEverySetWithFusedMultiplyAdd) {
  const std::vector<Isa> sets = fused_isas();
  if (sets.size() < 2) GTEST_SKIP() << "this machine has " << machine_isas();
  for (const Activation activation : {Activation::kTanh, Activation::kRelu, Activation::kElu}) {
    const NetworkShape shape = {150, {70, 512}, 5, activation};
    EXPECT_EQ(everything(shape, sets[0], 59, 59), everything(shape, sets[1], 59, 59));
  }
}

TEST(Network, LeavesPaddingOfParametersAndGradientsAtZero) {
  Subject subject({9, {21, 70}, 3, Activation::kElu}, best_isa());
  const std::vector<float> x = floats_of({random_rows(1, 9 * 20, 1)});
  subject.forward(x, 9, 20);
  subject.backward(x, 9, std::vector<float>(60, 1.0f));
  std::vector<float> again(subject.parameters.size());
  subject.network.set_layers(subject.network.layers(subject.gradient), again);
  EXPECT_EQ(again, subject.gradient) << "what is outside the layers is zero";
}

TEST(Network, KeepsNaNsOfItsInputs) {
  for (const Activation activation : {Activation::kTanh, Activation::kRelu, Activation::kElu}) {
    Subject subject({3, {8}, 1, activation}, best_isa());
    EXPECT_TRUE(std::isnan(subject.forward({0.0f, std::nanf(""), 0.0f}, 3, 1)[0]));
  }
}

TEST(Network, BeginsWithOrthogonalWeights) {
  const Network network({30, {50}, 4, Activation::kTanh}, best_isa());
  std::vector<float> parameters(network.parameter_count());
  network.initialize(parameters, 0.01, 1, 2);
  const auto layers = network.layers(parameters);
  const double gains[] = {2.0, 1e-4};  // squared
  for (std::size_t k = 0; k < layers.size(); ++k) {
    const PolicyLayer& layer = layers[k];
    const bool columns = layer.outputs > layer.inputs;
    const int count = columns ? layer.inputs : layer.outputs;
    const int size = columns ? layer.outputs : layer.inputs;
    for (int a = 0; a < count; ++a) {
      for (int b = 0; b < count; ++b) {
        double sum = 0.0;
        for (int i = 0; i < size; ++i) {
          const auto at = [&](int which) {
            return layer.weight[columns ? i * layer.inputs + which : which * layer.inputs + i];
          };
          sum += at(a) * at(b);
        }
        // Weights are rounded to float.
        EXPECT_NEAR(sum, a == b ? gains[k] : 0.0, 3e-7 * gains[k]);
      }
    }
    for (const double bias : layer.bias) EXPECT_EQ(bias, 0.0);
  }
}

TEST(Network, BeginsWithOtherWeightsForAnotherKey) {
  const Network network({3, {4}, 1, Activation::kTanh}, best_isa());
  std::vector<float> one(network.parameter_count()), two(one), again(one);
  network.initialize(one, 1.0, 1, 2);
  network.initialize(two, 1.0, 2, 2);
  network.initialize(again, 1.0, 1, 2);
  EXPECT_NE(one, two);
  EXPECT_EQ(one, again);
}

TEST(Network, RefusesShapesThatAreNone) {
  EXPECT_THROW(Network({0, {4}, 1, Activation::kTanh}, best_isa()), Error);
  EXPECT_THROW(Network({3, {4, 0}, 1, Activation::kTanh}, best_isa()), Error);
  EXPECT_THROW(Network({3, {4}, 1, Activation::kNone}, best_isa()), Error);
}

TEST(Network, RefusesLayersOfAnotherShape) {
  const Network network({3, {4}, 1, Activation::kTanh}, best_isa());
  const Network other({3, {5}, 1, Activation::kTanh}, best_isa());
  std::vector<float> parameters(other.parameter_count());
  EXPECT_THROW(network.set_layers(other.layers(parameters), parameters), Error);
}

/// Changes with the arithmetic of networks, Adam or initial weights.
TEST(Network, HasTheGoldenHashAfterAFewUpdates) {
  if (fused_isas().empty()) GTEST_SKIP() << "without fused multiply-add the last bits are others";
  for (const Isa isa : fused_isas()) {
    Subject subject({22, {64, 64}, 4, Activation::kTanh}, isa);
    Adam adam(subject.parameters.size(), 0.5, isa);
    std::vector<float> x;
    for (int i = 0; i < 22 * 100; ++i) x.push_back(static_cast<float>(i * 37 % 101 - 50) / 32.0f);
    for (int update = 0; update < 5; ++update) {
      std::fill(subject.gradient.begin(), subject.gradient.end(), 0.0f);
      subject.network.transpose(subject.parameters, subject.transposed);
      subject.backward(x, 22, subject.forward(x, 22, 100));
      const float* const gradient = subject.gradient.data();
      adam.sum({&gradient, 1});
      adam.step(subject.parameters, 1e-3);
    }
    EXPECT_EQ(
        to_hex(hash_bytes(subject.parameters.data(), subject.parameters.size() * sizeof(float))),
        "92aae4b00c494268")
        << name(isa);
  }
}

}  // namespace
}  // namespace skybody::learn
