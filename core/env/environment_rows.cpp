// How a transition ends: horizon and faults, and the rows that the learner gets.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/octets.h"
#include "core/env/environment.h"
#include "core/env/group_lanes.h"
#include "core/env/group_rows.h"
#include "core/env/group_work.h"
#include "core/physics/lane_values.h"

namespace skybody {
namespace {

/// Reason bits of a lane's fault, 0 if there is none.
std::uint64_t fault_reason(const GroupWork& work, int lane, bool finite_outcome) {
  std::uint64_t reason = finite_outcome ? std::uint64_t{0} : std::uint64_t{kBadOutcome};
  if (((work.bad_action >> lane) & 1u) != 0) reason |= kBadAction;
  if (((work.bad_state >> lane) & 1u) != 0) reason |= kBadState;
  return reason;
}

/// Finite as the float that the learner gets.
bool is_finite_float(double value) { return std::isfinite(static_cast<float>(value)); }

}  // namespace

/// Horizon and faults, then the rows. A fault gives the last finite observation and reward 0.
void Environment::conclude(StateGroup& group, GroupWork& work, std::uint32_t mask, bool is_reset,
                           const Rows& rows) const {
  const std::uint32_t octets = octets_of(group, mask & ~(work.bad_action | work.bad_state));
  if (octets != 0) mask &= ~conclude_octets(group, work, octets, is_reset, rows);
  if (mask == 0) return;
  const int lanes = group.lanes();
  const int size = observation_size();
  double* last = group.writable(layout().last_observation, mask);
  each_lane(mask, [&](int lane) {
    const auto l = static_cast<std::size_t>(lane);
    bool finite = is_finite_float(work.reward[l]);
    for (const int robot : agents_) {
      finite = finite &&
               is_finite_float(work.robot_reward[static_cast<std::size_t>(robot * lanes + lane)]);
    }
    for (int k = 0; k < size; ++k) {
      finite =
          finite && is_finite_float(work.observation[static_cast<std::size_t>(k * lanes + lane)]);
    }
    std::uint64_t status = is_reset ? kRunning : ended(group, work, lane);
    double reward = is_reset ? 0.0 : work.reward[l];
    if (const std::uint64_t reason = fault_reason(work, lane, finite); reason != 0) {
      status = kTruncated | kFault | reason;
      reward = 0.0;
    }
    if (finite) {
      for (int k = 0; k < size; ++k) {
        last[k * lanes + lane] = work.observation[static_cast<std::size_t>(k * lanes + lane)];
      }
    }
    group.writable(kStatus)[lane] = status;
    write_rows(group, work, lane, reward, rows);
  });
}

/// Whether task or horizon end the episode.
std::uint64_t Environment::ended(const StateGroup& group, const GroupWork& work, int lane) const {
  const auto horizon = static_cast<std::uint64_t>(scenario().stepping.horizon);
  const std::uint64_t by_task =
      work.end[static_cast<std::size_t>(lane)] & (kTerminated | kTruncated);
  const bool over = horizon > 0 && group.bits(kStep)[lane] >= horizon;
  return over ? by_task | kTruncated : by_task;
}

/// Octets of lanes that came through the physics.
/// @returns those without a fault; of the others nothing but rows is written
std::uint32_t Environment::conclude_octets(StateGroup& group, GroupWork& work, std::uint32_t octets,
                                           bool is_reset, const Rows& rows) const {
  const RowKernels& kernels = row_kernels();
  octets = kernels.write(octets, work.observation.data(), observation_size(), rows.observation);
  octets = kernels.write(octets, work.reward.data(), 1, rows.reward);
  if (task_.robot_rewards) {
    const int robots = static_cast<int>(scenario().robots.size());
    octets = kernels.are_finite(octets, work.robot_reward.data(), robots);
  }
  keep(group, octets, observation_size(), work.observation.data(),
       group.writable(layout().last_observation, octets));
  std::uint64_t* status = group.writable(kStatus);
  if (is_reset) {
    each_octet(octets, [&](int first) {
      std::fill_n(status + first, kOctet, std::uint64_t{kRunning});
      std::fill_n(rows.status + first, kOctet, std::uint64_t{kRunning});
      std::fill_n(rows.reward + first, kOctet, 0.0f);
    });
  } else {
    kernels.end(octets, work.end.data(), group.bits(kStep),
                static_cast<std::uint64_t>(scenario().stepping.horizon), status, rows.status);
  }
  if (rows.info != nullptr) kernels.write(octets, work.info.data(), info_size_, rows.info);
  if (rows.agent_reward != nullptr) write_agent_rewards(work, octets, is_reset, rows);
  return octets;
}

/// Of octets without a fault.
void Environment::write_agent_rewards(const GroupWork& work, std::uint32_t octets, bool is_reset,
                                      const Rows& rows) const {
  const std::size_t agents = agents_.size();
  const bool own = task_.robot_rewards && !is_reset;
  each_octet(octets, [&](int first) {
    const auto begin = static_cast<std::size_t>(first);
    float* out = rows.agent_reward + begin * agents;
    if (own) {
      for (std::size_t i = 0; i < agents; ++i) {
        const double* reward = work.robot_reward.data() + agents_[i] * kGroupLanes + first;
        for (std::size_t l = 0; l < kOctet; ++l)
          out[l * agents + i] = static_cast<float>(reward[l]);
      }
    } else if (agents == 1) {
      std::memcpy(out, rows.reward + begin, kOctet * sizeof(float));
    } else {
      for (std::size_t l = 0; l < kOctet; ++l) {
        std::fill_n(out + l * agents, agents, rows.reward[begin + l]);
      }
    }
  });
}

/// What the learner gets of one lane, whose status has been decided.
void Environment::write_rows(const StateGroup& group, const GroupWork& work, int lane,
                             double reward, const Rows& rows) const {
  const int lanes = group.lanes();
  const int size = observation_size();
  const std::uint64_t status = group.bits(kStatus)[lane];
  const double* last = group.reals(layout().last_observation);
  float* row = rows.observation + static_cast<std::ptrdiff_t>(lane) * size;
  for (int k = 0; k < size; ++k) row[k] = static_cast<float>(last[k * lanes + lane]);
  rows.reward[lane] = static_cast<float>(reward);
  rows.status[lane] = status;
  if (rows.agent_reward != nullptr) write_agent_rewards(group, work, lane, reward, rows);
  if (rows.info != nullptr) {
    float* out = rows.info + static_cast<std::ptrdiff_t>(lane) * info_size_;
    for (int k = 0; k < info_size_; ++k) {
      out[k] = static_cast<float>(work.info[static_cast<std::size_t>(k * lanes + lane)]);
    }
  }
}

/// Each agent's own reward where the task says it, else the team's.
void Environment::write_agent_rewards(const StateGroup& group, const GroupWork& work, int lane,
                                      double reward, const Rows& rows) const {
  const int lanes = group.lanes();
  const bool is_fault = (group.bits(kStatus)[lane] & kFault) != 0;
  const bool own = task_.robot_rewards && group.bits(kStep)[lane] > 0 && !is_fault;
  float* out = rows.agent_reward + static_cast<std::size_t>(lane) * agents_.size();
  for (const int robot : agents_) {
    *out++ = static_cast<float>(
        own ? work.robot_reward[static_cast<std::size_t>(robot * lanes + lane)] : reward);
  }
}

}  // namespace skybody
