#include "core/batch/environment_states.h"

#include <algorithm>
#include <cstring>

#include "core/base/simd/lane_mask.h"
#include "core/base/system/error.h"
#include "core/env/fork_random_key.h"
#include "core/env/param_access.h"
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

int groups_of(int envs, int span) { return (envs + span - 1) / span; }

std::vector<int> image_widths(const CompiledScenario& compiled) {
  std::vector<int> bytes;
  for (const ObservedImage& image : compiled.images()) bytes.push_back(image.bytes);
  return bytes;
}

}  // namespace

EnvironmentStates::EnvironmentStates(std::shared_ptr<const CompiledScenario> compiled,
                                     const PoolOptions& options)
    : compiled_(std::move(compiled)),
      envs_(options.envs),
      span_(span_for(*compiled_, options)),
      action_size_(static_cast<std::size_t>(compiled_->action_size())),
      autoreset_(options.autoreset),
      keep_hash_(options.keep_hash),
      has_info_(options.info && compiled_->info_size() > 0),
      first_env_id_(options.first_env_id),
      actions_(index(envs_) * action_size_),
      wants_reset_(groups_of(envs_, span_)),
      started_(groups_of(envs_, span_)),
      ended_(groups_of(envs_, span_)),
      chains_(index(envs_)),
      asked_(index(envs_)),
      handed_(index(envs_)),
      waiting_(index(envs_)) {
  const int groups = groups_of(envs_, span_);
  const int lanes = span_ == 1 ? 1 : compiled_->preferred_lanes();
  states_.reserve(index(groups));
  for (int g = 0; g < groups; ++g) states_.push_back(compiled_->make_state(lanes));
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
  for (int env = 0; env < envs_; ++env) {
    compiled_->initialize(state(env), lane_of(env), seed,
                          first_env_id_ + static_cast<std::uint64_t>(env));
  }
  started_.clear();
  ended_.clear();
  for (int env = 0; has_asked_ && env < envs_; ++env) {
    asked_[index(env)].clear();
    handed_[index(env)].clear();
    waiting_[index(env)].clear();
  }
}

void EnvironmentStates::want_step_all() { wants_reset_.clear(); }

bool EnvironmentStates::can_step_all() const {
  std::uint32_t missing = 0;
  for (int g = 0; g < groups(); ++g) {
    missing |= all_lanes(g) & ~started_.of(g);
    if (autoreset_ == Autoreset::kDisabled) missing |= ended_.of(g);
  }
  return missing == 0;
}

void EnvironmentStates::transition(int group, std::uint32_t mask, Batch& rows, int thread) {
  GroupWorkspace& work = *works_[index(thread)];
  // kSameStep gets here with an ended episode too: after a restore, or if its reset was itself a
  // fault.
  const bool renews = autoreset_ != Autoreset::kDisabled;
  const std::uint32_t resets = mask & (wants_reset_.of(group) | (renews ? ended_.of(group) : 0u));
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
  const int first = env_of(group, 0);
  const Rows out = rows_of(first, rows, work);
  if (has_handed_.load(std::memory_order_relaxed)) apply_requests(group, mask, work);
  compiled_->step(states_[index(group)], work, mask, action(first), static_cast<int>(action_size_),
                  out);
  add_to_hash(group, mask, out);
  describe(group, mask, false, rows);
  if (autoreset_ == Autoreset::kSameStep) reset_ended(group, mask, rows, work);
}

void EnvironmentStates::reset(int group, std::uint32_t mask, Batch& rows, GroupWorkspace& work) {
  const Rows out = rows_of(env_of(group, 0), rows, work);
  const bool has_requests = has_handed_.load(std::memory_order_relaxed);
  if (has_requests) begin_requests(group, mask, true, work);
  compiled_->reset(states_[index(group)], work, mask, out);
  if (has_requests) end_requests(group, mask, work);
  add_to_hash(group, mask, out);
  describe(group, mask, true, rows);
}

/// kSameStep: keeps the last row of ended episodes and begins the next ones; reward, status and
/// step count of the row remain those of the end.
void EnvironmentStates::reset_ended(int group, std::uint32_t mask, Batch& rows,
                                    GroupWorkspace& work) {
  const std::uint32_t over = mask & ended_.of(group);
  each_lane(over, [&](int l) { rows.keep_final(env_of(group, l)); });
  if (over == 0) return;
  float reward[kGroupLanes];
  std::uint64_t status[kGroupLanes];
  Rows out = rows_of(env_of(group, 0), rows, work);
  out.reward = reward;
  out.status = status;
  out.agent_reward = nullptr;
  const bool has_requests = has_handed_.load(std::memory_order_relaxed);
  if (has_requests) begin_requests(group, over, false, work);
  compiled_->reset(states_[index(group)], work, over, out);
  if (has_requests) end_requests(group, over, work);
  add_to_hash(group, over, out);
  // A reset with a bad outcome ends this episode too: the next transition is a reset.
  each_lane(over, [&](int l) { ended_.set(group, 1u << l, status[l] != kRunning); });
}

void EnvironmentStates::ask(int env, std::shared_ptr<const ParamRequest> request, bool at_reset) {
  has_asked_ = true;
  asked_[index(env)].push_back({std::move(request), at_reset});
}

/// The environment is not in flight: no thread runs it.
void EnvironmentStates::hand_over_requests(int env) {
  std::vector<Asked>& asked = asked_[index(env)];
  if (asked.empty()) return;
  handed_[index(env)].swap(asked);
  has_handed_.store(true, std::memory_order_relaxed);
}

void EnvironmentStates::hand_over_all() {
  for (int env = 0; has_asked_ && env < envs_; ++env) hand_over_requests(env);
}

/// Applies requests before a step; requests for a reset wait.
void EnvironmentStates::apply_requests(int group, std::uint32_t mask, GroupWorkspace& work) {
  each_lane(mask, [&](int l) {
    const std::size_t env = index(env_of(group, l));
    for (Asked& asked : handed_[env]) {
      if (asked.at_reset) {
        waiting_[env].push_back(std::move(asked.request));
      } else {
        compiled_->apply(states_[index(group)], work, l, *asked.request);
      }
    }
    handed_[env].clear();
  });
}

/// Passes requests to a reset.
/// @param takes_all  also requests for the next transition, because the reset is that transition
void EnvironmentStates::begin_requests(int group, std::uint32_t mask, bool takes_all,
                                       GroupWorkspace& work) {
  each_lane(mask, [&](int l) {
    const std::size_t env = index(env_of(group, l));
    for (Asked& asked : handed_[env]) {
      if (takes_all) waiting_[env].push_back(std::move(asked.request));
    }
    if (takes_all) handed_[env].clear();
    work.requests[index(l)] = waiting_[env];
  });
}

void EnvironmentStates::end_requests(int group, std::uint32_t mask, GroupWorkspace& work) {
  work.clear_requests();
  each_lane(mask, [&](int l) { waiting_[index(env_of(group, l))].clear(); });
}

void EnvironmentStates::add_to_hash(int group, std::uint32_t mask, const Rows& rows) {
  if (!keep_hash_.load(std::memory_order_relaxed)) return;
  each_lane(mask, [&](int l) {
    compiled_->hash(states_[index(group)], l, rows, chains_[index(env_of(group, l))]);
  });
}

/// Fills the flags of the rows from the status of the transition.
void EnvironmentStates::describe(int group, std::uint32_t mask, bool is_reset, Batch& rows) {
  const std::uint64_t* steps = states_[index(group)].bits(kStep);
  const int first_env = env_of(group, 0);
  std::uint32_t over = 0;
  std::uint32_t running = span_ == 1 ? 0u : whole_octets(mask);
  each_octet(running, [&](int first) {
    if (!describe_running(first_env + first, steps + first, is_reset, rows)) {
      running &= ~(0xffu << first);
    }
  });
  each_lane(mask & ~running, [&](int l) {
    const std::size_t env = index(first_env + l);
    const std::uint64_t status = rows.status[env];
    rows.terminated[env] = (status & kTerminated) != 0;
    rows.truncated[env] = (status & kTruncated) != 0;
    rows.fault[env] = (status & kFault) != 0;
    rows.was_reset[env] = is_reset;
    rows.episode_step[env] = static_cast<std::int32_t>(steps[l]);
    if (status != kRunning) over |= 1u << l;
  });
  started_.set(group, mask, true);
  ended_.set(group, mask & ~over, false);
  ended_.set(group, over, true);
}

/// The same for eight lanes whose episodes all continue. Otherwise returns false and writes
/// nothing.
bool EnvironmentStates::describe_running(int first, const std::uint64_t* steps, bool is_reset,
                                         Batch& rows) {
  const std::size_t at = index(first);
  std::uint64_t ended = 0;
  for (std::size_t l = 0; l < kOctet; ++l) ended |= rows.status[at + l] ^ kRunning;
  if (ended != 0) return false;
  for (Column<std::uint8_t>* flags : {&rows.terminated, &rows.truncated, &rows.fault}) {
    std::memset(flags->data() + at, 0, kOctet);
  }
  std::memset(rows.was_reset.data() + at, is_reset ? 1 : 0, kOctet);
  for (std::size_t l = 0; l < kOctet; ++l) {
    rows.episode_step[at + l] = static_cast<std::int32_t>(steps[l]);
  }
  return true;
}

void EnvironmentStates::observation(int env, float* out) const {
  last_values(env, 0, compiled_->observation_size(), out);
  copy_repeats(compiled_->observation_row(), out);
}

void EnvironmentStates::privileged(int env, float* out) const {
  last_values(env, compiled_->observation_size(), compiled_->privileged_size(), out);
}

void EnvironmentStates::image(int env, int image, std::uint8_t* out) const {
  const ObservedImage& place = compiled_->images()[index(image)];
  std::copy_n(state(env).images().bytes_of(lane_of(env)) + place.from, place.bytes, out);
}

void EnvironmentStates::state(const StateValue& value, double* out) {
  const int count = value.count();
  for (int g = 0; g < groups(); ++g) {
    StateGroup& group = states_[index(g)];
    if (value.needs_bodies()) compiled_->update(group, *works_[0], all_lanes(g));
    each_lane(all_lanes(g), [&](int l) {
      compiled_->state_values().read(value, group, l, out + index(env_of(g, l)) * index(count));
    });
  }
}

std::vector<std::uint64_t> EnvironmentStates::words(int env) const {
  std::vector<std::uint64_t> saved = state(env).save(lane_of(env));
  saved.resize(index(compiled_->layout().words));
  return saved;
}

/// Values of the last finite observation, from index `first` on.
void EnvironmentStates::last_values(int env, int first, int count, float* out) const {
  const double* values = state(env).reals(compiled_->layout().last_observation);
  const int lanes = state(env).lanes();
  for (int k = 0; k < count; ++k) {
    out[k] = static_cast<float>(values[(first + k) * lanes + lane_of(env)]);
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
  return get_param(*compiled_, state(env), lane_of(env), path);
}

void EnvironmentStates::set_param(int env, const std::string& path, double value) {
  skybody::set_param(*compiled_, state(env), lane_of(env), path, value);
}

void EnvironmentStates::fork(int source, int target, bool rekey) {
  if (rekey) count_fork(state(source), lane_of(source));
  if (source != target) {
    state(target).restore(lane_of(target), state(source).save(lane_of(source)));
    chains_[index(target)] = chains_[index(source)];
    refresh_flags(target);
  }
  if (rekey) give_fork_key(state(target), lane_of(target));
}

}  // namespace skybody
