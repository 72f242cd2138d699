// A slice's part of an update: advantages, then gradients of minibatches.
#include <algorithm>
#include <cstring>

#include "core/base/math/random.h"
#include "learn/ppo/ppo_slice.h"

namespace skybody::learn {

// --- advantages ---------------------------------------------------------------------------------

void PpoSlice::find_advantages(double reward_scale, const PpoNetworks& networks,
                               SliceScratch& scratch) {
  find_values(networks, scratch);
  const AdvantageTerms terms{static_cast<float>(setup_->hyper.discount),
                             static_cast<float>(setup_->hyper.gae_lambda),
                             static_cast<float>(reward_scale)};
  std::fill(advantage_sums_.begin(), advantage_sums_.end(), 0.0);
  advantages_.estimate(terms, [&](int step, int r, float advantage, float target) {
    float* values = row(step, r);
    values[setup_->row.advantage()] = advantage;
    values[setup_->row.value_target()] = target;
    const double a = static_cast<double>(advantage), t = static_cast<double>(target);
    advantage_sums_[kSumAdvantage] += a;
    advantage_sums_[kSumAdvantageSquares] += a * a;
    advantage_sums_[kSumTarget] += t;
    advantage_sums_[kSumTargetSquares] += t * t;
  });
}

void PpoSlice::find_values(const PpoNetworks& networks, SliceScratch& scratch) {
  const std::span<float> values = advantages_.values();
  const int count = static_cast<int>(values.size());
  for (int r = 0; r < count; r += SliceScratch::kRows) {
    const int part = std::min(SliceScratch::kRows, count - r);
    PolicySteps steps = {{part, 1}};
    steps.images = images_.rows(static_cast<std::size_t>(r));
    networks.value().forward(networks.value_weights(), row(0, r), stride_, steps, scratch.value,
                             values.data() + r, 1);
  }
}

// --- gradients ----------------------------------------------------------------------------------

void PpoSlice::find_gradients(const Minibatch& minibatch, const PpoNetworks& networks,
                              SliceScratch& scratch) {
  if (minibatch.index == 0) {
    constexpr std::uint64_t kOrderStream = derive_stream("learn.order");
    order_.shuffle(Random<double>({setup_->seed, static_cast<std::uint64_t>(index_)},
                                  static_cast<std::uint64_t>(iteration_),
                                  static_cast<std::uint64_t>(minibatch.epoch), kOrderStream));
  }
  std::fill(gradients_.sums.begin(), gradients_.sums.end(), 0.0);
  std::fill(gradients_.log_std.begin(), gradients_.log_std.end(), 0.0);
  if (gradients_.policy.size() == 0) {
    gradients_.policy = AlignedArray<float>(networks.policy_parameters().size());
    gradients_.value = AlignedArray<float>(networks.value_parameters().size());
  }
  if (minibatch.policy) {
    gradients_.policy.fill_zero();
    deviations_.update(networks.log_std());
  }
  if (minibatch.value) gradients_.value.fill_zero();
  const int last = setup_->plan.first_row(index_, minibatch.index + 1);
  for (int r = setup_->plan.first_row(index_, minibatch.index); r < last;
       r += scratch.minibatch_rows) {
    const int count = std::min(scratch.minibatch_rows, last - r);
    gather(r, count, scratch);
    const PolicySteps steps = gathered_steps(r, count, scratch);
    if (minibatch.policy) add_policy_gradient(minibatch, steps, networks, scratch);
    if (minibatch.value) add_value_gradient(minibatch, steps, networks, scratch);
  }
  for (std::size_t k = 0; minibatch.policy && k < gradients_.log_std.size(); ++k) {
    gradients_.policy[networks.log_std_at() + k] = static_cast<float>(gradients_.log_std[k]);
  }
}

/// Copies rows `first` ... of the order to contiguous memory for the networks.
void PpoSlice::gather(int first, int count, SliceScratch& scratch) {
  constexpr int kAhead = 8;  // prefetch distance in rows
  const auto stride = static_cast<std::size_t>(stride_);
  const int* order = order_.order().data() + first;
  float* to = scratch.rows.data();
  for (int r = 0; r < count; ++r, to += stride) {
    if (r + kAhead < count) {
      const float* ahead = rows_.data() + static_cast<std::size_t>(order[r + kAhead]) * stride;
      __builtin_prefetch(ahead);
      __builtin_prefetch(ahead + 16);
    }
    std::memcpy(to, rows_.data() + static_cast<std::size_t>(order[r]) * stride,
                stride * sizeof(float));
  }
}

/// The rows of gather(), which are whole sequences for a policy with a memory.
PolicySteps PpoSlice::gathered_steps(int first, int count, SliceScratch& scratch) const {
  const int* order = order_.order().data() + first;
  PolicySteps steps = {{count, 1}};
  steps.images = images_.rows(order);
  memory_.gather(order, count, scratch.begins.data(), scratch.states.data(), steps);
  return steps;
}

void PpoSlice::add_policy_gradient(const Minibatch& minibatch, const PolicySteps& steps,
                                   const PpoNetworks& networks, SliceScratch& scratch) {
  const int count = steps.sequences.rows();
  const int actions = setup_->row.actions;
  const float* rows = scratch.rows.data();
  networks.policy().forward(networks.policy_weights(), rows, stride_, steps, scratch.policy,
                            scratch.output.data(), actions);
  const bool is_bounded = setup_->hyper.bounded_mean;
  if (is_bounded) {
    apply_tanh(scratch.output.data(), static_cast<std::size_t>(count * actions), setup_->isa);
  }
  const RowLayout& at = setup_->row;
  const PolicyRows drawn{
      count,   rows + at.action(),   rows + at.log_probability(), rows + at.advantage(),
      stride_, scratch.output.data()};
  const PolicyLossTerms terms{setup_->hyper.clip_range, minibatch.advantage_mean,
                              minibatch.advantage_scale,
                              1.0 / setup_->plan.minibatch_rows(minibatch.index), is_bounded};
  PolicyFigures figures;
  scratch.loss.apply(drawn, deviations_, terms, scratch.gradient.data(), gradients_.log_std,
                     figures);
  gradients_.sums[kSumPolicyLoss] += figures.loss;
  gradients_.sums[kSumKl] += figures.kl;
  gradients_.sums[kSumClipped] += figures.clipped;
  networks.policy().backward(
      networks.policy_transposed(), rows, stride_, steps, scratch.policy, scratch.gradient.data(),
      actions,
      std::span(gradients_.policy.data(), gradients_.policy.size()).first(networks.log_std_at()));
}

/// Gradient of value_weight times the mean squared error.
void PpoSlice::add_value_gradient(const Minibatch& minibatch, const PolicySteps& steps,
                                  const PpoNetworks& networks, SliceScratch& scratch) {
  const int count = steps.sequences.rows();
  const float* rows = scratch.rows.data();
  networks.value().forward(networks.value_weights(), rows, stride_, steps, scratch.value,
                           scratch.output.data(), 1);
  const double weight =
      2.0 * setup_->hyper.value_weight / setup_->plan.minibatch_rows(minibatch.index);
  double squares = 0.0;
  for (int r = 0; r < count; ++r) {
    const auto i = static_cast<std::size_t>(r);
    const double target =
        static_cast<double>(rows[i * static_cast<std::size_t>(stride_) +
                                 static_cast<std::size_t>(setup_->row.value_target())]);
    const double error = static_cast<double>(scratch.output[i]) - target;
    squares += error * error;
    scratch.gradient[i] = static_cast<float>(weight * error);
  }
  gradients_.sums[kSumValueLoss] += squares;
  networks.value().backward(networks.value_transposed(), rows, stride_, steps, scratch.value,
                            scratch.gradient.data(), 1,
                            std::span(gradients_.value.data(), gradients_.value.size())
                                .first(networks.value().parameter_count()));
}

}  // namespace skybody::learn
