// A slice's backward pass through a horizon.
#include <cmath>

#include "core/base/simd/fp_environment.h"
#include "core/base/simd/lane_mask.h"
#include "learn/gradient/gradient_slice.h"

namespace skybody::learn {
namespace {

constexpr double kMostGradient = 1e15;  // of a cost by an action, whose range is 2

}  // namespace

void GradientSlice::go_back(Group& group, const GradientInputs& inputs) {
  {
    const FpEnvironment guard;
    adjoint_.begin(group.state, group.lanes);
  }
  slopes_.adjoints.fill_zero();
  const float* value_slopes = value_ != nullptr ? value_->slopes(inputs_.end(0)) : nullptr;
  double* const motion = slopes_.adjoints.data() +
                         static_cast<std::ptrdiff_t>(adjoint_.goal_motion_row()) * kGroupLanes;
  for (int t = horizon_; t-- > 0;) {
    const std::uint32_t lanes = flight_.sound[static_cast<std::size_t>(t)];
    {
      const FpEnvironment guard;
      slopes_.cost.fill_zero();
      const double weight =
          weights_.goal * weights_.transition * weights_.discounts[static_cast<std::size_t>(t)];
      cost_.add(lanes, weight, adjoint_.goal_motion(t), goal_at(t), motion, slopes_.cost.data(),
                slopes_.distance.data(), isa_);
      set_reward(t, lanes);
      if (value_slopes != nullptr) {
        const double end = weights_.end * weights_.discounts[static_cast<std::size_t>(t + 1)] *
                           weights_.transition;
        add_observations(value_slopes, inputs_.width(), -end, ending(t) & ~flight_.terminated,
                         inputs);
      }
      adjoint_.pull_back(group.state, t, lanes, slopes_.adjoints.data(), slopes_.to_action.data());
    }
    each_lane(lanes, [&](int l) {
      const auto lane = static_cast<std::size_t>(l);
      sums_[kSumDistance] += slopes_.distance[lane];
      sums_[kSumCost] += slopes_.cost[lane];
      flight_.gain[static_cast<std::size_t>(t * kGroupLanes + l)] -=
          slopes_.cost[lane] /
          (weights_.transition * weights_.discounts[static_cast<std::size_t>(t)]);
    });
    pull_back_network(group, inputs, t);
    if (t > 0)
      add_observations(slopes_.inputs.data(), compiled_->observation_size(), 1.0, lanes, inputs);
  }
}

/// Gradients at the parameters and at the observation, from those at the actions. Pixels have none:
/// images count as given. With images the layers' outputs are computed a second time, because
/// those of a whole horizon are many times as large as its images.
void GradientSlice::pull_back_network(const Group& group, const GradientInputs& inputs, int t) {
  const PolicySteps steps = steps_of(group, t);
  PolicyNetwork::Memory& memory = memory_of(t);
  const float* const x = inputs_.row(t, 0);
  if (inputs_.has_images()) {
    network_.forward(inputs.parameters, x, inputs_.stride(), steps, memory, slopes_.outputs.data(),
                     actions_);
  }
  add_actions(t, flight_.sound[static_cast<std::size_t>(t)]);
  network_.backward(*inputs.transposed, x, inputs_.stride(), steps, memory, slopes_.outputs.data(),
                    actions_, {gradient_.data(), gradient_.size()}, slopes_.inputs.data(),
                    inputs_.stride());
}

void GradientSlice::update_value() {
  if (value_ == nullptr) return;
  value_->add({horizon_, inputs_.stride(), inputs_.row(0, 0), inputs_.end(0), flight_.gain.data(),
               flight_.sound, flight_.terminated});
}

void GradientSlice::set_reward(int t, std::uint32_t lanes) {
  if (weights_.reward == 0.0) return;
  const double weight =
      weights_.reward * weights_.transition * weights_.discounts[static_cast<std::size_t>(t)];
  double* const to =
      slopes_.adjoints.data() + static_cast<std::ptrdiff_t>(adjoint_.reward_row()) * kGroupLanes;
  each_lane(lanes, [&](int l) { to[l] = -weight; });
}

/// Gradients at the network's outputs, from the gradients at the actions and at the changes of
/// actions.
void GradientSlice::add_actions(int t, std::uint32_t lanes) {
  slopes_.outputs.fill_zero();
  const double weight = 2.0 * GoalCost::kSmoothness * weights_.goal * weights_.transition;
  const double smooth = weight * weights_.discounts[static_cast<std::size_t>(t)];
  const double next = weight * weights_.discounts[static_cast<std::size_t>(t + 1)];
  each_lane(lanes, [&](int l) {
    const float* now = action(t, l);
    for (int k = 0; k < actions_; ++k) {
      const double a = static_cast<double>(now[k]);
      double to = slopes_.to_action[static_cast<std::size_t>(k * kGroupLanes + l)];
      if (t > 0) to += smooth * (a - static_cast<double>(action(t - 1, l)[k]));
      if (t + 1 < horizon_ && (flight_.sound[static_cast<std::size_t>(t + 1)] >> l & 1u) != 0) {
        to += next * (a - static_cast<double>(action(t + 1, l)[k]));
      }
      to *= 1.0 - a * a;
      // A flight whose derivatives blow up is left out, so that it does not spoil the others: sums
      // of squares are floats. A NaN fails the comparison.
      slopes_.outputs[static_cast<std::size_t>(l * actions_ + k)] =
          static_cast<float>(std::abs(to) < kMostGradient ? to : 0.0);
    }
  });
}

/// Adds derivatives at the task's values, from slopes at the first `count` inputs of a network.
void GradientSlice::add_observations(const float* slopes, int count, double weight,
                                     std::uint32_t lanes, const GradientInputs& inputs) {
  double* const to = slopes_.adjoints.data() +
                     static_cast<std::ptrdiff_t>(adjoint_.observation_row()) * kGroupLanes;
  for (int k = 0; k < count; ++k) {
    const int row = inputs_.task_row(k);
    if (row < 0) continue;
    const double scale = weight * inputs.scale[static_cast<std::size_t>(k)];
    each_lane(lanes, [&](int l) {
      to[row * kGroupLanes + l] =
          scale * static_cast<double>(slopes[static_cast<std::size_t>(l * inputs_.stride() + k)]);
    });
  }
}

}  // namespace skybody::learn
