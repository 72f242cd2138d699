// The hand-written adjoint of a free robot's step against forward mode: the engine's own step on
// dual numbers. The two share only the laws of the step.
#include "core/physics/step/step_adjoint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/assemble/compile_scenario.h"
#include "core/base/math/dual.h"
#include "core/physics/step/free_robot_step.h"

namespace skybody {

/// Values, each followed by its tangent.
template <>
class LaneValues<Dual<double>> {
 public:
  explicit LaneValues(const Dual<double>* data) : data_(data) {}
  Dual<double> operator[](int k) const { return data_[k]; }
  LaneValues operator+(int k) const { return LaneValues(data_ + k); }

 private:
  const Dual<double>* data_;
};
template <>
class HeldLanes<Dual<double>> {
 public:
  bool has(int) const { return false; }
  LaneValues<Dual<double>> operator[](int) const { return LaneValues<Dual<double>>(nullptr); }
};

namespace {

using Number = Dual<double>;
constexpr int kStates = 17, kInputs = 21;  // q, u, rotor speeds; these and commands

std::shared_ptr<const CompiledScenario> load(const std::string& name) {
  LoadOptions options;
  options.scenario = name;
  return compile_scenario(options);
}

std::vector<Number> constants(const double* values, std::size_t count) {
  std::vector<Number> out;
  for (std::size_t k = 0; k < count; ++k) out.emplace_back(values[k]);
  return out;
}

/// The state after a step from inputs with tangents: tangents of q, u, rotor speeds.
std::vector<Number> step(const StepPlan& plan, const std::vector<double>& params,
                         const std::vector<Number>& inputs) {
  std::vector<double> derived(static_cast<std::size_t>(plan.derived.size));
  derive_rotors(plan.world, plan.derived, params.data(),
                [&](int k, double value) { derived[static_cast<std::size_t>(k)] = value; });
  make_body_constants(plan.world, params.data(), derived.data() + plan.derived.bodies);
  const std::vector<Number> own = constants(params.data(), params.size());
  const std::vector<Number> made = constants(derived.data(), derived.size());
  using Values = LaneValues<Number>;
  const FreeStepInputs<Number, Values> in{Values(&inputs[13]),
                                          Values(&inputs[17]),
                                          Values(nullptr),
                                          {},
                                          Values(own.data()),
                                          Values(made.data() + plan.derived.lags),
                                          Values(made.data() + plan.derived.factors),
                                          Values(made.data() + plan.derived.bodies)};
  FreeMotion<Number> m;
  Number speeds[4];
  const auto start = [&] {
    const Values q(inputs.data()), u(&inputs[7]);
    return FreeMotion<Number>{load_vec3(q), load_quat(q + 3), load_vec3(u), load_vec3(u + 3)};
  };
  FreeRobotStep<Number, Values, FreeKind::kQuadrotor, HeldInputSet::kNothing, SpinKind::kAny>(
      *plan.free_robots, plan.free_robots->robots[0], in)
      .advance<IntegratorChoice::kMidpoint>(start, m, speeds);
  return {m.position.x, m.position.y, m.position.z, m.rotation.w, m.rotation.x, m.rotation.y,
          m.rotation.z, m.velocity.x, m.velocity.y, m.velocity.z, m.spin.x,     m.spin.y,
          m.spin.z,     speeds[0],    speeds[1],    speeds[2],    speeds[3]};
}

/// A wild state and commands, some of them beyond a rotor's limits.
/// @param spin  approximate spin [rad/s]
std::vector<double> wild_inputs(std::mt19937_64& random, double spin) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> speed(300, 2200), command(-300, 2800);
  std::vector<double> x(kInputs);
  for (int k = 0; k < 13; ++k) x[static_cast<std::size_t>(k)] = 3.0 * normal(random);
  for (std::size_t k = 10; k < 13; ++k) x[k] *= spin / 3.0;
  double norm = 0.0;
  for (std::size_t k = 3; k < 7; ++k) norm += x[k] * x[k];
  for (std::size_t k = 3; k < 7; ++k) x[k] /= std::sqrt(norm);
  for (std::size_t k = 13; k < 17; ++k) x[k] = speed(random);
  for (std::size_t k = 17; k < 21; ++k) x[k] = command(random);
  return x;
}

/// Constants that other tests of the step leave at zero: a centre of mass beside the axis, products
/// of inertia, another mass, hubs that form no rectangle.
std::vector<double> odd_params(const World& world) {
  std::vector<double> params = world.layout.nominal_params();
  const auto body = static_cast<std::size_t>(world.layout.body_params[0]);
  params[body + kMass] *= 1.1;
  params[body + kCom] = 0.02;
  params[body + kCom + 1] = -0.01;
  params[body + kCom + 2] = 0.03;
  params[static_cast<std::size_t>(world.layout.rotor_params[1]) + kRotorPosition] += 0.02;
  params[static_cast<std::size_t>(world.layout.robot_params[0]) + kDisturbanceForce] = 0.7;
  return params;
}

/// @param spin  of the lanes; every fourth turns slowly
void expect_adjoint_is_transpose(const std::vector<double>& params, const World& world,
                                 double spin = 3.0) {
  const StepPlan plan(world, DynamicsBackend::kTree);
  const StepAdjoint adjoint(world);
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  AlignedArray<double> derived = adjoint.make_derived();
  AlignedArray<double> all(params.size() * kGroupLanes), values(kInputs * kGroupLanes);
  AlignedArray<double> adjoints(kInputs * kGroupLanes);
  for (std::size_t k = 0; k < params.size(); ++k) {
    for (std::size_t l = 0; l < kGroupLanes; ++l) all[k * kGroupLanes + l] = params[k];
  }
  std::vector<std::vector<double>> inputs, weights;
  for (std::size_t l = 0; l < kGroupLanes; ++l) {
    inputs.push_back(wild_inputs(random, l % 4 == 0 ? 3.0 : spin));
    weights.emplace_back(kInputs, 0.0);
    for (std::size_t k = 0; k < kInputs; ++k) {
      // Rotor speeds are a thousand times as large, so smaller weights give them a similar effect.
      weights[l][k] = k < 17 ? normal(random) * (k < 13 ? 1.0 : 1e-3) : 0.0;
      values[k * kGroupLanes + l] = inputs[l][k];
      adjoints[k * kGroupLanes + l] = weights[l][k];
    }
  }
  const std::uint32_t served = 0x7fffffffu;  // the last lane is inactive
  adjoint.derive(all.data(), ~0u, derived);
  adjoint.pull_back(values.data(), all.data(), derived, served, adjoints.data());
  for (std::size_t l = 0; l < kGroupLanes; ++l) {
    for (std::size_t j = 0; j < kInputs; ++j) {
      std::vector<Number> x = constants(inputs[l].data(), kInputs);
      x[j].tangent = 1.0;
      const std::vector<Number> after = step(plan, params, x);
      double expected = 0.0, size = 0.0;
      for (std::size_t k = 0; k < kStates; ++k) {
        expected += weights[l][k] * after[k].tangent;
        size += std::abs(weights[l][k] * after[k].tangent);
      }
      if (l == 31) expected = weights[l][j];
      // A few hundred roundings of terms of this size.
      EXPECT_NEAR(adjoints[j * kGroupLanes + l], expected, 1e-12 * (size + 1.0))
          << "input " << j << ", lane " << l;
    }
  }
}

TEST(StepAdjoint, IsTheTransposeOfForwardModeOfAPlainQuadrotor) {
  const auto compiled = load("hover_learn");
  expect_adjoint_is_transpose(compiled->layout().nominal_params(), compiled->world());
}

TEST(StepAdjoint, IsTheTransposeWithAnOddBodyAndOddRotors) {
  const auto compiled = load("hover_learn");
  expect_adjoint_is_transpose(odd_params(compiled->world()), compiled->world());
}

// 60 to 40,000 rad/s at 1 ms: one part of torque-free motion, several, and more than the maximum.
TEST(StepAdjoint, IsTheTransposeWhereLanesSpinFast) {
  const auto compiled = load("hover_learn");
  for (const double spin : {60.0, 500.0, 40000.0}) {
    expect_adjoint_is_transpose(compiled->layout().nominal_params(), compiled->world(), spin);
    expect_adjoint_is_transpose(odd_params(compiled->world()), compiled->world(), spin);
  }
}

TEST(StepAdjoint, SaysWhichWorldsItKnows) {
  EXPECT_TRUE(StepAdjoint(load("hover_learn")->world()).has_closed_form());
  EXPECT_FALSE(StepAdjoint(load("payload")->world()).has_closed_form());
}

}  // namespace
}  // namespace skybody
