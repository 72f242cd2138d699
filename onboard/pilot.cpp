#include "onboard/pilot.h"

#include <algorithm>
#include <cmath>

#include "core/base/math/math.h"
#include "core/base/simd/fp_environment.h"
#include "onboard/safe_command.h"

namespace skybody::onboard {
namespace {

template <class T>
bool are_finite(const std::vector<T>& values) {
  return std::all_of(values.begin(), values.end(), [](T value) { return std::isfinite(value); });
}

}  // namespace

std::string reason_text(std::uint32_t reasons) {
  constexpr const char* kNames[] = {"stale pose",  "tilt",      "fence",     "bad observation",
                                    "bad command", "late step", "disengaged"};
  std::string text;
  for (std::size_t k = 0; k < std::size(kNames); ++k) {
    if (((reasons >> k) & 1u) != 0) text += (text.empty() ? "" : ", ") + std::string(kNames[k]);
  }
  return text;
}

Pilot::Pilot(const Mission& mission)
    : mission_(mission),
      task_(mission),
      network_(mission.policy),
      agent_(network_.agents()[static_cast<std::size_t>(mission.agent)]),
      situation_(mission) {
  observation_.resize(static_cast<std::size_t>(mission.policy.observation_size));
  row_.resize(static_cast<std::size_t>(mission.policy.action_size));
  action_.resize(agent_.action.size());
  memory_.resize(static_cast<std::size_t>(network_.state_size()));
  command_.resize(static_cast<std::size_t>(mission.chain().count));
}

void Pilot::engage() {
  mode_ = Mode::kPolicy;
  reasons_ = 0;
  is_first_ = true;
  safe_since_ = -1.0;
}

void Pilot::hand_over(std::uint32_t reasons) {
  reasons_ |= reasons;
  if (mode_ == Mode::kPolicy) mode_ = Mode::kSafe;
}

std::uint32_t Pilot::violations(const Tick& tick) const {
  const Motion motion = situation_.body(mission_.vehicle().first_body);
  const Limits& limits = mission_.limits;
  const double at[] = {motion.position.x, motion.position.y, motion.position.z};
  std::uint32_t found = 0;
  if (!(tick.age <= limits.stale)) found |= kStale;
  if (!(motion.tilt() <= limits.tilt)) found |= kTilt;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(at[k] >= limits.fence_low[k] && at[k] <= limits.fence_high[k])) found |= kFence;
  }
  if (!is_first_ && !(tick.lateness <= limits.lateness)) found |= kLate;
  return found;
}

/// Evaluates the policy. @returns reasons for which its command cannot be used
std::uint32_t Pilot::fly(const Tick& tick) {
  if (is_first_) {
    situation_.step = situation_.physics_step = 0;
    std::fill(memory_.begin(), memory_.end(), 0.0f);
    task_.reset(situation_);
  } else {
    ++situation_.step;
    situation_.physics_step +=
        tick.periods * static_cast<std::uint64_t>(mission_.setup.setup().action_repeat);
  }
  is_first_ = false;
  task_.observe(situation_, row_, observation_);
  if (!are_finite(observation_)) return kBadObservation;
  {
    const FpEnvironment guard;
    const std::span<const float> outputs = network_.evaluate(agent_, observation_, memory_.data());
    for (std::size_t k = 0; k < outputs.size(); ++k) {
      if (!std::isfinite(outputs[k])) return kBadCommand;
      const auto value = clamp(static_cast<double>(outputs[k]), -1.0, 1.0);
      action_[k] = row_[static_cast<std::size_t>(agent_.action[k])] = static_cast<float>(value);
    }
  }
  task_.command(situation_, row_, command_);
  if (!are_finite(command_)) return kBadCommand;
  return 0;
}

void Pilot::be_safe(const Tick& tick) {
  if (safe_since_ < 0.0) safe_since_ = tick.time;
  std::fill(action_.begin(), action_.end(), 0.0f);
  const bool descends = mission_.limits.safe == SafeAction::kDescend &&
                        can_descend(mission_.chain().signal) &&
                        tick.time - safe_since_ < mission_.limits.safe_time;
  if (!descends) {
    mode_ = Mode::kStopped;
    stop_command(mission_, command_);
    return;
  }
  descend_command(mission_, situation_.body(mission_.vehicle().first_body),
                  tick.age <= mission_.limits.stale, command_);
}

Decision Pilot::step(const Tick& tick) {
  if (mode_ == Mode::kWaiting) return {};
  if (mode_ == Mode::kPolicy) {
    std::uint32_t found = violations(tick);
    if (found == 0) found = fly(tick);
    if (found != 0) hand_over(found);
  }
  if (mode_ != Mode::kPolicy) be_safe(tick);
  return {mode_, reasons_, action_, command_};
}

}  // namespace skybody::onboard
