#include "core/batch/environment_states.h"

#include <algorithm>
#include <cstring>

#include "core/base/simd/fp_environment.h"
#include "core/base/simd/lane_mask.h"
#include "core/base/system/error.h"
#include "core/env/param_access.h"
#include "core/env/random_key.h"
#include "core/physics/world/lane_values.h"

namespace skybody {
namespace {

/// The number of environments per group: whole blocks of eight lanes if there is one for each
/// thread, up to the size of a group, with about the same number of groups for every thread. In
/// order of arrival at most eight lanes: fast environments should not wait for slow ones.
int span_for(const CompiledScenario& compiled, const PoolOptions& options) {
  const int threads = std::max(options.threads, 1), lanes = compiled.preferred_lanes();
  if (lanes == 1 || options.envs < kOctet * threads) return 1;
  if (options.order == Order::kArrival && options.batch < options.envs) return kOctet;
  const auto share = [](int whole, int parts) { return (whole + parts - 1) / parts; };
  const int rounds = share(options.envs, threads * lanes);
  return kOctet * share(share(options.envs, threads * rounds), kOctet);
}

std::vector<int> image_widths(const CompiledScenario& compiled) {
  std::vector<int> bytes;
  for (const ObservedImage& image : compiled.images()) bytes.push_back(image.bytes);
  return bytes;
}

}  // namespace

EnvironmentStates::EnvironmentStates(std::shared_ptr<const CompiledScenario> compiled,
                                     const PoolOptions& options)
    : compiled_(std::move(compiled)),
      places_{options.envs, span_for(*compiled_, options)},
      action_size_(static_cast<std::size_t>(compiled_->action_size())),
      autoreset_(options.autoreset),
      keep_hash_(options.keep_hash),
      has_info_(options.info && compiled_->info_size() > 0),
      first_env_id_(options.first_env_id),
      actions_(index(envs()) * action_size_),
      flags_(places_),
      requests_(envs()),
      chains_(index(envs())) {
  const int lanes = places_.span == 1 ? 1 : compiled_->preferred_lanes();
  states_.reserve(index(places_.count()));
  for (int g = 0; g < places_.count(); ++g) states_.push_back(compiled_->make_state(lanes));
  for (int t = 0; t < std::max(options.threads, 1); ++t) {
    works_.push_back(compiled_->make_workspace(lanes));
  }
  initialize(options.seed);
}

RowWidths EnvironmentStates::widths() const {
  return {compiled_->observation_size(), static_cast<int>(compiled_->agents().size()),
          has_info_ ? compiled_->info_size() : 0, compiled_->privileged_size(),
          image_widths(*compiled_)};
}

void EnvironmentStates::initialize(std::uint64_t seed) {
  for (int env = 0; env < envs(); ++env) {
    compiled_->initialize(state(env), places_.lane_of(env), seed,
                          first_env_id_ + static_cast<std::uint64_t>(env));
  }
  flags_.clear();
  requests_.clear();
}

void EnvironmentStates::transition(int group, std::uint32_t mask, Batch& rows, int thread) {
  GroupWorkspace& work = *works_[index(thread)];
  // kSameStep gets here with an ended episode too: after a restore, or if its reset was itself a
  // fault.
  const bool renews = autoreset_ != Autoreset::kDisabled;
  const std::uint32_t resets =
      mask & (flags_.wanting_reset(group) | (renews ? flags_.ended_lanes(group) : 0u));
  if ((mask & ~resets) != 0) step(group, mask & ~resets, rows, work);
  if (resets != 0) reset(group, resets, rows, work);
}

/// The places of the rows of the group's lanes.
Rows EnvironmentStates::rows_of(int first, Batch& rows, GroupWorkspace& work) const {
  const std::size_t at = index(first);
  for (std::size_t k = 0; k < work.image_rows.size(); ++k) {
    work.image_rows[k] = rows.images[k].data() + at * index(rows.width.images[k]);
  }
  return {rows.observation.data() + at * index(rows.width.observation),
          rows.reward.data() + at,
          rows.status.data() + at,
          rows.agent_reward.data() + at * index(rows.width.agents),
          has_info_ ? rows.info.data() + at * index(rows.width.info) : nullptr,
          rows.privileged.data() + at * index(rows.width.privileged),
          work.image_rows.data()};
}

void EnvironmentStates::step(int group, std::uint32_t mask, Batch& rows, GroupWorkspace& work) {
  const int first = places_.env_of(group, 0);
  const Rows out = rows_of(first, rows, work);
  if (requests_.has_handed()) {
    requests_.apply(*compiled_, first, mask, states_[index(group)], work);
  }
  compiled_->step(states_[index(group)], work, mask, action(first), static_cast<int>(action_size_),
                  out);
  add_to_hash(group, mask, out);
  flags_.describe(group, mask, states_[index(group)].bits(kStep), false, rows);
  if (autoreset_ == Autoreset::kSameStep) reset_ended(group, mask, rows, work);
}

void EnvironmentStates::reset(int group, std::uint32_t mask, Batch& rows, GroupWorkspace& work) {
  const int first = places_.env_of(group, 0);
  const Rows out = rows_of(first, rows, work);
  const bool has_requests = requests_.has_handed();
  if (has_requests) requests_.begin_reset(first, mask, true, work);
  compiled_->reset(states_[index(group)], work, mask, out);
  if (has_requests) requests_.end_reset(first, mask, work);
  add_to_hash(group, mask, out);
  flags_.describe(group, mask, states_[index(group)].bits(kStep), true, rows);
}

/// kSameStep: keeps the last row of ended episodes and begins the next ones; reward, status and
/// step count of the row remain those of the end.
void EnvironmentStates::reset_ended(int group, std::uint32_t mask, Batch& rows,
                                    GroupWorkspace& work) {
  const std::uint32_t over = mask & flags_.ended_lanes(group);
  each_lane(over, [&](int l) { rows.keep_final(places_.env_of(group, l)); });
  if (over == 0) return;
  float reward[kGroupLanes];
  std::uint64_t status[kGroupLanes];
  const int first = places_.env_of(group, 0);
  Rows out = rows_of(first, rows, work);
  out.reward = reward;
  out.status = status;
  out.agent_reward = nullptr;
  const bool has_requests = requests_.has_handed();
  if (has_requests) requests_.begin_reset(first, over, false, work);
  compiled_->reset(states_[index(group)], work, over, out);
  if (has_requests) requests_.end_reset(first, over, work);
  add_to_hash(group, over, out);
  // A reset with a bad outcome ends this episode too: the next transition is a reset.
  each_lane(over, [&](int l) { flags_.set_ended(first + l, status[l] != kRunning); });
}

void EnvironmentStates::add_to_hash(int group, std::uint32_t mask, const Rows& rows) {
  if (!keep_hash_.load(std::memory_order_relaxed)) return;
  each_lane(mask, [&](int l) {
    compiled_->hash(states_[index(group)], l, rows, chains_[index(places_.env_of(group, l))]);
  });
}

void EnvironmentStates::observation(int env, float* out) const {
  last_values(env, 0, compiled_->observation_size(), out);
  copy_repeats(compiled_->model().observation.row, out);
}

void EnvironmentStates::privileged(int env, float* out) const {
  last_values(env, compiled_->observation_size(), compiled_->privileged_size(), out);
}

void EnvironmentStates::image(int env, int image, std::uint8_t* out) const {
  const ObservedImage& place = compiled_->images()[index(image)];
  std::copy_n(state(env).images().bytes_of(places_.lane_of(env)) + place.from, place.bytes, out);
}

void EnvironmentStates::state(const StateValue& value, double* out) {
  const int count = value.count();
  for (int g = 0; g < places_.count(); ++g) {
    StateGroup& group = states_[index(g)];
    if (value.needs_bodies()) compiled_->update(group, *works_[0], places_.all_lanes(g));
    each_lane(places_.all_lanes(g), [&](int l) {
      compiled_->state_values().read(value, group, l,
                                     out + index(places_.env_of(g, l)) * index(count));
    });
  }
}

void EnvironmentStates::goals(int env, std::vector<double>& out) {
  compiled_->goal(state(env), *works_[0], places_.lane_of(env), out);
}

std::vector<std::uint64_t> EnvironmentStates::words(int env) const {
  std::vector<std::uint64_t> saved = state(env).save(places_.lane_of(env));
  saved.resize(index(compiled_->layout().words));
  return saved;
}

/// Values of the last finite observation, from index `first` on.
void EnvironmentStates::last_values(int env, int first, int count, float* out) const {
  const double* values = state(env).reals(compiled_->layout().last_observation);
  const int lanes = state(env).lanes();
  for (int k = 0; k < count; ++k) {
    out[k] = static_cast<float>(values[(first + k) * lanes + places_.lane_of(env)]);
  }
}

StepCounts EnvironmentStates::step_counts() const {
  StepCounts sum;
  for (const StateGroup& state : states_) {
    sum.all += state.step_counts().all;
    sum.near += state.step_counts().near;
  }
  return sum;
}

double EnvironmentStates::param(int env, const std::string& path) const {
  return get_param(*compiled_, state(env), places_.lane_of(env), path);
}

void EnvironmentStates::set_param(int env, const std::string& path, double value) {
  skybody::set_param(*compiled_, state(env), places_.lane_of(env), path, value);
}

/// Draws the images of a group's restored lanes.
void EnvironmentStates::draw_again(int group) {
  if (compiled_->images().empty()) return;
  const FpEnvironment guard;
  compiled_->update(states_[index(group)], *works_[0], places_.all_lanes(group));
}

void EnvironmentStates::fork(int source, int target, bool rekey) {
  if (rekey) count_fork(state(source), places_.lane_of(source));
  if (source != target) {
    state(target).restore(places_.lane_of(target), state(source).save(places_.lane_of(source)));
    draw_again(places_.group_of(target));
    chains_[index(target)] = chains_[index(source)];
    flags_.refresh(target, state(target));
  }
  if (rekey) give_fork_key(state(target), places_.lane_of(target));
}

}  // namespace skybody
