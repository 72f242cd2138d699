#include "core/env/outcome_phase.h"

#include <algorithm>
#include <cstring>

#include "core/base/simd/lane_mask.h"
#include "core/env/group_lanes.h"
#include "core/env/group_workspace.h"
#include "core/env/plugin_call.h"
#include "core/env/row_conversion.h"

namespace skybody {
namespace {

/// Reason bits of a lane's fault, without those of its state.
std::uint64_t reason_bits(const GroupWorkspace& work, int lane, std::uint32_t finite) {
  const auto bit = [lane](std::uint32_t lanes, std::uint64_t reason) {
    return ((lanes >> lane) & 1u) != 0 ? reason : std::uint64_t{0};
  };
  return bit(~finite, kBadOutcome) | bit(work.faults.bad_action, kBadAction) |
         bit(work.faults.bad_start, work.faults.start_status[static_cast<std::size_t>(lane)]);
}

}  // namespace

void OutcomePhase::evaluate(StateGroup& group, GroupWorkspace& work, const SkybodyLanes& view,
                            bool wants_info) const {
  work.outcome.clear(wants_info);
  AlignedArray<double>& values =
      plan_.is_task_in_place ? work.outcome.observation : work.outcome.task_values;
  const SkybodyEvaluation out{values.data(),
                              work.outcome.reward.data(),
                              work.outcome.end.data(),
                              work.outcome.robot_reward.data(),
                              work.outcome.info.data(),
                              wants_info ? 1u : 0u};
  call_plugin(
      model_.task().kernels.evaluate, model_.task(), group, view,
      [&] {
        return CallSizes{0,
                         model_.task().channel_count(),
                         value_count(model_.task().task.infos),
                         "observation",
                         values.data(),
                         wants_info ? work.outcome.info.data() : nullptr};
      },
      &out);
  if (wants_info) write_reports(group, work);
  gather_observation(group, work);
}

/// Appends to the task's infos: values that other plugins keep in their buffers, then randomizable
/// values.
void OutcomePhase::write_reports(const StateGroup& group, GroupWorkspace& work) const {
  const int lanes = group.lanes();
  double* to = work.outcome.info.data() + value_count(model_.task().task.infos) * lanes;
  for (const auto& list : model_.plugins) {
    for (const PluginInstance& p : list) {
      for (const Report& report : p.reports) {
        const double* from =
            group.reals(model_.layout().plugin_state.offset + p.memory.buffer + report.word);
        to = std::copy_n(from, report.info.count * lanes, to);
      }
    }
  }
  for (const int param : model_.info_params) {
    to = std::copy_n(group.reals(model_.layout().params.offset + param), lanes, to);
  }
}

/// Assembles the observation if the task has not written all of it in place.
void OutcomePhase::gather_observation(const StateGroup& group, GroupWorkspace& work) const {
  const int lanes = group.lanes();
  for (const ValueCopy& copy : plan_.task_copies) {
    double* const values = work.outcome.task_values.data();
    std::copy_n(values + copy.from * lanes, copy.count * lanes, values + copy.to * lanes);
  }
  for (const ObservationPart& part : plan_.parts) {
    const double* values =
        part.is_of_task ? work.outcome.task_values.data() : group.reals(model_.layout().sensors);
    std::copy_n(values + part.from * lanes, part.count * lanes,
                work.outcome.observation.data() + part.to * lanes);
  }
}

void OutcomePhase::finish(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                          bool is_reset, const Rows& rows) const {
  const RowKernels& kernels = row_kernels();
  const int lanes = group.lanes();
  std::uint32_t finite = write_observation(work, mask, rows) &
                         kernels.write(mask, lanes, work.outcome.reward.data(), 1, rows.reward);
  if (model_.task().task.robot_rewards) finite &= finite_robot_rewards(work, mask);
  if (is_reset) {  // no action was taken yet: no reward and no end
    work.outcome.clear_verdict();
    kernels.write(mask, lanes, work.outcome.reward.data(), 1, rows.reward);
  }
  keep_observation(group, work, finite);
  kernels.end(mask, work.outcome.end.data(), group.bits(kStep),
              static_cast<std::uint64_t>(model_.scenario().stepping.horizon),
              group.writable(kStatus), rows.status);
  const std::uint32_t faults =
      mask & (work.faults.bad_action | work.faults.bad_state | work.faults.bad_start | ~finite);
  if (faults != 0) finish_faults(group, work, faults, finite, rows);
  if (rows.info != nullptr) {
    const int infos = value_count(model_.info_channels);
    kernels.write(mask, lanes, work.outcome.info.data(), infos, rows.info);
  }
  if (rows.images != nullptr) write_images(group, mask, rows);
  if (rows.agent_reward != nullptr) write_agent_rewards(work, mask, rows);
}

/// Stores the observation in the state, without values that repeat others.
void OutcomePhase::keep_observation(StateGroup& group, const GroupWorkspace& work,
                                    std::uint32_t mask) const {
  const double* from = work.outcome.observation.data();
  double* to = group.writable(model_.layout().last_observation, mask);
  if (plan_.row.copies.empty()) return keep(group, mask, plan_.size(), from, to);
  const auto keep_run = [&](int first, int count) {
    const int at = first * group.lanes();
    if (count > 0) keep(group, mask, count, from + at, to + at);
  };
  for (const ValueRun& run : plan_.row.written) keep_run(run.first, run.count);
  keep_run(plan_.observation_size, plan_.privileged_size);
}

/// Writes rows of observations from values in lanes. @returns the lanes whose values are finite
std::uint32_t OutcomePhase::write_row(std::uint32_t mask, int lanes, const double* values,
                                      float* rows) const {
  const RowKernels& kernels = row_kernels();
  if (plan_.row.copies.empty()) {
    return kernels.write(mask, lanes, values, plan_.observation_size, rows);
  }
  return kernels.write_parts(mask, lanes, values, plan_.row, rows);
}

/// @returns the lanes whose values are finite, the privileged ones included
std::uint32_t OutcomePhase::write_observation(GroupWorkspace& work, std::uint32_t mask,
                                              const Rows& rows) const {
  const RowKernels& kernels = row_kernels();
  const int lanes = work.lanes, size = plan_.observation_size;
  const std::uint32_t finite =
      write_row(mask, lanes, work.outcome.observation.data(), rows.observation);
  if (plan_.privileged_size == 0) return finite;
  const double* privileged = work.outcome.observation.data() + size * lanes;
  if (rows.privileged == nullptr) {
    return finite & kernels.are_finite(mask, lanes, privileged, plan_.privileged_size);
  }
  return finite & kernels.write(mask, lanes, privileged, plan_.privileged_size, rows.privileged);
}

/// A fault does not change images: they are written as the sensors last made them. NaN in a float32
/// image is the sensor's responsibility.
void OutcomePhase::write_images(const StateGroup& group, std::uint32_t mask,
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
void OutcomePhase::write_last_observation(const StateGroup& group, std::uint32_t mask,
                                          const Rows& rows) const {
  const int lanes = group.lanes();
  const double* values = group.reals(model_.layout().last_observation);
  write_row(mask, lanes, values, rows.observation);
  if (rows.privileged == nullptr || plan_.privileged_size == 0) return;
  row_kernels().write(mask, lanes, values + plan_.observation_size * lanes, plan_.privileged_size,
                      rows.privileged);
}

/// The lanes in which every agent's own reward is finite.
std::uint32_t OutcomePhase::finite_robot_rewards(const GroupWorkspace& work,
                                                 std::uint32_t mask) const {
  for (const int robot : model_.agents) {
    const double* reward = work.outcome.robot_reward.data() + robot * work.lanes;
    mask = row_kernels().are_finite(mask, work.lanes, reward, 1);
  }
  return mask;
}

/// @param finite  lanes with finite observation and rewards: their current observation is also the
///   last finite one
void OutcomePhase::finish_faults(StateGroup& group, GroupWorkspace& work, std::uint32_t faults,
                                 std::uint32_t finite, const Rows& rows) const {
  write_last_observation(group, faults & ~finite, rows);
  each_lane(faults, [&](int lane) {
    const auto l = static_cast<std::size_t>(lane);
    rows.status[l] = kTruncated | kFault | reason_bits(work, lane, finite);
    if (((work.faults.bad_state >> lane) & 1u) != 0) {
      rows.status[l] |= faults_.bad_state_bits(group, lane);
    }
    group.writable(kStatus)[l] = rows.status[l];
    work.outcome.reward[l] = 0.0;
    for (const int robot : model_.agents) {
      work.outcome.robot_reward[static_cast<std::size_t>(robot * group.lanes() + lane)] = 0.0;
    }
    rows.reward[l] = 0.0f;
  });
}

/// Each agent's own reward if the task provides it, else the team's.
void OutcomePhase::write_agent_rewards(GroupWorkspace& work, std::uint32_t mask,
                                       const Rows& rows) const {
  double* to = work.outcome.agent_reward.data();
  for (const int robot : model_.agents) {
    const double* own = work.outcome.robot_reward.data() + robot * work.lanes;
    to = std::copy_n(model_.task().task.robot_rewards ? own : work.outcome.reward.data(),
                     work.lanes, to);
  }
  row_kernels().write(mask, work.lanes, work.outcome.agent_reward.data(),
                      static_cast<int>(model_.agents.size()), rows.agent_reward);
}

}  // namespace skybody
