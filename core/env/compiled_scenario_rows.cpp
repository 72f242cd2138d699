// The end of a transition: horizon and faults, and the rows for the learner.
//
// Every lane is first finished as if it had no fault. Faults are rare; they are corrected
// afterwards, lane by lane.
#include <algorithm>
#include <cstring>

#include "core/base/simd/lane_mask.h"
#include "core/env/compiled_scenario.h"
#include "core/env/group_lanes.h"
#include "core/env/group_workspace.h"
#include "core/env/row_conversion.h"

namespace skybody {
namespace {

/// Reason bits of a lane's fault, without those of its state.
std::uint64_t reason_bits(const GroupWorkspace& work, int lane, std::uint32_t finite) {
  const auto bit = [lane](std::uint32_t lanes, std::uint64_t reason) {
    return ((lanes >> lane) & 1u) != 0 ? reason : std::uint64_t{0};
  };
  return bit(~finite, kBadOutcome) | bit(work.bad_action, kBadAction) |
         bit(work.bad_start, work.start_status[static_cast<std::size_t>(lane)]);
}

}  // namespace

/// Horizon and faults, then the rows. A fault gives the last finite observation and reward 0.
void CompiledScenario::finish_transition(StateGroup& group, GroupWorkspace& work,
                                         std::uint32_t mask, bool is_reset,
                                         const Rows& rows) const {
  const RowKernels& kernels = row_kernels();
  const int lanes = group.lanes();
  std::uint32_t finite = write_observation(work, mask, rows) &
                         kernels.write(mask, lanes, work.reward.data(), 1, rows.reward);
  if (task().robot_rewards) finite &= finite_robot_rewards(work, mask);
  if (is_reset) {  // no action was taken yet: no reward and no end
    work.clear_verdict();
    kernels.write(mask, lanes, work.reward.data(), 1, rows.reward);
  }
  keep_observation(group, work, finite);
  kernels.end(mask, work.end.data(), group.bits(kStep),
              static_cast<std::uint64_t>(scenario().stepping.horizon), group.writable(kStatus),
              rows.status);
  const std::uint32_t faults = mask & (work.bad_action | work.bad_state | work.bad_start | ~finite);
  if (faults != 0) finish_faults(group, work, faults, finite, rows);
  if (rows.info != nullptr) kernels.write(mask, lanes, work.info.data(), info_size(), rows.info);
  if (rows.images != nullptr) write_images(group, mask, rows);
  if (rows.agent_reward != nullptr) write_agent_rewards(work, mask, rows);
}

/// Stores the observation in the state, without values that repeat others.
void CompiledScenario::keep_observation(StateGroup& group, const GroupWorkspace& work,
                                        std::uint32_t mask) const {
  const double* from = work.observation.data();
  double* to = group.writable(layout().last_observation, mask);
  if (plan_.row.copies.empty()) return keep(group, mask, plan_.size(), from, to);
  const auto keep_run = [&](int first, int count) {
    const int at = first * group.lanes();
    if (count > 0) keep(group, mask, count, from + at, to + at);
  };
  for (const ValueRun& run : plan_.row.written) keep_run(run.first, run.count);
  keep_run(observation_size(), privileged_size());
}

/// Writes rows of observations from values in lanes. @returns the lanes whose values are finite
std::uint32_t CompiledScenario::write_row(std::uint32_t mask, int lanes, const double* values,
                                          float* rows) const {
  const RowKernels& kernels = row_kernels();
  if (plan_.row.copies.empty()) {
    return kernels.write(mask, lanes, values, observation_size(), rows);
  }
  return kernels.write_parts(mask, lanes, values, plan_.row, rows);
}

/// @returns the lanes whose values are finite, the privileged ones included
std::uint32_t CompiledScenario::write_observation(GroupWorkspace& work, std::uint32_t mask,
                                                  const Rows& rows) const {
  const RowKernels& kernels = row_kernels();
  const int lanes = work.lanes, size = observation_size();
  const std::uint32_t finite = write_row(mask, lanes, work.observation.data(), rows.observation);
  if (privileged_size() == 0) return finite;
  const double* privileged = work.observation.data() + size * lanes;
  if (rows.privileged == nullptr) {
    return finite & kernels.are_finite(mask, lanes, privileged, privileged_size());
  }
  return finite & kernels.write(mask, lanes, privileged, privileged_size(), rows.privileged);
}

/// A fault does not change images: they are written as the sensors last made them. NaN in a float32
/// image is the sensor's responsibility.
void CompiledScenario::write_images(const StateGroup& group, std::uint32_t mask,
                                    const Rows& rows) const {
  for (std::size_t k = 0; k < plan_.images.size(); ++k) {
    const ObservedImage& image = plan_.images[k];
    each_lane(mask, [&](int lane) {
      std::memcpy(rows.images[k] + static_cast<std::ptrdiff_t>(lane) * image.bytes,
                  group.images().bytes_of(lane) + image.from,
                  static_cast<std::size_t>(image.bytes));
    });
  }
}

/// Writes the rows of the last finite observation.
void CompiledScenario::write_last_observation(const StateGroup& group, std::uint32_t mask,
                                              const Rows& rows) const {
  const int lanes = group.lanes();
  const double* values = group.reals(layout().last_observation);
  write_row(mask, lanes, values, rows.observation);
  if (rows.privileged == nullptr || privileged_size() == 0) return;
  row_kernels().write(mask, lanes, values + observation_size() * lanes, privileged_size(),
                      rows.privileged);
}

/// The lanes in which every agent's own reward is finite.
std::uint32_t CompiledScenario::finite_robot_rewards(const GroupWorkspace& work,
                                                     std::uint32_t mask) const {
  for (const int robot : agents_) {
    const double* reward = work.robot_reward.data() + robot * work.lanes;
    mask = row_kernels().are_finite(mask, work.lanes, reward, 1);
  }
  return mask;
}

/// @param finite  lanes with finite observation and rewards: their current observation is also the
///   last finite one
void CompiledScenario::finish_faults(StateGroup& group, GroupWorkspace& work, std::uint32_t faults,
                                     std::uint32_t finite, const Rows& rows) const {
  write_last_observation(group, faults & ~finite, rows);
  each_lane(faults, [&](int lane) {
    const auto l = static_cast<std::size_t>(lane);
    rows.status[l] = kTruncated | kFault | reason_bits(work, lane, finite);
    if (((work.bad_state >> lane) & 1u) != 0) rows.status[l] |= bad_state_bits(group, lane);
    group.writable(kStatus)[l] = rows.status[l];
    work.reward[l] = 0.0;
    for (const int robot : agents_) {
      work.robot_reward[static_cast<std::size_t>(robot * group.lanes() + lane)] = 0.0;
    }
    rows.reward[l] = 0.0f;
  });
}

/// Each agent's own reward if the task provides it, else the team's.
void CompiledScenario::write_agent_rewards(GroupWorkspace& work, std::uint32_t mask,
                                           const Rows& rows) const {
  double* to = work.agent_reward.data();
  for (const int robot : agents_) {
    const double* own = work.robot_reward.data() + robot * work.lanes;
    to = std::copy_n(task().robot_rewards ? own : work.reward.data(), work.lanes, to);
  }
  row_kernels().write(mask, work.lanes, work.agent_reward.data(), static_cast<int>(agents_.size()),
                      rows.agent_reward);
}

}  // namespace skybody
