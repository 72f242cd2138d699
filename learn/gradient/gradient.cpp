#include "learn/gradient/gradient.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/math/hash.h"
#include "core/base/system/error.h"
#include "core/base/system/number_text.h"
#include "learn/common/flushed_denormals.h"
#include "learn/common/policy_metadata.h"
#include "learn/common/schedule.h"
#include "learn/common/slice_plan.h"
#include "learn/common/state_blocks.h"
#include "learn/common/wall_clock.h"

namespace skybody::learn {
namespace {

/// Number of recent rollouts whose statistics normalise observations. Older ones count less:
/// observations of an untrained, tumbling policy do not resemble later ones.
constexpr double kRemembered = 10.0;
/// Added to the variance that normalises observations, so that nearly constant ones are not
/// amplified.
constexpr double kLeastVariance = 0.01;
constexpr double kLastLayerGain = 0.01;
constexpr double kNoClip = 1e6;  // of normalised observations

/// Values of a row of inputs (HorizonInputs).
int width_of(const CompiledScenario& compiled, const Hyperparameters& hyper) {
  const bool has_value = hyper.end_value_weight > 0.0;
  return compiled.observation_size() + (has_value ? compiled.privileged_size() : 0);
}

/// Images that all slices keep: each those of one group's horizon.
std::int64_t kept_images(const Hyperparameters& hyper) {
  return std::int64_t{kGroupLanes} * std::min(hyper.envs, kSlices) * hyper.rollout_steps;
}

std::shared_ptr<const CompiledScenario> checked_training(
    std::shared_ptr<const CompiledScenario> training, const CompiledScenario& compiled,
    const Hyperparameters& hyper) {
  const Stepping& steps = training->scenario().stepping;
  const PhysicsSteps wanted = training_steps(compiled, hyper);
  if (steps.dt == wanted.dt && steps.action_repeat == wanted.count) return training;
  throw Error("`" + compiled.scenario().name + "` is to be trained in with " +
              std::to_string(steps.action_repeat) + " physics steps of " + exact_text(steps.dt) +
              " s an action, and physics_steps = " + std::to_string(hyper.physics_steps) +
              " asks for " + std::to_string(wanted.count) + " of " + exact_text(wanted.dt) +
              " s: compile it with training_overrides(), as make_learner() does");
}

}  // namespace

AnalyticGradientLearner::AnalyticGradientLearner(const LearnerOptions& options,
                                                 std::shared_ptr<const CompiledScenario> training)
    : compiled_(options.compiled),
      training_((check(options.hyper, Algorithm::kGradient),
                 checked_training(std::move(training), *options.compiled, options.hyper))),
      hyper_(options.hyper),
      total_steps_(options.total_steps),
      images_(find_images(*compiled_, hyper_, kept_images(hyper_))),
      network_({compiled_->observation_size(), formats_of(images_)}, compiled_->action_size(),
               hyper_, 0, best_isa()),
      parameters_(network_.parameter_count()),
      adam_(network_.parameter_count(), hyper_.max_grad_norm, best_isa()),
      moments_(static_cast<std::size_t>(width_of(*compiled_, hyper_))),
      value_(hyper_.end_value_weight > 0.0 ? std::make_unique<ValueFunction>(
                                                 width_of(*compiled_, hyper_), hyper_, options.seed)
                                           : nullptr),
      scale_(moments_.mean.size()),
      average_(network_.parameter_count(), hyper_.averaging_steps),
      threads_(options.threads, kSlices) {
  network_.initialize({parameters_.data(), parameters_.size()}, kLastLayerGain, options.seed, 0);
  const SlicePlan plan(hyper_.envs, hyper_.rollout_steps, hyper_.envs);
  slices_.resize(static_cast<std::size_t>(plan.slices()));
  const auto make_slice = [&](int s, const GradientSlice* alike) {
    slices_[static_cast<std::size_t>(s)] =
        std::make_unique<GradientSlice>(training_, hyper_, network_, options.seed,
                                        plan.first_env(s), plan.envs(s), value_.get(), alike);
  };
  make_slice(0, nullptr);
  threads_.run(plan.slices() - 1, [&](int s, int) { make_slice(s + 1, slices_[0].get()); });
  for (const auto& slice : slices_) {
    gradients_.push_back(slice->gradient().data());
    if (value_ != nullptr) value_gradients_.push_back(slice->value()->gradient().data());
  }
  sums_.resize(slices_[0]->sums().size());
}

Report AnalyticGradientLearner::iterate() {
  const Clock::time_point begin = Clock::now();
  const FlushedDenormals guard;  // as on the worker threads
  const std::span<float> parameters{parameters_.data(), parameters_.size()};
  network_.transpose(parameters, transposed_);
  for (std::size_t k = 0; k < scale_.size(); ++k) {
    scale_[k] = 1.0 / std::sqrt(moments_.variance[k] + kLeastVariance);
  }
  const GradientInputs inputs{parameters, &transposed_, moments_.mean, scale_, counters_.iteration};
  threads_.run(static_cast<int>(slices_.size()),
               [&](int s, int) { slices_[static_cast<std::size_t>(s)]->run(inputs); });
  const Clock::time_point middle = Clock::now();
  add_up();
  adam_.sum(gradients_);
  const double norm =
      adam_.step(parameters, learning_rate(hyper_, progress(counters_.steps, total_steps_)));
  if (!std::isfinite(norm) || !std::isfinite(sums_[kSumCost])) {
    throw Diverged(
        "`gradient` has diverged at " + std::to_string(counters_.steps) +
        " steps: the cost or its gradient is not finite; take a smaller learning_rate, a "
        "shorter rollout_steps, or --algo fast-ppo");
  }
  const double value_loss = value_ != nullptr ? update_value() : 0.0;
  normalize();
  average_.add(parameters, sums_[kSumSteps]);
  counters_.steps += static_cast<std::int64_t>(sums_[kSumSteps]);
  ++counters_.iteration;
  Report report;
  report.steps = counters_.steps;
  report.position_error = sums_[kSumDistance] / std::max(sums_[kSumSteps], 1.0);
  report.faults = static_cast<std::int64_t>(sums_[kSumFaulted]);
  for (const auto& slice : slices_) {
    const std::span<const float> returns = slice->episode_returns();
    report.episode_returns.insert(report.episode_returns.end(), returns.begin(), returns.end());
  }
  // Slices run side by side: the elapsed time is divided in proportion to their own times.
  const double flight = sums_[kSumFlightSeconds], inference = sums_[kSumInferenceSeconds];
  const double share =
      seconds_between(begin, middle) / (flight + inference + sums_[kSumReturnSeconds]);
  report.environment_seconds = share * flight;
  report.inference_seconds = share * inference;
  report.update_seconds =
      seconds_since(begin) - report.environment_seconds - report.inference_seconds;
  report.losses = {{"cost", sums_[kSumCost]},
                   {"gradient_norm", norm},
                   {"touching_share", sums_[kSumTouching] / std::max(sums_[kSumEnds], 1.0)}};
  if (value_ != nullptr) report.losses.emplace_back("value_loss", value_loss);
  return report;
}

/// Some optimiser steps over all transitions of the iteration. @returns the last loss
double AnalyticGradientLearner::update_value() {
  double loss = 0.0;
  for (int epoch = 0; epoch < hyper_.value_epochs; ++epoch) {
    threads_.run(static_cast<int>(slices_.size()), [&](int s, int) {
      slices_[static_cast<std::size_t>(s)]->value()->find_gradient();
    });
    loss = 0.0;
    for (const auto& slice : slices_) loss += slice->value()->loss();
    const double norm = value_->step(value_gradients_, hyper_.learning_rate);
    if (!std::isfinite(norm)) {
      throw Diverged("`gradient` has diverged at " + std::to_string(counters_.steps) +
                     " steps: the gradient of its value function is not finite; take a smaller "
                     "learning_rate, or end_value_weight=0");
    }
  }
  value_->follow();
  return loss;
}

void AnalyticGradientLearner::add_up() {
  std::fill(sums_.begin(), sums_.end(), 0.0);
  for (const auto& slice : slices_) {
    for (std::size_t k = 0; k < sums_.size(); ++k) sums_[k] += slice->sums()[k];
  }
}

void AnalyticGradientLearner::normalize() {
  const bool is_over = hyper_.normalization_steps > 0.0 &&
                       static_cast<double>(counters_.steps) >= hyper_.normalization_steps;
  if (is_over) return;
  const std::size_t seen = moments_.mean.size();
  const std::span<const double> sums(sums_);
  moments_.count = std::min(moments_.count, kRemembered * sums_[kSumSteps]);
  moments_.add(sums_[kSumSteps], sums.subspan(kGradientSums, seen),
               sums.subspan(kGradientSums + seen, seen));
}

PolicyFile AnalyticGradientLearner::policy() const {
  PolicyFile file = policy_metadata(*compiled_, name(Algorithm::kGradient), counters_.steps);
  file.squash = ActionSquash::kTanh;
  for (std::size_t k = 0; k < static_cast<std::size_t>(compiled_->observation_size()); ++k) {
    file.mean.push_back(moments_.mean[k]);
    file.scale.push_back(1.0 / std::sqrt(moments_.variance[k] + kLeastVariance));
  }
  file.clip = kNoClip;
  const auto weights = average_.of({parameters_.data(), parameters_.size()});
  file.layers = network_.layers(weights);
  add_images(images_, network_.image_layers(weights), file);
  return file;
}

std::uint64_t AnalyticGradientLearner::parameter_hash() const {
  HashChain chain;
  for (std::size_t k = 0; k < parameters_.size(); ++k) {
    chain.update(static_cast<double>(parameters_[k]));
  }
  return chain.value();
}

// --- checkpoints --------------------------------------------------------------------------------

template <class Self, class Visitor>
void AnalyticGradientLearner::visit(Self& self, Visitor& visitor) {
  visitor("counters", &self.counters_, 1);
  visitor("policy", self.parameters_.data(), self.parameters_.size());
  Adam::visit(self.adam_, "policy.adam", visitor);
  RunningMoments::visit(self.moments_, "observations", visitor);
  WeightAverage::visit(self.average_, "average", visitor);
  if (self.value_ != nullptr) ValueFunction::visit(*self.value_, "value", visitor);
  for (std::size_t s = 0; s < self.slices_.size(); ++s) {
    GradientSlice::visit(*self.slices_[s], "slice" + std::to_string(s), visitor);
  }
}

LearnerState AnalyticGradientLearner::state() const {
  LearnerState state;
  StateWriter writer(state.blocks);
  visit(*this, writer);
  for (const auto& slice : slices_) slice->save(state.environments);
  return state;
}

void AnalyticGradientLearner::restore(const LearnerState& state) {
  StateReader check(state.blocks, StateReader::Mode::kCheck);
  visit(*this, check);
  std::size_t words = 0;
  for (const auto& slice : slices_) words += slice->saved_words();
  if (state.environments.size() != words) {
    throw Error("the checkpoint's environments have " + std::to_string(state.environments.size()) +
                " words, and this learner's " + std::to_string(words) +
                ": it is another scenario's, or of other hyper-parameters");
  }
  StateReader copy(state.blocks, StateReader::Mode::kCopy);
  visit(*this, copy);
  std::span<const std::uint64_t> rest = state.environments;
  for (const auto& slice : slices_) {
    slice->restore(rest.first(slice->saved_words()));
    rest = rest.subspan(slice->saved_words());
  }
}

}  // namespace skybody::learn
