// Scratch of one thread for stepping groups of a compiled scenario.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "core/env/param_request.h"
#include "core/env/state_group.h"
#include "core/physics/contact/contact.h"
#include "core/plugin_abi/abi.h"

namespace skybody {

/// Values between the controllers of a transition, in lanes.
struct ControlScratch {
  AlignedArray<double> signal[2];     ///< between controllers
  AlignedArray<double> action;        ///< in the task's units
  AlignedArray<double> command_from;  ///< start values of interpolated commands
  AlignedArray<double> command_to;    ///< their end values
};

/// The task's evaluation of a transition, in lanes.
struct TaskOutcome {
  AlignedArray<double> observation;   ///< the privileged values last
  AlignedArray<double> task_values;   ///< the task's values, if their order differs
  AlignedArray<double> reward;        ///< 1 per lane
  AlignedArray<double> robot_reward;  ///< 1 per robot
  AlignedArray<double> agent_reward;  ///< 1 per agent
  AlignedArray<double> info;
  AlignedArray<std::uint64_t> end;  ///< 1 per lane

  /// Called before the task's evaluate(): values that the task does not write are 0.
  void clear(bool wants_info) {
    clear_verdict();
    if (wants_info) info.fill_zero();
  }
  /// Sets rewards and end bits to 0.
  void clear_verdict() {
    reward.fill_zero();
    end.fill_zero();
    robot_reward.fill_zero();
  }
};

/// Values around the randomizers' draws, in lanes.
struct DrawScratch {
  AlignedArray<double> in_time;         ///< parameters before a draw during an episode
  AlignedArray<std::uint64_t> undrawn;  ///< words that a reset's draws change, before the draws
  AlignedArray<std::uint64_t> number;   ///< counters of requested and repeated draws, 1 per lane
};

/// Lanes with a fault in the current transition.
struct LaneFaults {
  std::uint32_t bad_action = 0, bad_state = 0, bad_start = 0;
  AlignedArray<std::uint64_t> start_status;  ///< status bits of the lanes in bad_start, 1 per lane

  /// Begins a transition: no lane has a fault.
  void clear() { bad_action = bad_state = bad_start = 0; }
};

/// Made by ScenarioModel::make_workspace for groups of one size. No content survives a call: any
/// group may be stepped with any workspace of its scenario.
class GroupWorkspace {
 public:
  /// Requests of one lane, in order.
  using Requests = std::span<const std::shared_ptr<const ParamRequest>>;

  /// Removes all requests for a reset.
  void clear_requests() { std::fill(requests.begin(), requests.end(), Requests()); }

  int lanes = 1;
  std::vector<Requests> requests;  ///< for the next reset, one per lane: set and cleared by callers
  SkybodyChecks checks{};          ///< limits in checked mode
  PhysicsScratch physics;
  AlignedArray<double> scratch;  ///< for one call of a plugin: in lanes, or one block
  ControlScratch control;
  TaskOutcome outcome;
  DrawScratch draws;
  LaneFaults faults;
  std::vector<Contact> contacts;          ///< of one lane
  std::vector<std::uint8_t*> image_rows;  ///< for Rows::images, one per image of the observation
};

}  // namespace skybody
