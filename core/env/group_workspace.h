// Scratch of one thread for stepping groups of a compiled scenario.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "core/env/compiled_scenario.h"
#include "core/env/param_request.h"

namespace skybody {

/// Made by CompiledScenario::make_workspace for groups of one size. No content survives a call: any
/// group may be stepped with any workspace of its compiled scenario.
class GroupWorkspace {
 public:
  /// Called before the task's evaluate(): values that the task does not write are 0.
  void clear_outcome(bool wants_info) {
    clear_verdict();
    if (wants_info) info.fill_zero();
  }

  /// Begins a transition: no lane has a fault.
  void clear_faults() { bad_action = bad_state = bad_start = 0; }

  /// Removes all requests for a reset.
  void clear_requests() { std::fill(requests.begin(), requests.end(), Requests()); }

  /// Sets rewards and end bits to 0.
  void clear_verdict() {
    reward.fill_zero();
    end.fill_zero();
    robot_reward.fill_zero();
  }

  /// Requests of one lane, in order.
  using Requests = std::span<const std::shared_ptr<const ParamRequest>>;

  int lanes = 1;
  std::vector<Requests> requests;  ///< for the next reset, one per lane: set and cleared by callers
  bool is_checked = false;         ///< checked mode: plugins may touch only their own values
  SkybodyChecks checks{};          ///< limits in checked mode
  PhysicsScratch physics;
  AlignedArray<double> signal[2];       ///< between controllers, in lanes
  AlignedArray<double> scratch;         ///< for one call of a plugin, in lanes
  AlignedArray<double> action;          ///< in the task's units, in lanes
  AlignedArray<double> command_from;    ///< start values of interpolated commands, in lanes
  AlignedArray<double> command_to;      ///< their end values, in lanes
  AlignedArray<double> observation;     ///< in lanes, the privileged values last
  AlignedArray<double> task_values;     ///< the task's values, if their order differs from the
                                        ///< observation's
  AlignedArray<double> reward;          ///< 1 per lane
  AlignedArray<double> robot_reward;    ///< 1 per robot, in lanes
  AlignedArray<double> agent_reward;    ///< 1 per agent, in lanes
  AlignedArray<double> info;            ///< in lanes
  AlignedArray<std::uint64_t> end;      ///< 1 per lane
  AlignedArray<std::uint64_t> request;  ///< counters of requested draws, 1 per lane
  std::vector<Contact> contacts;        ///< of one lane
  std::vector<SpatialForce<double>> joint_reactions;  ///< of one lane, one per body
  std::vector<std::uint8_t*> image_rows;     ///< for Rows::images, one per image of the observation
  AlignedArray<double> drawn;                ///< parameters of a randomizer before it draws during
                                             ///< an episode
  AlignedArray<std::uint64_t> undrawn;       ///< words that a reset's draws change, before the
                                             ///< draws, in lanes; empty: no start is drawn again
  AlignedArray<std::uint64_t> start_status;  ///< status bits of the lanes in bad_start, 1 per lane
  std::uint32_t bad_action = 0;              ///< lanes with this fault in the current transition
  std::uint32_t bad_state = 0;               ///< as above
  std::uint32_t bad_start = 0;               ///< as above
};

}  // namespace skybody
