// A slice's construction, and its part of a rollout.
#include "learn/ppo/ppo_slice.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/math/random.h"
#include "learn/common/wall_clock.h"
#include "learn/network/noise.h"

namespace skybody::learn {
namespace {

PoolOptions pool_options(const PpoSetup& setup, int slice) {
  PoolOptions options;
  options.envs = setup.plan.envs(slice);
  options.threads = 1;
  options.autoreset = Autoreset::kSameStep;
  options.seed = setup.seed;
  options.first_env_id = static_cast<std::uint64_t>(setup.plan.first_env(slice));
  return options;
}

std::size_t product(int a, int b) {
  return static_cast<std::size_t>(a) * static_cast<std::size_t>(b);
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

/// Floats of the policy's memory per row.
int state_stride(const PpoSetup& setup) { return padded(setup.hyper.recurrent_units); }

}  // namespace

SliceScratch::SliceScratch(const PpoSetup& setup)
    : minibatch_rows(gathered_rows(setup)),
      rows(product(minibatch_rows, setup.row.stride())),
      output(product(std::max(minibatch_rows, kRows), std::max(setup.row.actions, 1))),
      gradient(output.size()),
      loss(minibatch_rows, setup.isa) {
  if (setup.hyper.recurrent_units == 0) return;
  begins.resize(static_cast<std::size_t>(minibatch_rows));
  states =
      AlignedArray<float>(product(minibatch_rows / setup.hyper.rollout_steps, state_stride(setup)));
}

PpoSlice::PpoSlice(std::shared_ptr<const PpoSetup> setup, int index)
    : setup_(std::move(setup)),
      index_(index),
      envs_(setup_->plan.envs(index)),
      step_rows_(envs_ * setup_->agents.rows()),
      steps_(setup_->hyper.rollout_steps),
      stride_(setup_->row.stride()),
      normalizer_(setup_->hyper.observation_clip, setup_->isa),
      pool_(setup_->compiled, pool_options(*setup_, index)),
      own_observation_(product(envs_, setup_->compiled->observation_size())),
      own_privileged_(product(envs_, setup_->compiled->privileged_size())),
      rows_(product(steps_ + 1, step_rows_) * static_cast<std::size_t>(stride_)),
      reward_(product(steps_, step_rows_)),
      goes_on_(reward_.size()),
      bootstrap_(reward_.size()),
      value_(product(steps_ + 1, step_rows_)),
      following_(static_cast<std::size_t>(step_rows_)),
      noise_(product(step_rows_, setup_->row.actions)),
      mean_(noise_.size()),
      action_(product(envs_, setup_->compiled->action_size())),
      images_(*setup_, envs_, value_.size()),
      last_inputs_(product(step_rows_, stride_)),
      order_(reward_.size()),
      begins_(static_cast<std::size_t>(envs_)),
      discounted_(static_cast<std::size_t>(step_rows_)),
      returns_(static_cast<std::size_t>(envs_)),
      rollout_sums_(static_cast<std::size_t>(kRolloutSums + 2 * setup_->row.inputs)),
      advantage_sums_(kAdvantageSums),
      minibatch_sums_(kMinibatchSums),
      log_std_gradient_(static_cast<std::size_t>(setup_->row.actions)) {
  if (setup_->hyper.recurrent_units > 0) {
    state_stride_ = state_stride(*setup_);
    states_ = AlignedArray<float>(product(step_rows_, state_stride_));
    first_states_ = AlignedArray<float>(states_.size());
    is_fresh_.resize(static_cast<std::size_t>(step_rows_), 1);
    episode_begins_.resize(reward_.size());
  }
  cut_.reserve(static_cast<std::size_t>(step_rows_));
  episode_returns_.reserve(product(steps_, envs_));
  pool_.send_reset();
  pool_.recv();
  look_at_observations();
}

/// Reads the observations from the pool, if there is no batch: after environments were reset or
/// restored.
void PpoSlice::look_at_observations() {
  pool_.observations(own_observation_);
  pool_.privileged(own_privileged_);
  observation_ = own_observation_.data();
  privileged_ = own_privileged_.data();
  images_.look_at(pool_);
  batch_.reset();
}

void PpoSlice::restore_environments(std::span<const std::uint64_t> words) {
  pool_.restore(words);
  look_at_observations();
}

// --- a rollout ----------------------------------------------------------------------------------

void PpoSlice::collect(const RolloutInputs& inputs, const PpoNetworks& networks,
                       SliceScratch& scratch) {
  const Clock::time_point begin = Clock::now();
  inputs_ = &inputs;
  iteration_ = inputs.iteration;
  clear_sums();
  deviations_.update(networks.log_std());
  std::copy_n(states_.data(), states_.size(), first_states_.data());
  for (int step = 0; step < steps_; ++step) {
    write_inputs(step, true);
    choose_actions(step, networks, scratch);
    step_environments();
    take_outcome(step);
    if (!cut_.empty()) value_cut_episodes(networks, scratch);
  }
  write_inputs(steps_, false);  // inputs of the last values
  inputs_ = nullptr;
  rollout_sums_[kSumRows] = static_cast<double>(reward_.size());
  rollout_sums_[kSumSeconds] = seconds_since(begin);
}

void PpoSlice::clear_sums() {
  std::fill(rollout_sums_.begin(), rollout_sums_.end(), 0.0);
  std::fill(bootstrap_.begin(), bootstrap_.end(), 0.0f);
  episode_returns_.clear();
}

/// Copies the inputs of an environment's rows, one after the other from `first` on, not yet
/// normalized.
void PpoSlice::copy_inputs(const float* observation, const float* privileged, int env,
                           float* first) {
  const AgentTable& agents = setup_->agents;
  observation += product(env, setup_->compiled->observation_size());
  privileged += product(env, setup_->compiled->privileged_size());
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
  for (int env = 0; env < envs_; ++env) {
    copy_inputs(observation_, privileged_, env, row(step, env * setup_->agents.rows()));
  }
  images_.write(at(step, 0));
  double* columns = rollout_sums_.data() + kRolloutSums;
  const ColumnSums sums{columns, columns + setup_->row.inputs};
  normalizer_.apply(row(step, 0), step_rows_, stride_, inputs_->mean, inputs_->scale,
                    adds_sums ? &sums : nullptr);
}

/// The policy's memory for `count` rows of a step, read and then overwritten by the network.
PolicySteps PpoSlice::recall(int step, int first, int count) {
  PolicySteps steps = {{count, 1}};
  steps.images = images_.rows(at(step, first));
  if (state_stride_ == 0) return steps;
  const auto r = static_cast<std::size_t>(first);
  std::copy_n(is_fresh_.data() + r, count, episode_begins_.data() + at(step, first));
  steps.begins = is_fresh_.data() + r;
  steps.states = states_.data() + product(first, state_stride_);
  return steps;
}

void PpoSlice::choose_actions(int step, const PpoNetworks& networks, SliceScratch& scratch) {
  const int actions = setup_->row.actions;
  constexpr std::uint64_t kNoiseStream = derive_stream("learn.noise");
  draw_normals({{setup_->seed, static_cast<std::uint64_t>(index_)},
                static_cast<std::uint64_t>(inputs_->iteration),
                kNoiseStream,
                static_cast<std::uint64_t>(step)},
               noise_, setup_->isa);
  for (int r = 0; r < step_rows_; r += SliceScratch::kRows) {
    const int count = std::min(SliceScratch::kRows, step_rows_ - r);
    networks.policy().forward(networks.policy_weights(), row(step, r), stride_,
                              recall(step, r, count), scratch.policy,
                              mean_.data() + product(r, actions), actions);
  }
  if (setup_->hyper.bounded_mean) apply_tanh(mean_.data(), mean_.size(), setup_->isa);
  float* first = row(step, 0);
  draw_actions(mean_.data(), noise_.data(), step_rows_, deviations_, first + setup_->row.action(),
               first + setup_->row.log_probability(), stride_);
  command(step);
}

/// Assembles the environments' actions: each row fills its own part.
void PpoSlice::command(int step) {
  const AgentTable& agents = setup_->agents;
  const int width = setup_->compiled->action_size();
  for (int r = 0; r < step_rows_; ++r) {
    const float* drawn = row(step, r) + setup_->row.action();
    float* to = action_.data() + product(r / agents.rows(), width);
    for (const int entry : agents.action[static_cast<std::size_t>(r % agents.rows())]) {
      to[entry] = *drawn++;
    }
  }
  if (setup_->hyper.squashed) apply_tanh(action_.data(), action_.size(), setup_->isa);
}

void PpoSlice::step_environments() {
  const Clock::time_point begin = Clock::now();
  pool_.send(action_);
  batch_ = pool_.recv();
  rollout_sums_[kSumEnvironmentSeconds] += seconds_since(begin);
  observation_ = batch_->observation.data();
  privileged_ = batch_->privileged.data();
  images_.look_at(*batch_);
}

void PpoSlice::take_outcome(int step) {
  const Batch& batch = *batch_;
  cut_.clear();
  for (int env = 0; env < envs_; ++env) {
    const auto i = static_cast<std::size_t>(env);
    take_rewards(step, env);
    rollout_sums_[kSumFaults] += batch.fault[i];
    const bool has_ended = (batch.terminated[i] | batch.truncated[i]) != 0;
    if (setup_->error.is_told() && batch.fault[i] == 0) {
      const float* info = (has_ended ? batch.final_info : batch.info).data();
      rollout_sums_[kSumError] += setup_->error.of(info + product(env, batch.width.info));
      rollout_sums_[kSumErrorSteps] += 1.0;
    }
    if (has_ended) end_episode(step, env);
  }
}

/// Stores the rewards of an environment's rows, and updates the discounted returns that scale
/// rewards.
void PpoSlice::take_rewards(int step, int env) {
  const AgentTable& agents = setup_->agents;
  const auto i = static_cast<std::size_t>(env);
  const bool goes_on = (batch_->terminated[i] | batch_->truncated[i]) == 0;
  const float* rewards = agents.is_shared
                             ? batch_->agent_reward.data() + product(env, batch_->width.agents)
                             : batch_->reward.data() + env;
  for (int a = 0; a < agents.rows(); ++a) {
    const int r = env * agents.rows() + a;
    reward_[at(step, r)] = rewards[a];
    goes_on_[at(step, r)] = goes_on ? 1.0f : 0.0f;
    if (state_stride_ > 0) is_fresh_[static_cast<std::size_t>(r)] = goes_on ? 0 : 1;
    double& discounted = discounted_[static_cast<std::size_t>(r)];
    discounted = discounted * setup_->hyper.discount + static_cast<double>(rewards[a]);
    const double d = discounted - inputs_->return_mean;
    rollout_sums_[kSumReturn] += d;
    rollout_sums_[kSumReturnSquares] += d * d;
    if (!goes_on) discounted = 0.0;
  }
  returns_[i] += static_cast<double>(batch_->reward[i]);
}

/// Value after the end: of a truncated episode the value function at its last observation; of a
/// terminated or faulted one 0. A fault's outcome is not used for learning.
void PpoSlice::end_episode(int step, int env) {
  const auto i = static_cast<std::size_t>(env);
  episode_returns_.push_back(static_cast<float>(returns_[i]));
  returns_[i] = 0.0;
  const bool is_cut = batch_->truncated[i] != 0 && batch_->terminated[i] == 0;
  if (!is_cut || batch_->fault[i] != 0) return;
  copy_inputs(batch_->final_observation.data(), batch_->final_privileged.data(), env,
              last_inputs_.data() + product(static_cast<int>(cut_.size()), stride_));
  images_.keep_last(*batch_, env, cut_.size());
  for (int a = 0; a < setup_->agents.rows(); ++a) {
    cut_.push_back(static_cast<int>(at(step, env * setup_->agents.rows() + a)));
  }
}

void PpoSlice::value_cut_episodes(const PpoNetworks& networks, SliceScratch& scratch) {
  const int count = static_cast<int>(cut_.size());
  normalizer_.apply(last_inputs_.data(), count, stride_, inputs_->mean, inputs_->scale, nullptr);
  for (int r = 0; r < count; r += SliceScratch::kRows) {
    const int part = std::min(SliceScratch::kRows, count - r);
    PolicySteps steps = {{part, 1}};
    steps.images = images_.last(static_cast<std::size_t>(r));
    networks.value().forward(networks.value_weights(), last_inputs_.data() + product(r, stride_),
                             stride_, steps, scratch.value, scratch.output.data(), 1);
    for (int k = 0; k < part; ++k) {
      bootstrap_[static_cast<std::size_t>(cut_[static_cast<std::size_t>(r + k)])] =
          scratch.output[static_cast<std::size_t>(k)];
    }
  }
}

void PpoSlice::stagger_resets(std::int64_t iteration) {
  const std::int64_t parts = setup_->compiled->scenario().stepping.horizon / steps_;
  bool any = false;
  for (int env = 0; env < envs_; ++env) {
    const std::int64_t group = (setup_->plan.first_env(index_) + env) * parts / setup_->hyper.envs;
    const auto i = static_cast<std::size_t>(env);
    begins_[i] = group == iteration ? 1 : 0;
    if (begins_[i] == 0) continue;
    any = true;
    returns_[i] = 0.0;
    const int rows = setup_->agents.rows();
    std::fill_n(discounted_.begin() + env * rows, rows, 0.0);
    if (state_stride_ > 0) std::fill_n(is_fresh_.begin() + env * rows, rows, std::uint8_t{1});
  }
  if (!any) return;
  pool_.send_reset(begins_);
  pool_.recv();
  look_at_observations();
}

}  // namespace skybody::learn
