// A slice's part of an update: advantages, then gradients of minibatches.
#include <algorithm>
#include <cstring>
#include <numeric>

#include "core/base/math/random.h"
#include "learn/ppo/ppo_slice.h"

namespace skybody::learn {

// --- advantages ---------------------------------------------------------------------------------

void PpoSlice::find_advantages(double reward_scale, const PpoNetworks& networks,
                               SliceScratch& scratch) {
  find_values(networks, scratch);
  const auto discount = static_cast<float>(setup_->hyper.discount);
  const auto lambda = static_cast<float>(setup_->hyper.gae_lambda);
  const auto scale = static_cast<float>(reward_scale);
  std::fill(advantage_sums_.begin(), advantage_sums_.end(), 0.0);
  std::fill(following_.begin(), following_.end(), 0.0f);
  for (int step = steps_ - 1; step >= 0; --step) {
    for (int r = 0; r < step_rows_; ++r) {
      const std::size_t i = at(step, r), next = at(step + 1, r);
      const float kept = goes_on_[i] * discount;
      const float error =
          reward_[i] * scale + discount * bootstrap_[i] + kept * value_[next] - value_[i];
      float& following = following_[static_cast<std::size_t>(r)];
      following = error + kept * lambda * following;
      const float target = following + value_[i];
      float* values = row(step, r);
      values[setup_->row.advantage()] = following;
      values[setup_->row.value_target()] = target;
      advantage_sums_[kSumAdvantage] += static_cast<double>(following);
      advantage_sums_[kSumAdvantageSquares] +=
          static_cast<double>(following) * static_cast<double>(following);
      advantage_sums_[kSumTarget] += static_cast<double>(target);
      advantage_sums_[kSumTargetSquares] +=
          static_cast<double>(target) * static_cast<double>(target);
    }
  }
}

void PpoSlice::find_values(const PpoNetworks& networks, SliceScratch& scratch) {
  const int count = static_cast<int>(value_.size());
  for (int r = 0; r < count; r += SliceScratch::kRows) {
    const int part = std::min(SliceScratch::kRows, count - r);
    PolicySteps steps = {{part, 1}};
    steps.images = images_.rows(static_cast<std::size_t>(r));
    networks.value().forward(networks.value_weights(), row(0, r), stride_, steps, scratch.value,
                             value_.data() + r, 1);
  }
}

// --- gradients ----------------------------------------------------------------------------------

void PpoSlice::find_gradients(const Minibatch& minibatch, const PpoNetworks& networks,
                              SliceScratch& scratch) {
  if (minibatch.index == 0) shuffle(minibatch.epoch);
  std::fill(minibatch_sums_.begin(), minibatch_sums_.end(), 0.0);
  std::fill(log_std_gradient_.begin(), log_std_gradient_.end(), 0.0);
  if (gradients_[0].size() == 0) {
    gradients_[0] = AlignedArray<float>(networks.policy_parameters().size());
    gradients_[1] = AlignedArray<float>(networks.value_parameters().size());
  }
  if (minibatch.policy) {
    gradients_[0].fill_zero();
    deviations_.update(networks.log_std());
  }
  if (minibatch.value) gradients_[1].fill_zero();
  const int last = setup_->plan.first_row(index_, minibatch.index + 1);
  for (int r = setup_->plan.first_row(index_, minibatch.index); r < last;
       r += scratch.minibatch_rows) {
    const int count = std::min(scratch.minibatch_rows, last - r);
    gather(r, count, scratch);
    const PolicySteps steps = gather_memory(r, count, scratch);
    if (minibatch.policy) add_policy_gradient(minibatch, steps, networks, scratch);
    if (minibatch.value) add_value_gradient(minibatch, steps, networks, scratch);
  }
  for (std::size_t k = 0; minibatch.policy && k < log_std_gradient_.size(); ++k) {
    gradients_[0][networks.log_std_at() + k] = static_cast<float>(log_std_gradient_[k]);
  }
}

/// Shuffles the rollout's rows for each epoch (Durstenfeld 1964, algorithm 235), or its sequences,
/// whose rows stay together. A word serves two draws: each is the upper half of a half-word times
/// the number of choices, biased by less than 1e-5 if a slice has fewer than 40,000 rows.
void PpoSlice::shuffle(int epoch) {
  constexpr std::uint64_t kOrderStream = derive_stream("learn.order");
  Random<double> random({setup_->seed, static_cast<std::uint64_t>(index_)},
                        static_cast<std::uint64_t>(iteration_), static_cast<std::uint64_t>(epoch),
                        kOrderStream);
  const int together = state_stride_ > 0 ? steps_ : 1;
  const std::size_t count = order_.size() / static_cast<std::size_t>(together);
  std::iota(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(count), 0);
  std::uint64_t word = 0;
  for (std::size_t left = count, drawn = 0; left > 1; --left, ++drawn) {
    word = drawn % 2 == 0 ? random.bits() : word << 32;
    std::swap(order_[left - 1], order_[((word >> 32) * left) >> 32]);
  }
  // From the last one on, because the rows' places overlap those of later sequences.
  for (std::size_t s = count; together > 1 && s-- > 0;) {
    const int sequence = order_[s];
    for (int step = 0; step < steps_; ++step) {
      order_[s * static_cast<std::size_t>(steps_) + static_cast<std::size_t>(step)] =
          static_cast<int>(at(step, sequence));
    }
  }
}

/// Copies rows `first` ... of the order to contiguous memory for the networks.
void PpoSlice::gather(int first, int count, SliceScratch& scratch) {
  constexpr int kAhead = 8;  // prefetch distance in rows
  const auto stride = static_cast<std::size_t>(stride_);
  const int* order = order_.data() + first;
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

/// The policy's memory before the rows of gather(), which are whole sequences for a policy with a
/// memory.
PolicySteps PpoSlice::gather_memory(int first, int count, SliceScratch& scratch) const {
  const int* order = order_.data() + first;
  PolicySteps steps = {{count, 1}};
  steps.images = images_.rows(order);
  if (state_stride_ == 0) return steps;
  const auto stride = static_cast<std::size_t>(state_stride_);
  for (int r = 0; r < count; ++r) {
    scratch.begins[static_cast<std::size_t>(r)] =
        episode_begins_[static_cast<std::size_t>(order[r])];
  }
  steps.sequences = {count / steps_, steps_};
  steps.begins = scratch.begins.data();
  steps.states = scratch.states.data();
  for (int s = 0; s < steps.sequences.count; ++s) {
    const auto row = static_cast<std::size_t>(order[s * steps_]);  // of the first step
    std::copy_n(first_states_.data() + row * stride, stride,
                scratch.states.data() + static_cast<std::size_t>(s) * stride);
  }
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
  scratch.loss.apply(drawn, deviations_, terms, scratch.gradient.data(), log_std_gradient_,
                     figures);
  minibatch_sums_[kSumPolicyLoss] += figures.loss;
  minibatch_sums_[kSumKl] += figures.kl;
  minibatch_sums_[kSumClipped] += figures.clipped;
  networks.policy().backward(
      networks.policy_transposed(), rows, stride_, steps, scratch.policy, scratch.gradient.data(),
      actions, std::span(gradients_[0].data(), gradients_[0].size()).first(networks.log_std_at()));
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
  minibatch_sums_[kSumValueLoss] += squares;
  networks.value().backward(networks.value_transposed(), rows, stride_, steps, scratch.value,
                            scratch.gradient.data(), 1,
                            std::span(gradients_[1].data(), gradients_[1].size())
                                .first(networks.value().parameter_count()));
}

}  // namespace skybody::learn
