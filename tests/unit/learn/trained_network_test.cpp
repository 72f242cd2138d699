// A network with its optimiser: its gradient against finite differences, and a fit.
#include "learn/network/trained_network.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace skybody::learn {
namespace {

constexpr int kInputs = 3, kOutputs = 2, kRows = 5;

std::vector<float> inputs() {
  std::vector<float> x(kRows * kInputs);
  for (std::size_t k = 0; k < x.size(); ++k) x[k] = static_cast<float>(std::sin(1.7 * k));
  return x;
}

/// Half the sum of squared outputs, whose gradient at the outputs are the outputs.
double loss(TrainedNetwork& network, const std::vector<float>& x) {
  std::vector<float> y(kRows * kOutputs);
  network.forward(x.data(), kInputs, kRows, y.data());
  double sum = 0.0;
  for (const float value : y) sum += 0.5 * static_cast<double>(value) * static_cast<double>(value);
  return sum;
}

TEST(TrainedNetwork, GradientAtItsInputsIsThatOfFiniteDifferences) {
  TrainedNetwork network({kInputs, {8}, kOutputs});
  network.initialize(1.0, 4, 5);
  std::vector<float> x = inputs(), y(kRows * kOutputs), dx(x.size());
  network.forward(x.data(), kInputs, kRows, y.data());
  network.backward(x.data(), kInputs, y.data(), dx.data());
  for (std::size_t k = 0; k < x.size(); ++k) {
    constexpr float kStep = 1e-2f;  // float outputs: smaller steps drown in rounding
    std::vector<float> more = x, less = x;
    more[k] += kStep;
    less[k] -= kStep;
    const double slope = (loss(network, more) - loss(network, less)) / (2.0 * kStep);
    EXPECT_NEAR(dx[k], slope, 1e-3) << k;
  }
}

TEST(TrainedNetwork, StepsDownTheGradientAndForgetsIt) {
  TrainedNetwork network({kInputs, {8}, kOutputs});
  network.initialize(1.0, 4, 5);
  const std::vector<float> x = inputs();
  const double before = loss(network, x);
  std::vector<float> y(kRows * kOutputs);
  for (int k = 0; k < 100; ++k) {
    network.forward(x.data(), kInputs, kRows, y.data());
    network.backward(x.data(), kInputs, y.data());
    EXPECT_GT(network.step(1e-2), 0.0);
  }
  EXPECT_LT(loss(network, x), 0.01 * before);
  EXPECT_EQ(network.step(1e-2), 0.0) << "no gradient was added since";
}

}  // namespace
}  // namespace skybody::learn
