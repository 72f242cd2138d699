// A slice's construction, and its forward pass through a horizon.
#include "learn/gradient/gradient_slice.h"

#include <algorithm>
#include <cmath>

#include "core/base/math/math.h"
#include "core/base/simd/fp_environment.h"
#include "core/base/simd/isa.h"
#include "core/base/simd/lane_mask.h"
#include "learn/network/kernels/kernel_table.h"
#include "learn/network/kernels/kernels.h"

namespace skybody::learn {
namespace {

constexpr std::uint32_t kAllLanes = ~0u;

std::uint32_t first_lanes(int count) { return count >= 32 ? kAllLanes : (1u << count) - 1u; }

/// TransitionAdjoint refuses tasks without a goal.
Vec3<double> goal_point(const CompiledScenario& compiled) {
  const std::vector<Goal>& goals = compiled.task().task.goals;
  return goals.empty() ? Vec3<double>{0.0, 0.0, 0.0} : goals[0].point;
}

}  // namespace

GradientSlice::Weights::Weights(const Hyperparameters& hyper, bool has_value)
    : transition(1.0 / (static_cast<double>(hyper.envs) * hyper.rollout_steps)),
      reward(hyper.reward_weight),
      goal(hyper.goal_weight),
      end(hyper.end_value_weight),
      discounts(static_cast<std::size_t>(hyper.rollout_steps + 1), 1.0) {
  for (std::size_t t = 1; has_value && t < discounts.size(); ++t) {
    discounts[t] = discounts[t - 1] * hyper.discount;
  }
}

GradientSlice::Flight::Flight(int steps, int actions)
    : flying(static_cast<std::size_t>(steps)),
      sound(flying.size()),
      goal(GoalCost::kGoalRows * kGroupLanes * flying.size()),
      gain(kGroupLanes * flying.size()),
      action(gain.size() * static_cast<std::size_t>(actions)) {}

GradientSlice::Slopes::Slopes(int rows, int actions, int input_stride)
    : adjoints(static_cast<std::size_t>(rows) * kGroupLanes),
      to_action(static_cast<std::size_t>(actions) * kGroupLanes),
      cost(kGroupLanes),
      distance(kGroupLanes),
      inputs(kGroupLanes * static_cast<std::size_t>(input_stride)),
      outputs(kGroupLanes * static_cast<std::size_t>(actions)) {}

GradientSlice::GradientSlice(std::shared_ptr<const CompiledScenario> compiled,
                             const Hyperparameters& hyper, const PolicyNetwork& network,
                             std::uint64_t seed, int first_env, int envs,
                             const ValueFunction* value, const GradientSlice* alike)
    : compiled_(std::move(compiled)),
      network_(network),
      cost_(hyper, goal_point(*compiled_)),
      isa_(best_isa()),
      seed_(seed),
      first_env_(first_env),
      envs_(envs),
      horizon_(hyper.rollout_steps),
      actions_(compiled_->action_size()),
      weights_(hyper, value != nullptr),
      work_(compiled_->make_workspace(kGroupLanes)),
      adjoint_(*compiled_, hyper.rollout_steps, hyper.reward_weight > 0.0),
      inputs_(*compiled_, value != nullptr, hyper.rollout_steps,
              (envs + kGroupLanes - 1) / kGroupLanes),
      flight_(horizon_, actions_),
      slopes_(adjoint_.rows(), actions_, inputs_.stride()) {
  const FpEnvironment guard;
  const auto steps = static_cast<std::size_t>(horizon_);
  reward_ = AlignedArray<float>(kGroupLanes);
  status_ = AlignedArray<std::uint64_t>(kGroupLanes);
  memory_.resize(inputs_.has_images() ? 1 : steps);
  gradient_ = AlignedArray<float>(network.parameter_count());
  sums_.resize(static_cast<std::size_t>(kGradientSums + 2 * inputs_.width()));
  for (int first = 0; first < envs; first += kGroupLanes) {
    const int count = std::min(envs - first, kGroupLanes);
    groups_.push_back({compiled_->make_state(kGroupLanes), first_lanes(count), count, first});
  }
  returns_.resize(groups_.size() * kGroupLanes);
  episode_returns_.reserve(static_cast<std::size_t>(envs) * steps);
  work_->contacts.reserve(64);
  if (value != nullptr) {
    value_ = std::make_unique<HorizonValue>(*value, hyper, inputs_.stride(), weights_.transition,
                                            envs * hyper.rollout_steps);
  }
  if (alike != nullptr) {
    adjoint_.copy_sparsity(alike->adjoint_);
  } else {
    Group& group = groups_[0];
    adjoint_.look_at_flights(group.state, *work_, inputs_.outcome(reward_.data(), status_.data()),
                             horizon_);
    group.state = compiled_->make_state(kGroupLanes);
  }
  adjoint_.color_columns();
  begin();
}

void GradientSlice::begin() {
  for (Group& group : groups_) {
    each_lane(group.lanes, [&](int l) {
      compiled_->initialize(group.state, l, seed_,
                            static_cast<std::uint64_t>(first_env_ + group.first + l));
    });
    reset(group, group.lanes);
  }
}

void GradientSlice::reset(Group& group, std::uint32_t lanes) {
  if (lanes == 0) return;
  const Rows rows = inputs_.outcome(reward_.data(), status_.data());
  compiled_->reset(group.state, *work_, lanes, rows);
  each_lane(lanes, [&](int l) {
    inputs_.take(group.first + l, l);
    returns_[static_cast<std::size_t>(group.first + l)] = 0.0;
  });
}

void GradientSlice::run(const GradientInputs& inputs) {
  gradient_.fill_zero();
  std::fill(sums_.begin(), sums_.end(), 0.0);
  episode_returns_.clear();
  if (value_ != nullptr) value_->clear();
  for (Group& group : groups_) {
    fly(group, inputs);
    look_at_ends(group, inputs);
    const Clock::time_point begin = Clock::now();
    go_back(group, inputs);
    update_value();
    add_seconds(kSumReturnSeconds, begin);
    begin_anew(group, inputs.iteration);
  }
}

void GradientSlice::add_seconds(GradientSum sum, Clock::time_point begin) {
  sums_[static_cast<std::size_t>(sum)] += seconds_since(begin);
}

// --- forward ------------------------------------------------------------------------------------

void GradientSlice::fly(Group& group, const GradientInputs& inputs) {
  std::uint32_t flying = group.lanes;
  flight_.terminated = 0;
  for (int t = 0; t < horizon_; ++t) {
    flight_.flying[static_cast<std::size_t>(t)] = flying;
    const Clock::time_point begin = Clock::now();
    act(group, inputs, t);
    add_seconds(kSumInferenceSeconds, begin);
    const Clock::time_point middle = Clock::now();
    {
      const FpEnvironment guard;
      const Rows rows = inputs_.outcome(reward_.data(), status_.data());
      adjoint_.step(group.state, *work_, flying, action(t, 0), actions_, rows, t);
      adjoint_.goal(group.state, *work_, flying, goal_at(t));
    }
    add_seconds(kSumFlightSeconds, middle);
    take_outcome(group, t);
    flying = flight_.sound[static_cast<std::size_t>(t)];
    each_lane(flying, [&](int l) {
      if (status_[static_cast<std::size_t>(l)] != kRunning) flying &= ~(1u << l);
    });
  }
}

PolicySteps GradientSlice::steps_of(const Group& group, int t) const {
  PolicySteps steps = {{group.count, 1}};
  steps.images = inputs_.images(t);
  return steps;
}

PolicyNetwork::Memory& GradientSlice::memory_of(int t) {
  return memory_[inputs_.has_images() ? 0 : static_cast<std::size_t>(t)];
}

void GradientSlice::act(const Group& group, const GradientInputs& inputs, int t) {
  const auto width = static_cast<std::size_t>(inputs_.width());
  double* const sum = sums_.data() + kGradientSums;
  each_lane(group.lanes, [&](int l) {
    inputs_.normalize(group.first + l, inputs.mean, inputs.scale, inputs_.row(t, l));
  });
  const std::uint32_t flying = flight_.flying[static_cast<std::size_t>(t)];
  each_lane(flying, [&](int l) {
    const std::span<const float> seen = inputs_.present(group.first + l);
    for (std::size_t k = 0; k < width; ++k) {
      const double difference = static_cast<double>(seen[k]) - inputs.mean[k];
      sum[k] += difference;
      sum[width + k] += difference * difference;
    }
  });
  inputs_.keep_images(group.state, flying, t);
  float* const y = action(t, 0);
  network_.forward(inputs.parameters, inputs_.row(t, 0), inputs_.stride(), steps_of(group, t),
                   memory_of(t), y, actions_);
  kernels_of(isa_).tanh(y, y, static_cast<std::size_t>(group.count * actions_));
}

void GradientSlice::take_outcome(const Group& group, int t) {
  const std::uint32_t flying = flight_.flying[static_cast<std::size_t>(t)];
  std::uint32_t sound = flying;
  each_lane(flying, [&](int l) {
    const auto lane = static_cast<std::size_t>(l);
    const std::size_t env = static_cast<std::size_t>(group.first) + lane;
    inputs_.take(group.first + l, l);
    returns_[env] += static_cast<double>(reward_[lane]);
    sums_[kSumSteps] += 1.0;
    flight_.gain[static_cast<std::size_t>(t * kGroupLanes + l)] =
        weights_.reward * static_cast<double>(reward_[lane]);
    if (status_[lane] == kRunning) return;
    episode_returns_.push_back(static_cast<float>(returns_[env]));
    if ((status_[lane] & (kTerminated | kFault)) != 0) flight_.terminated |= 1u << l;
    if ((status_[lane] & kFault) == 0) return;
    sound &= ~(1u << l);
    sums_[kSumFaulted] += 1.0;
  });
  flight_.sound[static_cast<std::size_t>(t)] = sound;
}

/// Lanes whose last transition was `t`, without a fault.
std::uint32_t GradientSlice::ending(int t) const {
  const auto at = static_cast<std::size_t>(t);
  return t + 1 < horizon_ ? flight_.sound[at] & ~flight_.flying[at + 1] : flight_.sound[at];
}

/// Inspects the ends of flights: contacts, which the derivatives ignore, and the last observations.
/// Flights that ended by a fault have none.
void GradientSlice::look_at_ends(Group& group, const GradientInputs& inputs) {
  std::uint32_t sound = 0;
  for (int t = 0; t < horizon_; ++t) sound |= ending(t);
  const FpEnvironment guard;
  const std::uint32_t near = group.state.may_touch(sound, work_->physics);
  each_lane(sound, [&](int) { sums_[kSumEnds] += 1.0; });
  each_lane(sound & near, [&](int l) {
    work_->contacts.clear();
    group.state.add_contacts(l, work_->physics, work_->contacts);
    if (!work_->contacts.empty()) sums_[kSumTouching] += 1.0;
  });
  if (value_ == nullptr) return;
  inputs_.clear_ends();
  each_lane(sound, [&](int l) {
    inputs_.normalize(group.first + l, inputs.mean, inputs.scale, inputs_.end(l));
  });
}

// --- between two horizons -----------------------------------------------------------------------

/// Resets environments whose episode has ended. During the first `episode / horizon` iterations
/// also resets a part of the others, so that later horizons sample all parts of an episode.
void GradientSlice::begin_anew(Group& group, std::int64_t iteration) {
  const FpEnvironment guard;
  std::uint32_t flying = flight_.sound.back();
  each_lane(flying, [&](int l) {
    if (status_[static_cast<std::size_t>(l)] != kRunning) flying &= ~(1u << l);
  });
  std::uint32_t anew = group.lanes & ~flying;
  const std::int64_t episode = compiled_->scenario().stepping.horizon;
  const std::int64_t turns = std::max<std::int64_t>(1, episode / horizon_);
  for (int l = 0; l < kGroupLanes && episode > 0; ++l) {
    const bool is_turn = (iteration + first_env_ + group.first + l) % turns == 0;
    if (is_turn && iteration < turns) anew |= group.lanes & (1u << l);
  }
  reset(group, anew);
}

// --- checkpoints --------------------------------------------------------------------------------

std::size_t GradientSlice::saved_words() const {
  return static_cast<std::size_t>(envs_) * compiled_->saved_words();
}

void GradientSlice::save(std::vector<std::uint64_t>& words) const {
  for (const Group& group : groups_) {
    each_lane(group.lanes, [&](int l) {
      const std::vector<std::uint64_t> saved = group.state.save(l);
      words.insert(words.end(), saved.begin(), saved.end());
    });
  }
}

void GradientSlice::restore(std::span<const std::uint64_t> words) {
  const FpEnvironment guard;
  const std::size_t size = compiled_->saved_words();
  for (Group& group : groups_) {
    each_lane(group.lanes, [&](int l) {
      group.state.restore(l, {words.begin(), words.begin() + static_cast<std::ptrdiff_t>(size)});
      words = words.subspan(size);
    });
    compiled_->update(group.state, *work_, group.lanes);
  }
}

}  // namespace skybody::learn
