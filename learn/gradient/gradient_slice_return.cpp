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
  adjoints_.fill_zero();
  const float* slopes = value_ != nullptr ? value_->slopes(end_x_.data()) : nullptr;
  double* const motion =
      adjoints_.data() + static_cast<std::ptrdiff_t>(adjoint_.goal_motion_row()) * kGroupLanes;
  for (int t = horizon_; t-- > 0;) {
    const std::uint32_t lanes = sound_[static_cast<std::size_t>(t)];
    {
      const FpEnvironment guard;
      cost_row_.fill_zero();
      const double weight = goal_weight_ * weight_ * discounts_[static_cast<std::size_t>(t)];
      cost_.add(lanes, weight, adjoint_.goal_motion(t), goal_at(t), motion, cost_row_.data(),
                distance_.data(), isa_);
      set_reward(t, lanes);
      if (slopes != nullptr) {
        const double end = end_weight_ * discounts_[static_cast<std::size_t>(t + 1)] * weight_;
        add_observations(slopes, -end, ending(t) & ~terminated_, inputs);
      }
      adjoint_.pull_back(group.state, t, lanes, adjoints_.data(), to_action_.data());
    }
    each_lane(lanes, [&](int l) {
      const auto lane = static_cast<std::size_t>(l);
      sums_[kSumDistance] += distance_[lane];
      sums_[kSumCost] += cost_row_[lane];
      gain_[static_cast<std::size_t>(t * kGroupLanes + l)] -=
          cost_row_[lane] / (weight_ * discounts_[static_cast<std::size_t>(t)]);
    });
    add_actions(t, lanes);
    network_.backward(*inputs.transposed, row(x_, t, 0, stride_), stride_,
                      memory_[static_cast<std::size_t>(t)], dy_.data(), actions_,
                      {gradient_.data(), gradient_.size()}, dx_.data(), stride_);
    if (t > 0) add_observations(dx_.data(), 1.0, lanes, inputs);
  }
}

void GradientSlice::update_value() {
  if (value_ == nullptr) return;
  value_->add({horizon_, stride_, x_.data(), end_x_.data(), gain_.data(), sound_, terminated_});
}

void GradientSlice::set_reward(int t, std::uint32_t lanes) {
  if (reward_weight_ == 0.0) return;
  const double weight = reward_weight_ * weight_ * discounts_[static_cast<std::size_t>(t)];
  double* const to =
      adjoints_.data() + static_cast<std::ptrdiff_t>(adjoint_.reward_row()) * kGroupLanes;
  each_lane(lanes, [&](int l) { to[l] = -weight; });
}

/// Gradients at the network's outputs, from the gradients at the actions and at the changes of
/// actions.
void GradientSlice::add_actions(int t, std::uint32_t lanes) {
  dy_.fill_zero();
  const double weight = 2.0 * GoalCost::kSmoothness * goal_weight_ * weight_;
  const double smooth = weight * discounts_[static_cast<std::size_t>(t)];
  const double next = weight * discounts_[static_cast<std::size_t>(t + 1)];
  each_lane(lanes, [&](int l) {
    const float* now = row(action_, t, l, actions_);
    for (int k = 0; k < actions_; ++k) {
      const double a = static_cast<double>(now[k]);
      double to = to_action_[static_cast<std::size_t>(k * kGroupLanes + l)];
      if (t > 0) to += smooth * (a - static_cast<double>(row(action_, t - 1, l, actions_)[k]));
      if (t + 1 < horizon_ && (sound_[static_cast<std::size_t>(t + 1)] >> l & 1u) != 0) {
        to += next * (a - static_cast<double>(row(action_, t + 1, l, actions_)[k]));
      }
      to *= 1.0 - a * a;
      // A flight whose derivatives blow up is left out, so that it does not spoil the others: sums
      // of squares are floats. A NaN fails the comparison.
      dy_[static_cast<std::size_t>(l * actions_ + k)] =
          static_cast<float>(std::abs(to) < kMostGradient ? to : 0.0);
    }
  });
}

/// Adds derivatives at the observations, from slopes at the network's inputs.
void GradientSlice::add_observations(const float* slopes, double weight, std::uint32_t lanes,
                                     const GradientInputs& inputs) {
  double* const to =
      adjoints_.data() + static_cast<std::ptrdiff_t>(adjoint_.observation_row()) * kGroupLanes;
  for (int k = 0; k < seen_; ++k) {
    const double scale = weight * inputs.scale[static_cast<std::size_t>(k)];
    each_lane(lanes, [&](int l) {
      to[k * kGroupLanes + l] =
          scale * static_cast<double>(slopes[static_cast<std::size_t>(l * stride_ + k)]);
    });
  }
}

}  // namespace skybody::learn
