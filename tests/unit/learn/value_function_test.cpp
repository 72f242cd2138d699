// The value function at the end of a horizon: its targets, training, and contribution to the
// gradient.
#include "learn/gradient/value_function.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/assemble/compile_scenario.h"
#include "core/physics/world/lane_values.h"
#include "learn/gradient/gradient_slice.h"

namespace skybody::learn {
namespace {

constexpr int kSeen = 3, kStride = 16;

Hyperparameters small() {
  Hyperparameters hyper;
  hyper.hidden = {8, 8};
  hyper.rollout_steps = 4;
  hyper.discount = 0.9;
  hyper.gae_lambda = 0.7;
  hyper.max_grad_norm = 0.0;
  return hyper;
}

double wave(int k) { return std::sin(1.3 * k + 0.2); }

/// The sum that the recursion computes: (1 - lambda) lambda^k times the return over k + 1
/// transitions, and the remaining weight times the return over all.
double weighted_returns(const std::vector<double>& gain, const std::vector<double>& value,
                        std::size_t from, double discount, double lambda) {
  double sum = 0.0, gained = 0.0, weight = 1.0, discounted = 1.0;
  for (std::size_t t = from; t < gain.size(); ++t) {
    gained += discounted * gain[t];
    discounted *= discount;
    const bool is_last = t + 1 == gain.size();
    sum += (is_last ? weight : (1.0 - lambda) * weight) * (gained + discounted * value[t]);
    weight *= lambda;
  }
  return sum;
}

TEST(ValueFunction, HasTargetsThatWeighReturnsOverEveryNumberOfTransitions) {
  std::vector<double> gain, value, target(6);
  for (int t = 0; t < 6; ++t) {
    gain.push_back(wave(t));
    value.push_back(3.0 * wave(t + 10));
  }
  td_lambda(gain, value, 0.9, 0.7, target);
  for (std::size_t t = 0; t < 6; ++t) {
    EXPECT_NEAR(target[t], weighted_returns(gain, value, t, 0.9, 0.7), 1e-12);
  }
}

/// Rows of a horizon. Lane 0 continues, lane 1 is terminated after two transitions, lane 2 is
/// truncated after three; the others are inactive.
struct Horizon {
  std::vector<float> observation = std::vector<float>(4 * kGroupLanes * kStride);
  std::vector<float> end = std::vector<float>(kGroupLanes * kStride);
  std::vector<double> gain = std::vector<double>(4 * kGroupLanes);
  std::vector<std::uint32_t> taken = {0b111, 0b111, 0b101, 0b001};

  Horizon() {
    for (std::size_t k = 0; k < observation.size(); ++k) {
      observation[k] = static_cast<float>(wave(static_cast<int>(k)));
    }
    for (std::size_t k = 0; k < end.size(); ++k) {
      end[k] = static_cast<float>(wave(static_cast<int>(k) + 1000));
    }
    for (std::size_t k = 0; k < gain.size(); ++k) gain[k] = wave(static_cast<int>(k) + 2000);
  }
  HorizonRows rows() const {
    return {4, kStride, observation.data(), end.data(), gain.data(), taken, 0b010};
  }
};

/// Value by the delayed copy, which equals the critic before the first update.
double value_of(const ValueFunction& function, const float* x) {
  NetworkActivations memory;
  float y = 0.0f;
  function.network().forward(function.target_parameters(), x, kStride, 1, memory, &y, 1);
  return function.scale() * static_cast<double>(y);
}

TEST(ValueFunction, LearnsTowardsTheTargetsOfEachFlight) {
  const Hyperparameters hyper = small();
  const ValueFunction function(kSeen, hyper, 1);
  const Horizon horizon;
  HorizonValue value(function, hyper, kStride, 0.5, 4 * kGroupLanes);
  value.add(horizon.rows());
  value.find_gradient();
  double loss = 0.0;
  const int steps[] = {4, 2, 3};
  for (std::size_t lane = 0; lane < 3; ++lane) {
    const auto x = [&](int t) {
      return &horizon.observation[(static_cast<std::size_t>(t) * kGroupLanes + lane) * kStride];
    };
    std::vector<double> gain, next;
    for (int t = 0; t < steps[lane]; ++t) {
      const bool is_last = t + 1 == steps[lane];
      gain.push_back(horizon.gain[static_cast<std::size_t>(t) * kGroupLanes + lane]);
      next.push_back(!is_last    ? value_of(function, x(t + 1))
                     : lane == 1 ? 0.0
                                 : value_of(function, &horizon.end[lane * kStride]));
    }
    for (int t = 0; t < steps[lane]; ++t) {
      const double error = (value_of(function, x(t)) -
                            weighted_returns(gain, next, static_cast<std::size_t>(t), 0.9, 0.7)) /
                           function.scale();
      loss += 0.5 * 0.5 * error * error;
    }
  }
  EXPECT_NEAR(value.loss(), loss, 1e-5 * loss);  // floats
}

/// Many steps on the same rows: the loss becomes much smaller.
TEST(ValueFunction, FitsItsTargets) {
  Hyperparameters hyper = small();
  hyper.learning_rate = 1e-2;
  ValueFunction function(kSeen, hyper, 1);
  const Horizon horizon;
  HorizonValue value(function, hyper, kStride, 0.1, 4 * kGroupLanes);
  value.add(horizon.rows());
  value.find_gradient();
  const double before = value.loss();
  const float* gradient[] = {value.gradient().data()};
  for (int k = 0; k < 500; ++k) {
    function.step(gradient, hyper.learning_rate);
    value.find_gradient();
  }
  EXPECT_LT(value.loss(), 0.01 * before);
}

TEST(ValueFunction, HasSlopesThatAreItsDifferences) {
  const Hyperparameters hyper = small();
  const ValueFunction function(kSeen, hyper, 1);
  Horizon horizon;
  HorizonValue value(function, hyper, kStride, 1.0, 4 * kGroupLanes);
  const std::vector<float> slopes(value.slopes(horizon.end.data()),
                                  value.slopes(horizon.end.data()) + kGroupLanes * kStride);
  double largest = 0.0;
  for (const float s : slopes) largest = std::max(largest, std::abs(static_cast<double>(s)));
  ASSERT_GT(largest, 0.0);
  for (std::size_t lane : {0u, 7u, 31u}) {
    for (std::size_t k = 0; k < kSeen; ++k) {
      float& x = horizon.end[lane * kStride + k];
      const float here = x;
      x = here + 0x1p-6f;
      const double above = value_of(function, &horizon.end[lane * kStride]);
      x = here - 0x1p-6f;
      const double below = value_of(function, &horizon.end[lane * kStride]);
      x = here;
      // second-order error of a difference over 2^-5, and floats
      EXPECT_NEAR(slopes[lane * kStride + k], (above - below) / 0x1p-5, 2e-3 * largest);
    }
  }
}

/// Flights of four transitions whose only return is the value at their end.
class EndOfFlights : public ::testing::Test {
 protected:
  static constexpr int kEnvs = 8;

  EndOfFlights()
      : compiled(load()),
        seen(compiled->observation_size()),
        hyper(with_value()),
        network({seen, {}}, compiled->action_size(), hyper, 0, best_isa()),
        parameters(network.parameter_count()),
        function(seen, hyper, 3),
        mean(static_cast<std::size_t>(seen), 0.1),
        scale(static_cast<std::size_t>(seen), 0.8),
        first(compiled, hyper, network, 2, 0, kEnvs, &function, nullptr) {
    network.initialize(parameters, 0.3, 1, 0);
  }
  static std::shared_ptr<const CompiledScenario> load() {
    LoadOptions options;
    options.scenario = "hover_learn";
    options.overrides = {"stepping.dt=0.005", "stepping.action_repeat=4"};
    return compile_scenario(options);
  }
  static Hyperparameters with_value() {
    Hyperparameters h = small();
    h.envs = kEnvs;
    h.goal_weight = 0.0;
    h.end_value_weight = 2.0;
    return h;
  }

  /// Flies from the start again; the slice then holds gradient and last observations.
  void fly(GradientSlice& slice) {
    PolicyNetwork::Transposed transposed;
    network.transpose(parameters, transposed);
    slice.run({parameters, &transposed, mean, scale, 1000});
  }

  double objective() {
    GradientSlice slice(compiled, hyper, network, 2, 0, kEnvs, &function, &first);
    fly(slice);
    std::vector<float> observations;
    const auto take = [&](const std::string& name, const auto* values, std::size_t count) {
      if (name == "slice.observations") observations.assign(values, values + count);
    };
    GradientSlice::visit(slice, "slice", take);
    const int stride = (seen + 15) / 16 * 16;
    double sum = 0.0;
    for (int env = 0; env < kEnvs; ++env) {
      std::vector<float> x(static_cast<std::size_t>(stride));
      for (int k = 0; k < seen; ++k) {
        const auto at = static_cast<std::size_t>(env * seen + k);
        x[static_cast<std::size_t>(k)] =
            static_cast<float>((static_cast<double>(observations[at]) - 0.1) * 0.8);
      }
      NetworkActivations memory;
      float y = 0.0f;
      function.network().forward(function.target_parameters(), x.data(), stride, 1, memory, &y, 1);
      sum += function.scale() * static_cast<double>(y);
    }
    return -2.0 * std::pow(0.9, 4) * sum / (kEnvs * 4);
  }

  std::shared_ptr<const CompiledScenario> compiled;
  int seen;
  Hyperparameters hyper;
  PolicyNetwork network;
  std::vector<float> parameters;
  ValueFunction function;
  std::vector<double> mean, scale;
  GradientSlice first;
};

TEST_F(EndOfFlights, GivesThePolicyTheDifferencesOfTheValueThere) {
  fly(first);
  const std::vector<float> gradient(first.gradient().begin(), first.gradient().end());
  double largest = 0.0;
  for (const float g : gradient) largest = std::max(largest, std::abs(static_cast<double>(g)));
  ASSERT_GT(largest, 0.0);
  int compared = 0;
  for (std::size_t k = 0; k < gradient.size() && compared < 6; ++k) {
    if (std::abs(static_cast<double>(gradient[k])) < 0.3 * largest) continue;
    const float here = parameters[k];
    parameters[k] = here + 0x1p-7f;
    const double above = objective();
    parameters[k] = here - 0x1p-7f;
    const double below = objective();
    parameters[k] = here;
    // Observations are floats; rotors that speed up faster than they slow down make kinks.
    EXPECT_NEAR(gradient[k], (above - below) / 0x1p-6, 0.03 * largest);
    ++compared;
  }
  EXPECT_GT(compared, 2);
}

}  // namespace
}  // namespace skybody::learn
