// A slice's construction, and its part of a rollout.
#include "learn/ppo/ppo_slice.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "learn/common/wall_clock.h"
#include "learn/network/product.h"

namespace skybody::learn {
namespace {

PoolOptions pool_options(const PpoSetup& setup, int slice) {
  PoolOptions options;
  options.envs = setup.plan.envs(slice);
  options.threads = 1;
  options.seed = setup.seed;
  options.first_env_id = static_cast<std::uint64_t>(setup.plan.first_env(slice));
  return options;
}

/// A policy with a memory gathers whole sequences: enough of them for some hundred rows, so that
/// the products of one step have enough rows.
int gathered_rows(const PpoSetup& setup) {
  const int steps = setup.hyper.rollout_steps;
  if (setup.hyper.recurrent_units > 0) {
    return std::max(1, 4 * SliceScratch::kRows / steps) * steps;
  }
  return setup.images.empty() ? SliceScratch::kRows : SliceScratch::kRows / 4;
}

}  // namespace

SliceScratch::SliceScratch(const PpoSetup& setup)
    : minibatch_rows(gathered_rows(setup)),
      rows(product(minibatch_rows, setup.row.stride())),
      output(product(std::max(minibatch_rows, kRows), std::max(setup.row.actions, 1))),
      gradient(output.size()),
      loss(minibatch_rows, setup.isa) {
  if (setup.hyper.recurrent_units == 0) return;
  begins.resize(static_cast<std::size_t>(minibatch_rows));
  states = AlignedArray<float>(
      product(minibatch_rows / setup.hyper.rollout_steps, padded(setup.hyper.recurrent_units)));
}

PpoSlice::PpoSlice(std::shared_ptr<const PpoSetup> setup, int index)
    : setup_(std::move(setup)),
      index_(index),
      step_rows_(setup_->plan.envs(index) * setup_->agents.rows()),
      steps_(setup_->hyper.rollout_steps),
      stride_(setup_->row.stride()),
      normalizer_(setup_->hyper.observation_clip, setup_->isa),
      environments_(setup_->compiled, pool_options(*setup_, index)),
      rows_(product(steps_ + 1, step_rows_) * static_cast<std::size_t>(stride_)),
      advantages_(steps_, step_rows_),
      images_(*setup_, environments_.size(), product(steps_ + 1, step_rows_)),
      order_(steps_, step_rows_, setup_->hyper.recurrent_units > 0),
      memory_(setup_->hyper.recurrent_units, steps_, step_rows_),
      begins_(static_cast<std::size_t>(environments_.size())),
      discounted_(step_rows_, setup_->hyper.discount),
      returns_(begins_.size()),
      rollout_sums_(static_cast<std::size_t>(kRolloutSums + 2 * setup_->row.inputs)),
      advantage_sums_(kAdvantageSums) {
  draws_.noise.resize(product(step_rows_, setup_->row.actions));
  draws_.mean.resize(draws_.noise.size());
  draws_.action.resize(product(environments_.size(), setup_->compiled->action_size()));
  cut_.inputs = AlignedArray<float>(product(step_rows_, stride_));
  cut_.at.reserve(static_cast<std::size_t>(step_rows_));
  gradients_.sums.resize(kMinibatchSums);
  gradients_.log_std.resize(static_cast<std::size_t>(setup_->row.actions));
  episode_returns_.reserve(product(steps_, environments_.size()));
  images_.look_at(environments_.pool());
}

void PpoSlice::restore_environments(std::span<const std::uint64_t> words) {
  environments_.restore(words);
  images_.look_at(environments_.pool());
}

// --- a rollout ----------------------------------------------------------------------------------

void PpoSlice::collect(const RolloutInputs& inputs, const PpoNetworks& networks,
                       SliceScratch& scratch) {
  const Clock::time_point begin = Clock::now();
  inputs_ = &inputs;
  iteration_ = inputs.iteration;
  clear_sums();
  deviations_.update(networks.log_std());
  memory_.begin();
  for (int step = 0; step < steps_; ++step) {
    write_inputs(step, true);
    choose_actions(step, networks, scratch);
    step_environments();
    take_outcome(step);
    if (!cut_.at.empty()) value_cut_episodes(networks, scratch);
  }
  write_inputs(steps_, false);  // inputs of the last values
  inputs_ = nullptr;
  rollout_sums_[kSumRows] = static_cast<double>(steps_) * step_rows_;
  rollout_sums_[kSumSeconds] = seconds_since(begin);
}

void PpoSlice::clear_sums() {
  std::fill(rollout_sums_.begin(), rollout_sums_.end(), 0.0);
  advantages_.begin();
  episode_returns_.clear();
}

/// Copies the inputs of an environment's rows, one after the other from `first` on, not yet
/// normalized.
void PpoSlice::copy_inputs(const float* observation, const float* privileged, float* first) {
  const AgentTable& agents = setup_->agents;
  for (int a = 0; a < agents.rows(); ++a) {
    float* to = first + product(a, stride_);
    for (const int entry : agents.observation[static_cast<std::size_t>(a)])
      *to++ = observation[entry];
    for (const int entry : agents.privileged[static_cast<std::size_t>(a)])
      *to++ = privileged[entry];
  }
}

/// Writes the environments' current observations, normalized, into the rows of a step.
void PpoSlice::write_inputs(int step, bool adds_sums) {
  for (int env = 0; env < environments_.size(); ++env) {
    copy_inputs(environments_.observation(env), environments_.privileged(env),
                row(step, env * setup_->agents.rows()));
  }
  images_.write(at(step, 0));
  double* columns = rollout_sums_.data() + kRolloutSums;
  const ColumnSums sums{columns, columns + setup_->row.inputs};
  normalizer_.apply(row(step, 0), step_rows_, stride_, inputs_->mean, inputs_->scale,
                    adds_sums ? &sums : nullptr);
}

/// `count` rows of a step, with the policy's memory.
PolicySteps PpoSlice::recall(int step, int first, int count) {
  PolicySteps steps = {{count, 1}};
  steps.images = images_.rows(at(step, first));
  memory_.recall(at(step, first), first, count, steps);
  return steps;
}

void PpoSlice::choose_actions(int step, const PpoNetworks& networks, SliceScratch& scratch) {
  const int actions = setup_->row.actions;
  draw_noise({.seed = setup_->seed,
              .slice = static_cast<std::uint64_t>(index_),
              .rollout = static_cast<std::uint64_t>(inputs_->iteration),
              .step = static_cast<std::uint64_t>(step)},
             draws_.noise, setup_->isa);
  for (int r = 0; r < step_rows_; r += SliceScratch::kRows) {
    const int count = std::min(SliceScratch::kRows, step_rows_ - r);
    networks.policy().forward(networks.policy_weights(), row(step, r), stride_,
                              recall(step, r, count), scratch.policy,
                              draws_.mean.data() + product(r, actions), actions);
  }
  if (setup_->hyper.bounded_mean) apply_tanh(draws_.mean.data(), draws_.mean.size(), setup_->isa);
  float* first = row(step, 0);
  draw_actions(draws_.mean.data(), draws_.noise.data(), step_rows_, deviations_,
               first + setup_->row.action(), first + setup_->row.log_probability(), stride_);
  command(step);
}

/// Assembles the environments' actions: each row fills its own part.
void PpoSlice::command(int step) {
  const AgentTable& agents = setup_->agents;
  const int width = setup_->compiled->action_size();
  for (int r = 0; r < step_rows_; ++r) {
    const float* drawn = row(step, r) + setup_->row.action();
    float* to = draws_.action.data() + product(r / agents.rows(), width);
    for (const int entry : agents.action[static_cast<std::size_t>(r % agents.rows())]) {
      to[entry] = *drawn++;
    }
  }
  if (setup_->hyper.squashed) apply_tanh(draws_.action.data(), draws_.action.size(), setup_->isa);
}

void PpoSlice::step_environments() {
  const Clock::time_point begin = Clock::now();
  environments_.step(draws_.action);
  rollout_sums_[kSumEnvironmentSeconds] += seconds_since(begin);
  images_.look_at(environments_.batch());
}

void PpoSlice::take_outcome(int step) {
  const Batch& batch = environments_.batch();
  cut_.at.clear();
  for (int env = 0; env < environments_.size(); ++env) {
    const auto i = static_cast<std::size_t>(env);
    const EpisodeEnd end = environments_.end_of(env);
    take_rewards(step, env);
    rollout_sums_[kSumFaults] += batch.fault[i];
    const bool has_ended = end != EpisodeEnd::kNone;
    if (setup_->error.is_told() && batch.fault[i] == 0) {
      const float* info = (has_ended ? batch.final_info : batch.info).data();
      rollout_sums_[kSumError] += setup_->error.of(info + product(env, batch.width.info));
      rollout_sums_[kSumErrorSteps] += 1.0;
    }
    if (has_ended) end_episode(step, env, end);
  }
}

/// Stores the rewards of an environment's rows, and updates the discounted returns that scale
/// rewards.
void PpoSlice::take_rewards(int step, int env) {
  const AgentTable& agents = setup_->agents;
  const Batch& batch = environments_.batch();
  const bool goes_on = environments_.end_of(env) == EpisodeEnd::kNone;
  const float* rewards = agents.is_shared
                             ? batch.agent_reward.data() + product(env, batch.width.agents)
                             : batch.reward.data() + env;
  for (int a = 0; a < agents.rows(); ++a) {
    const int r = env * agents.rows() + a;
    advantages_.set(at(step, r), rewards[a], goes_on);
    memory_.set_fresh(r, !goes_on);
    const double d = discounted_.add(r, rewards[a], goes_on) - inputs_->return_mean;
    rollout_sums_[kSumReturn] += d;
    rollout_sums_[kSumReturnSquares] += d * d;
  }
  const auto i = static_cast<std::size_t>(env);
  returns_[i] += static_cast<double>(batch.reward[i]);
}

/// Value after the end: of a truncated episode the value function at its last observation; of a
/// terminated or faulted one 0. A fault's outcome is not used for learning.
void PpoSlice::end_episode(int step, int env, EpisodeEnd end) {
  double& sum = returns_[static_cast<std::size_t>(env)];
  episode_returns_.push_back(static_cast<float>(sum));
  sum = 0.0;
  if (end != EpisodeEnd::kCut) return;
  copy_inputs(environments_.last_observation(env), environments_.last_privileged(env),
              cut_.inputs.data() + product(static_cast<int>(cut_.at.size()), stride_));
  images_.keep_last(environments_.batch(), env, cut_.at.size());
  for (int a = 0; a < setup_->agents.rows(); ++a) {
    cut_.at.push_back(at(step, env * setup_->agents.rows() + a));
  }
}

void PpoSlice::value_cut_episodes(const PpoNetworks& networks, SliceScratch& scratch) {
  const int count = static_cast<int>(cut_.at.size());
  normalizer_.apply(cut_.inputs.data(), count, stride_, inputs_->mean, inputs_->scale, nullptr);
  for (int r = 0; r < count; r += SliceScratch::kRows) {
    const int part = std::min(SliceScratch::kRows, count - r);
    PolicySteps steps = {{part, 1}};
    steps.images = images_.last(static_cast<std::size_t>(r));
    networks.value().forward(networks.value_weights(), cut_.inputs.data() + product(r, stride_),
                             stride_, steps, scratch.value, scratch.output.data(), 1);
    for (int k = 0; k < part; ++k) {
      advantages_.set_end_value(cut_.at[static_cast<std::size_t>(r + k)],
                                scratch.output[static_cast<std::size_t>(k)]);
    }
  }
}

void PpoSlice::stagger_resets(std::int64_t iteration) {
  const std::int64_t parts = setup_->compiled->scenario().stepping.horizon / steps_;
  bool any = false;
  for (int env = 0; env < environments_.size(); ++env) {
    const std::int64_t group = (setup_->plan.first_env(index_) + env) * parts / setup_->hyper.envs;
    const auto i = static_cast<std::size_t>(env);
    begins_[i] = group == iteration ? 1 : 0;
    if (begins_[i] == 0) continue;
    any = true;
    returns_[i] = 0.0;
    const int rows = setup_->agents.rows();
    for (int r = env * rows; r < (env + 1) * rows; ++r) {
      discounted_.restart(r);
      memory_.set_fresh(r, true);
    }
  }
  if (!any) return;
  environments_.reset(begins_);
  images_.look_at(environments_.pool());
}

}  // namespace skybody::learn
