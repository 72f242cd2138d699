#include "learn/ppo/ppo_driver.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/base/math/hash.h"
#include "core/base/math/math.h"
#include "learn/common/policy_metadata.h"
#include "learn/common/schedule.h"

namespace skybody::learn {
namespace {

/// Adds the slices' sums in slice order.
void add_up(SliceSums slices, std::vector<double>& total) {
  std::fill(total.begin(), total.end(), 0.0);
  for (const std::span<const double> sums : slices) {
    SKYBODY_DEMAND(sums.size() == total.size(), "slices give sums of one length");
    for (std::size_t k = 0; k < total.size(); ++k) total[k] += sums[k];
  }
}

double mean_of(double sum, double count) {
  return count > 0.0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

double variance_of(double sum, double squares, double count) {
  const double mean = sum / count;
  return std::max(squares / count - mean * mean, 0.0);
}

}  // namespace

PpoDriver::PpoDriver(std::shared_ptr<const PpoSetup> setup)
    : setup_(std::move(setup)),
      networks_(setup_->agents, setup_->images, setup_->hyper, setup_->isa),
      policy_adam_(networks_.policy_parameters().size(), setup_->hyper.max_grad_norm, setup_->isa),
      value_adam_(networks_.value_parameters().size(), setup_->hyper.max_grad_norm, setup_->isa),
      moments_(static_cast<std::size_t>(setup_->row.inputs)),
      return_moments_(1),
      average_(networks_.policy_weights().size(), setup_->hyper.averaging_steps),
      rollout_(static_cast<std::size_t>(kRolloutSums + 2 * setup_->row.inputs)),
      advantages_(kAdvantageSums) {
  networks_.initialize(setup_->seed, setup_->hyper.log_std);
  inputs_.mean.resize(moments_.mean.size());
  inputs_.scale.resize(moments_.mean.size());
}

double PpoDriver::progress() const { return learn::progress(counters_.steps, setup_->total_steps); }

// --- a rollout ----------------------------------------------------------------------------------

const RolloutInputs& PpoDriver::begin_rollout() {
  limit_noise();
  inputs_.iteration = counters_.iteration;
  inputs_.return_mean = return_moments_.mean[0];
  for (std::size_t k = 0; k < inputs_.mean.size(); ++k) {
    inputs_.mean[k] = moments_.mean[k];
    inputs_.scale[k] = moments_.scale(k);
  }
  next_ = Minibatch();
  next_.index = -1;
  policy_goes_on_ = true;
  figures_ = Figures();
  return inputs_;
}

/// Limits the logarithm of the deviation: at most the line between its first and its last value, at
/// least the smaller of the two.
void PpoDriver::limit_noise() {
  const Hyperparameters& hyper = setup_->hyper;
  if (hyper.final_log_std == 0.0) return;
  const double line = hyper.log_std + progress() * (hyper.final_log_std - hyper.log_std);
  const double least = std::min(hyper.log_std, hyper.final_log_std);
  networks_.limit_log_std(least, line);
}

double PpoDriver::take_rollout(SliceSums sums) {
  add_up(sums, rollout_);
  if (!setup_->hyper.normalize_rewards) return 1.0;
  return_moments_.add(rollout_[kSumRows], std::span(rollout_).subspan(kSumReturn, 1),
                      std::span(rollout_).subspan(kSumReturnSquares, 1));
  return return_moments_.scale(0);
}

void PpoDriver::take_advantages(SliceSums sums) {
  constexpr double kLeastDeviation = 1e-8;
  add_up(sums, advantages_);
  const double rows = rollout_[kSumRows];
  const double variance =
      variance_of(advantages_[kSumAdvantage], advantages_[kSumAdvantageSquares], rows);
  next_.advantage_mean = advantages_[kSumAdvantage] / rows;
  next_.advantage_scale = 1.0 / (std::sqrt(variance) + kLeastDeviation);
}

// --- the update ---------------------------------------------------------------------------------

bool PpoDriver::next(Minibatch& minibatch) {
  if (++next_.index == setup_->plan.minibatches()) {
    next_.index = 0;
    ++next_.epoch;
    if (is_beyond_kl()) policy_goes_on_ = false;
    figures_.epoch_kl = figures_.epoch_rows = 0.0;
  }
  next_.policy = next_.epoch < setup_->hyper.epochs && policy_goes_on_;
  next_.value = next_.epoch < setup_->hyper.value_epochs;
  minibatch = next_;
  return next_.policy || next_.value;
}

/// Whether the KL divergence of the policy's last pass is beyond its limit.
bool PpoDriver::is_beyond_kl() const {
  const double allowed = 1.5 * setup_->hyper.target_kl;
  return allowed > 0.0 && figures_.epoch_rows > 0.0 &&
         figures_.epoch_kl / figures_.epoch_rows > allowed;
}

void PpoDriver::step_policy(SliceGradients gradients) {
  const double rate = learning_rate(setup_->hyper, progress());
  networks_.change_policy([&](std::span<float> parameters) {
    step(policy_adam_, parameters, gradients, rate, "policy");
  });
}

void PpoDriver::step_value(SliceGradients gradients) {
  networks_.change_value([&](std::span<float> parameters) {
    step(value_adam_, parameters, gradients, setup_->hyper.learning_rate, "value function");
  });
}

void PpoDriver::step(Adam& adam, std::span<float> parameters, SliceGradients gradients, double rate,
                     const char* whose) {
  adam.sum(gradients);
  if (&adam == &policy_adam_) {
    // The entropy of independent normals is the sum of log_std plus a constant.
    const auto slope = static_cast<float>(setup_->hyper.entropy_weight);
    const std::size_t actions = networks_.log_std().size();
    for (float& g : adam.gradient().subspan(networks_.log_std_at(), actions)) g -= slope;
  }
  if (!std::isfinite(adam.step(parameters, rate))) {
    diverge(std::string("the gradient of the ") + whose);
  }
}

void PpoDriver::take_figures(const Minibatch& minibatch, SliceSums sums) {
  const double rows = setup_->plan.minibatch_rows(minibatch.index);
  if (minibatch.policy) figures_.policy_rows += rows, figures_.epoch_rows += rows;
  if (minibatch.value) figures_.value_rows += rows;
  for (const std::span<const double> slice : sums) {
    figures_.policy_loss += slice[kSumPolicyLoss];
    figures_.kl += slice[kSumKl];
    figures_.epoch_kl += slice[kSumKl];
    figures_.clipped += slice[kSumClipped];
    figures_.value_loss += slice[kSumValueLoss];
  }
}

void PpoDriver::finish() {
  check_finite();
  const Hyperparameters& hyper = setup_->hyper;
  if (hyper.normalization_steps == 0.0 ||
      static_cast<double>(counters_.steps) < hyper.normalization_steps) {
    const auto columns = static_cast<std::size_t>(setup_->row.inputs);
    moments_.add(rollout_[kSumRows], std::span(rollout_).subspan(kRolloutSums, columns),
                 std::span(rollout_).subspan(kRolloutSums + columns, columns));
  }
  average_.add(networks_.policy_weights(), static_cast<double>(setup_->steps_per_rollout()));
  counters_.steps += setup_->steps_per_rollout();
  ++counters_.iteration;
}

void PpoDriver::check_finite() const {
  const auto are_finite = [](std::span<const float> values) {
    return std::all_of(values.begin(), values.end(), [](float x) { return std::isfinite(x); });
  };
  if (!are_finite(networks_.policy_parameters())) diverge("a parameter of the policy");
  if (!are_finite(networks_.value_parameters())) diverge("a parameter of the value function");
  if (!std::isfinite(figures_.policy_loss)) diverge("the loss of the policy");
  if (!std::isfinite(figures_.value_loss)) diverge("the loss of the value function");
}

void PpoDriver::diverge(const std::string& what) const {
  throw Diverged("fast-ppo diverged: " + what + " is not finite after " +
                 std::to_string(counters_.steps) +
                 " steps; try a smaller learning_rate (--set learning_rate=...)");
}

// --- outputs ------------------------------------------------------------------------------------

Report PpoDriver::report(double rollout_seconds) const {
  Report report;
  report.steps = counters_.steps;
  report.position_error = mean_of(rollout_[kSumError], rollout_[kSumErrorSteps]);
  report.faults = static_cast<std::int64_t>(rollout_[kSumFaults]);
  const double share = rollout_[kSumEnvironmentSeconds] / rollout_[kSumSeconds];
  report.environment_seconds = share * rollout_seconds;
  report.inference_seconds = rollout_seconds - report.environment_seconds;

  const Figures& f = figures_;
  const double rows = rollout_[kSumRows];
  const double errors =
      variance_of(advantages_[kSumAdvantage], advantages_[kSumAdvantageSquares], rows);
  const double targets = variance_of(advantages_[kSumTarget], advantages_[kSumTargetSquares], rows);
  double deviations = 0.0;
  for (const float log_std : networks_.log_std()) deviations += exp(static_cast<double>(log_std));
  report.losses = {{"policy_loss", mean_of(f.policy_loss, f.policy_rows)},
                   {"kl", mean_of(f.kl, f.policy_rows)},
                   {"clip_fraction", mean_of(f.clipped, f.policy_rows)},
                   {"value_loss", mean_of(f.value_loss, f.value_rows)},
                   {"explained_variance", 1.0 - errors / (targets + 1e-8)},
                   {"action_std", deviations / static_cast<double>(networks_.log_std().size())},
                   {"learning_rate", learning_rate(setup_->hyper, progress())}};
  return report;
}

PolicyFile PpoDriver::policy() const {
  PolicyFile file = policy_metadata(*setup_->compiled, name(Algorithm::kFastPpo), counters_.steps);
  const AgentTable& agents = setup_->agents;
  for (std::size_t k = 0; agents.is_shared && k < agents.observation.size(); ++k) {
    file.agents.push_back({agents.observation[k], agents.action[k]});
  }
  file.squash = setup_->hyper.squashed ? ActionSquash::kTanh : ActionSquash::kClip;
  set_normalization(moments_, setup_->hyper.observation_clip, file);
  const auto weights = average_.of(networks_.policy_weights());
  file.layers = networks_.policy().layers(weights);
  add_images(setup_->images, networks_.policy().image_layers(weights), file);
  if (setup_->hyper.bounded_mean) file.layers.back().activation = Activation::kTanh;
  return file;
}

std::uint64_t PpoDriver::parameter_hash() const {
  HashChain chain;
  for (const auto values : {networks_.policy_parameters(), networks_.value_parameters()}) {
    for (const float value : values) {
      std::uint32_t bits;
      std::memcpy(&bits, &value, sizeof(bits));
      chain.update(bits);
    }
  }
  return chain.value();
}

// --- checkpoints --------------------------------------------------------------------------------

template <class Self, class Visitor>
void PpoDriver::visit(Self& self, Visitor& visitor) {
  visitor("counters", &self.counters_, 1);
  PpoNetworks::visit(self.networks_, visitor);
  Adam::visit(self.policy_adam_, "policy_adam", visitor);
  Adam::visit(self.value_adam_, "value_adam", visitor);
  RunningMoments::visit(self.moments_, "moments", visitor);
  RunningMoments::visit(self.return_moments_, "return_moments", visitor);
  WeightAverage::visit(self.average_, "average", visitor);
}

void PpoDriver::save(StateBlocks& blocks) const {
  StateWriter writer(blocks);
  visit(*this, writer);
}

void PpoDriver::check(const StateBlocks& blocks) {
  StateReader reader(blocks, StateReader::Mode::kCheck);
  visit(*this, reader);
}

void PpoDriver::restore(const StateBlocks& blocks) {
  check(blocks);
  StateReader reader(blocks, StateReader::Mode::kCopy);
  visit(*this, reader);
}

}  // namespace skybody::learn
