#include "learn/ppo/ppo.h"

#include "core/base/system/error.h"
#include "learn/common/wall_clock.h"
#include "learn/ppo/ppo_slices.h"

namespace skybody::learn {
Ppo::Ppo(const LearnerOptions& options)
    : setup_(std::make_shared<const PpoSetup>(options)),
      threads_(std::make_unique<LearnerThreads>(options.threads, kSlices)),
      driver_(setup_),
      slices_(std::make_unique<PpoSlices>(setup_, 0, setup_->plan.slices(), *threads_)),
      sums_(static_cast<std::size_t>(slices_->count())),
      policy_gradients_(sums_.size()),
      value_gradients_(sums_.size()) {}

Ppo::Ppo(std::shared_ptr<const PpoSetup> setup, std::unique_ptr<SliceHolder> slices, int threads)
    : setup_(std::move(setup)),
      threads_(std::make_unique<LearnerThreads>(threads, kSlices)),
      driver_(setup_),
      slices_(std::move(slices)),
      sums_(static_cast<std::size_t>(slices_->count())),
      policy_gradients_(sums_.size()),
      value_gradients_(sums_.size()) {
  SKYBODY_DEMAND(slices_->count() == setup_->plan.slices(), "all slices are held");
}

Report Ppo::iterate() {
  const Clock::time_point begin = Clock::now();
  slices_->collect(driver_.begin_rollout(), driver_.networks());
  const Clock::time_point middle = Clock::now();
  const double reward_scale = driver_.take_rollout(sums_of(&SliceOutputs::rollout_sums));
  slices_->find_advantages(reward_scale, driver_.networks());
  driver_.take_advantages(sums_of(&SliceOutputs::advantage_sums));
  update();
  driver_.finish();
  Report report = driver_.report(seconds_between(begin, middle));
  add_episodes(report);
  slices_->stagger_resets(driver_.iteration());
  report.update_seconds = seconds_since(middle);
  return report;
}

void Ppo::update() {
  Minibatch minibatch;
  while (driver_.next(minibatch)) {
    slices_->find_gradients(minibatch, driver_.networks());
    const SliceGradients policy = gradients_of(&SliceOutputs::policy_gradient, policy_gradients_);
    const SliceGradients value = gradients_of(&SliceOutputs::value_gradient, value_gradients_);
    threads_->run(2, [&](int network, int) {
      if (network == 0 && minibatch.policy) driver_.step_policy(policy);
      if (network == 1 && minibatch.value) driver_.step_value(value);
    });
    driver_.take_figures(minibatch, sums_of(&SliceOutputs::minibatch_sums));
  }
}

SliceSums Ppo::sums_of(std::span<const double> SliceOutputs::*sums) {
  for (std::size_t k = 0; k < sums_.size(); ++k) {
    sums_[k] = slices_->outputs(static_cast<int>(k)).*sums;
  }
  return sums_;
}

SliceGradients Ppo::gradients_of(std::span<const float> SliceOutputs::*gradient,
                                 std::vector<const float*>& gradients) {
  for (std::size_t k = 0; k < gradients.size(); ++k) {
    gradients[k] = (slices_->outputs(static_cast<int>(k)).*gradient).data();
  }
  return gradients;
}

void Ppo::add_episodes(Report& report) const {
  std::size_t count = 0;
  for (int k = 0; k < slices_->count(); ++k) count += slices_->outputs(k).episode_returns.size();
  report.episode_returns.reserve(count);
  for (int k = 0; k < slices_->count(); ++k) {
    const std::span<const float> returns = slices_->outputs(k).episode_returns;
    report.episode_returns.insert(report.episode_returns.end(), returns.begin(), returns.end());
  }
}

// --- checkpoints --------------------------------------------------------------------------------

/// Environments of all slices in order, each slice preceded by its number of words.
LearnerState Ppo::state() const {
  LearnerState state;
  driver_.save(state.blocks);
  for (int k = 0; k < slices_->count(); ++k) {
    const std::vector<std::uint64_t> words = slices_->save(k, state.blocks);
    state.environments.push_back(words.size());
    state.environments.insert(state.environments.end(), words.begin(), words.end());
  }
  return state;
}

/// Sizes are checked before anything changes. Only the holders can interpret the environments'
/// words: if one refuses, the others restore their previous state.
void Ppo::restore(const LearnerState& state) {
  driver_.check(state.blocks);
  for (int k = 0; k < slices_->count(); ++k) slices_->check(k, state.blocks);
  check_environments(state.environments);
  const LearnerState before = this->state();
  try {
    restore_slices(state);
  } catch (...) {
    restore_slices(before);
    throw;
  }
  driver_.restore(state.blocks);
}

/// Checks that the words belong to as many slices as there are.
void Ppo::check_environments(std::span<const std::uint64_t> words) const {
  const int slices = slices_->count();
  for (int k = 0; k < slices; ++k) {
    if (words.empty() || words[0] > words.size() - 1) {
      throw Error("the checkpoint's environments end after slice " + std::to_string(k) + " of " +
                  std::to_string(slices) + ": it is damaged, or another learner's");
    }
    words = words.subspan(1 + words[0]);
  }
  if (!words.empty()) {
    throw Error("the checkpoint's environments go on for " + std::to_string(words.size()) +
                " words after the last of " + std::to_string(slices) +
                " slices: it is damaged, or another learner's");
  }
}

void Ppo::restore_slices(const LearnerState& state) {
  std::span<const std::uint64_t> words = state.environments;
  for (int k = 0; k < slices_->count(); ++k) {
    const std::size_t count = words[0];
    slices_->restore(k, state.blocks, words.subspan(1, count));
    words = words.subspan(1 + count);
  }
}

}  // namespace skybody::learn
