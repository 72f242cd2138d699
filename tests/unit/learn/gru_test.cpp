// The oracle is the layer in double, written unit by unit, and finite differences of it.
#include "learn/network/gru.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/math/hash.h"
#include "core/base/system/error.h"
#include "learn/network/recurrent_network.h"
#include "tests/unit/learn/isas.h"

namespace skybody::learn {
namespace {

float wave(std::size_t i, double shift) {
  return static_cast<float>(std::sin(0.37 * static_cast<double>(i * i % 1009) + shift));
}

std::vector<float> waves(int count, double shift) {
  std::vector<float> values;
  for (int i = 0; i < count; ++i) values.push_back(wave(static_cast<std::size_t>(i), shift));
  return values;
}

double sigmoid(double x) { return 1.0 / (1.0 + std::exp(-x)); }

/// The states after each step of one sequence.
std::vector<std::vector<double>> reference(const PolicyLayer& layer, const float* x, int steps,
                                           const std::uint8_t* begins, std::vector<double> state) {
  const int units = layer.outputs;
  std::vector<std::vector<double>> all;
  for (int t = 0; t < steps; ++t) {
    if (begins[t] != 0) state.assign(state.size(), 0.0);
    const auto sum = [&](const std::vector<double>& weight, const std::vector<double>& bias,
                         int row, const auto& in, int size) {
      double s = bias[row];
      for (int i = 0; i < size; ++i) s += weight[row * size + i] * static_cast<double>(in[i]);
      return s;
    };
    std::vector<double> next;
    for (int u = 0; u < units; ++u) {
      double a[3], c[3];
      for (int gate = 0; gate < 3; ++gate) {
        a[gate] =
            sum(layer.weight, layer.bias, gate * units + u, x + t * layer.inputs, layer.inputs);
        c[gate] = sum(layer.state_weight, layer.state_bias, gate * units + u, state, units);
      }
      const double r = sigmoid(a[0] + c[0]), z = sigmoid(a[1] + c[1]);
      const double n = std::tanh(a[2] + r * c[2]);
      next.push_back((1.0 - z) * n + z * state[u]);
    }
    state = next;
    all.push_back(state);
  }
  return all;
}

/// A layer with parameters and sequences, one of which restarts in the middle.
struct Subject {
  Gru gru;
  Sequences sequences;
  std::vector<float> parameters, x, dy, states;
  std::vector<std::uint8_t> begins;
  GruActivations memory;
  TransposedGru transposed;

  Subject(int inputs, int units, const Sequences& s, Isa isa)
      : gru(inputs, units, isa),
        sequences(s),
        parameters(gru.parameter_count()),
        x(waves(s.rows() * inputs, 0.1)),
        dy(waves(s.rows() * units, 0.2)),
        states(static_cast<std::size_t>(s.count * gru.state_stride())),
        begins(static_cast<std::size_t>(s.rows())) {
    gru.initialize(parameters, 3, 4);
    PolicyLayer layer = gru.layer(parameters);
    for (std::size_t k = 0; k < layer.bias.size(); ++k) {
      layer.bias[k] = static_cast<double>(0.3f * wave(k, 0.5));
      layer.state_bias[k] = static_cast<double>(0.3f * wave(k, 0.6));
    }
    gru.set_layer(layer, parameters);
    gru.transpose(parameters, transposed);
    for (int k = 0; k < s.count; ++k) {
      for (int u = 0; u < units; ++u) {
        states[static_cast<std::size_t>(k * gru.state_stride() + u)] = 0.5f * wave(u + 7 * k, 1.0);
      }
    }
    if (s.steps > 2) begins[static_cast<std::size_t>(s.steps / 2)] = 1;
  }

  std::vector<double> state_of(int sequence) const {
    const float* first = states.data() + sequence * gru.state_stride();
    return {first, first + gru.units()};
  }
  void forward() {
    gru.forward(parameters, x.data(), gru.inputs(), sequences, begins.data(), states.data(),
                memory);
  }
  /// The gradient with respect to the parameters, then to the inputs.
  std::vector<float> backward() {
    std::vector<float> gradient(parameters.size()), dx(x.size());
    gru.backward(transposed, x.data(), gru.inputs(), begins.data(), memory, dy.data(), gru.units(),
                 gradient, dx.data(), gru.inputs());
    gradient.insert(gradient.end(), dx.begin(), dx.end());
    return gradient;
  }
};

TEST(Gru, IsTheReferenceForAnySizes) {
  struct Size {
    int inputs, units, count, steps;
  };
  for (const Isa isa : isas()) {
    for (const Size& size : {Size{3, 5, 2, 4}, Size{22, 64, 7, 9}, Size{1, 1, 1, 1},
                             Size{17, 70, 13, 3}, Size{5, 16, 3, 1}}) {
      Subject subject(size.inputs, size.units, {size.count, size.steps}, isa);
      std::vector<std::vector<std::vector<double>>> wanted;
      for (int s = 0; s < size.count; ++s) {
        wanted.push_back(reference(subject.gru.layer(subject.parameters),
                                   subject.x.data() + s * size.steps * size.inputs, size.steps,
                                   subject.begins.data() + s * size.steps, subject.state_of(s)));
      }
      subject.forward();
      for (int s = 0; s < size.count; ++s) {
        for (int t = 0; t < size.steps; ++t) {
          const float* row =
              subject.memory.outputs.data() + (s * size.steps + t) * subject.gru.state_stride();
          for (int u = 0; u < size.units; ++u) {
            // States are below 1 and decaying: errors of float sums of up to 92 terms do not
            // accumulate.
            ASSERT_NEAR(static_cast<double>(row[u]), wanted[s][t][u], 2e-6)
                << name(isa) << " " << size.units << " units, step " << t;
          }
        }
        // The returned states are those after the last step.
        EXPECT_EQ(subject.state_of(s)[0],
                  static_cast<double>(subject.memory.outputs[static_cast<std::size_t>(
                      (s * size.steps + size.steps - 1) * subject.gru.state_stride())]));
      }
    }
  }
}

TEST(Gru, HasTheGradientOfFiniteDifferences) {
  Subject subject(3, 5, {2, 6}, best_isa());
  const PolicyLayer layer = subject.gru.layer(subject.parameters);
  const std::vector<double> begin[] = {subject.state_of(0), subject.state_of(1)};
  const auto loss = [&](const PolicyLayer& changed) {
    double sum = 0.0;
    for (int s = 0; s < 2; ++s) {
      const auto states =
          reference(changed, subject.x.data() + s * 18, 6, subject.begins.data() + s * 6, begin[s]);
      for (int t = 0; t < 6; ++t) {
        for (int u = 0; u < 5; ++u) {
          sum += states[t][u] * static_cast<double>(subject.dy[(s * 6 + t) * 5 + u]);
        }
      }
    }
    return sum;
  };
  subject.forward();
  std::vector<float> gradient = subject.backward();
  gradient.resize(subject.parameters.size());
  const PolicyLayer ours = subject.gru.layer(gradient);
  for (const auto member : {&PolicyLayer::weight, &PolicyLayer::bias, &PolicyLayer::state_weight,
                            &PolicyLayer::state_bias}) {
    for (std::size_t k = 0; k < (layer.*member).size(); ++k) {
      PolicyLayer above = layer, below = layer;
      (above.*member)[k] += 1e-5;
      (below.*member)[k] -= 1e-5;
      // Ours are float sums over twelve rows of slopes below 1.
      EXPECT_NEAR((ours.*member)[k], (loss(above) - loss(below)) / 2e-5, 3e-6);
    }
  }
}

/// All outputs of forward() and backward() for a subject's sequences, in calls of at most `at_most`
/// of them.
std::vector<float> everything(int inputs, int units, const Sequences& all, int at_most, Isa isa) {
  Subject subject(inputs, units, all, isa);
  std::vector<float> gradient(subject.parameters.size()), dx(subject.x.size()), result;
  for (int first = 0; first < all.count; first += at_most) {
    const Sequences some = {std::min(at_most, all.count - first), all.steps};
    const int row = first * all.steps;
    const float* x = subject.x.data() + row * inputs;
    const std::uint8_t* begins = subject.begins.data() + row;
    subject.gru.forward(subject.parameters, x, inputs, some, begins,
                        subject.states.data() + first * subject.gru.state_stride(), subject.memory);
    subject.gru.backward(subject.transposed, x, inputs, begins, subject.memory,
                         subject.dy.data() + row * units, units, gradient, dx.data() + row * inputs,
                         inputs);
  }
  result.insert(result.end(), subject.states.begin(), subject.states.end());
  result.insert(result.end(), gradient.begin(), gradient.end());
  result.insert(result.end(), dx.begin(), dx.end());
  return result;
}

TEST(Gru, GivesTheSameBitsForAnySplitOfTheSequences) {
  for (const Isa isa : isas()) {
    const std::vector<float> whole = everything(22, 70, {17, 11}, 17, isa);
    for (const int at_most : {1, 4, 9}) {
      EXPECT_EQ(whole, everything(22, 70, {17, 11}, at_most, isa)) << name(isa) << " " << at_most;
    }
  }
}

TEST(Gru, GivesTheSameBitsOnEverySetWithFusedMultiplyAdd) {
  const std::vector<Isa> sets = fused_isas();
  if (sets.size() < 2) GTEST_SKIP() << "this machine has " << machine_isas();
  EXPECT_EQ(everything(22, 70, {9, 5}, 9, sets[0]), everything(22, 70, {9, 5}, 9, sets[1]));
}

TEST(Gru, GoesOnFromTheStatesOfTheCallBefore) {
  Subject whole(6, 20, {3, 1}, best_isa()), parts(6, 20, {3, 1}, best_isa());
  const std::vector<float> x = waves(3 * 4 * 6, 0.7);  // three sequences of four steps
  whole.gru.forward(whole.parameters, x.data(), 6, {3, 4}, nullptr, whole.states.data(),
                    whole.memory);
  for (int t = 0; t < 4; ++t) {
    parts.gru.forward(parts.parameters, x.data() + t * 6, 4 * 6, {3, 1}, nullptr,
                      parts.states.data(), parts.memory);
  }
  EXPECT_EQ(whole.states, parts.states);
}

TEST(Gru, LeavesPaddingOfStatesAndGradientsAtZero) {
  Subject subject(3, 5, {4, 6}, best_isa());
  subject.forward();
  std::vector<float> gradient = subject.backward(), again(subject.parameters.size());
  gradient.resize(subject.parameters.size());
  subject.gru.set_layer(subject.gru.layer(gradient), again);
  EXPECT_EQ(again, gradient);
  for (std::size_t k = 0; k < subject.states.size(); ++k) {
    if (k % 16 >= 5) {
      EXPECT_EQ(subject.states[k], 0.0f);
    }
  }
}

/// Changes with the arithmetic. Independent of the C library: all numbers are multiples of 1/32.
TEST(Gru, HasItsGoldenHash) {
  if (fused_isas().empty()) GTEST_SKIP() << "without fused multiply-add the last bits are others";
  for (const Isa isa : fused_isas()) {
    const Gru gru(9, 20, isa);
    std::vector<float> parameters(gru.parameter_count()), x, gradient(parameters.size());
    gru.initialize(parameters, 3, 4);
    for (int i = 0; i < 5 * 7 * 20; ++i) x.push_back(static_cast<float>(i * 37 % 101 - 50) / 32.0f);
    std::vector<float> states(static_cast<std::size_t>(5 * gru.state_stride()));
    GruActivations memory;
    TransposedGru transposed;
    gru.transpose(parameters, transposed);
    gru.forward(parameters, x.data(), 9, {5, 7}, nullptr, states.data(), memory);
    gru.backward(transposed, x.data(), 9, nullptr, memory, x.data(), 20, gradient);
    gradient.insert(gradient.end(), states.begin(), states.end());
    EXPECT_EQ(to_hex(hash_bytes(gradient.data(), gradient.size() * sizeof(float))),
              "bd4f9aab4f0a15ae")
        << name(isa);
  }
}

TEST(Gru, RefusesSizesThatAreNone) {
  EXPECT_THROW(Gru(0, 4, best_isa()), Error);
  EXPECT_THROW(Gru(4, 0, best_isa()), Error);
}

TEST(RecurrentNetwork, GivesBackTheLayersThatItWasGiven) {
  const RecurrentNetwork network({4, 10, {12}, 3, Activation::kElu}, best_isa());
  std::vector<float> parameters(network.parameter_count()), again(parameters.size());
  network.initialize(parameters, 0.5, 1, 2);
  const auto layers = network.layers(parameters);
  ASSERT_EQ(layers.size(), 3u);
  EXPECT_EQ(layers[0].kind, LayerKind::kGru);
  network.set_layers(layers, again);
  EXPECT_EQ(parameters, again);
  const RecurrentNetwork other({4, 11, {12}, 3, Activation::kElu}, best_isa());
  std::vector<float> more(other.parameter_count());
  EXPECT_THROW(other.set_layers(layers, more), Error);
  EXPECT_THROW(other.set_layers({}, more), Error);
}

}  // namespace
}  // namespace skybody::learn
