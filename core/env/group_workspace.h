// Scratch of one thread while it steps groups of a compiled scenario.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/env/compiled_scenario.h"
#include "core/env/param_request.h"

namespace skybody {

/// Made by CompiledScenario::make_workspace for groups of one size. Nothing in it survives a call:
/// any group may be stepped with any work of its compiled scenario.
class GroupWorkspace {
 public:
  /// Before the task speaks: what it leaves out is 0.
  void clear_outcome(bool wants_info) {
    clear_verdict();
    if (wants_info) info.fill_zero();
  }

  /// A transition begins: no lane has a fault.
  void clear_faults() { bad_action = bad_state = bad_start = 0; }

  /// Nothing is asked for at a reset.
  void clear_requests() { std::fill(requests.begin(), requests.end(), Requests()); }

  /// Rewards and end to 0.
  void clear_verdict() {
    reward.fill_zero();
    end.fill_zero();
    robot_reward.fill_zero();
  }

  /// In order.
  using Requests = std::span<const std::shared_ptr<const ParamRequest>>;

  int lanes = 1;
  std::vector<Requests> requests;  ///< for the next reset, one per lane: set and cleared by callers
  bool is_checked = false;         ///< plugins are held to the values that they may touch
  SkybodyChecks checks{};          ///< of a checked work
  PhysicsScratch physics;
  AlignedArray<double> signal[2];       ///< between controllers, in lanes
  AlignedArray<double> scratch;         ///< of one call of a plugin, in lanes
  AlignedArray<double> action;          ///< in the task's units, in lanes
  AlignedArray<double> command_from;    ///< where commands that change begin, in lanes
  AlignedArray<double> command_to;      ///< and where they go
  AlignedArray<double> observation;     ///< in lanes, the privileged values last
  AlignedArray<double> task_values;     ///< of the task, where they have other places there
  AlignedArray<double> reward;          ///< 1 per lane
  AlignedArray<double> robot_reward;    ///< 1 per robot, in lanes
  AlignedArray<double> agent_reward;    ///< 1 per agent, in lanes
  AlignedArray<double> info;            ///< in lanes
  AlignedArray<std::uint64_t> end;      ///< 1 per lane
  AlignedArray<std::uint64_t> request;  ///< counters of requested draws, 1 per lane
  std::vector<Contact> contacts;        ///< of one lane
  std::vector<SpatialForce<double>> joint_reactions;  ///< of one lane, one per body
  std::vector<std::uint8_t*> image_rows;     ///< for Rows::images, one per image of the observation
  AlignedArray<double> drawn;                ///< what a randomizer writes, before it draws in time
  AlignedArray<std::uint64_t> undrawn;       ///< words that a reset's draws change, before them, in
                                             ///< lanes; empty: no start is drawn again
  AlignedArray<std::uint64_t> start_status;  ///< of lanes of bad_start: the status bits, 1 per lane
  std::uint32_t bad_action = 0;              ///< lanes of the present transition with such a fault
  std::uint32_t bad_state = 0;               ///< likewise
  std::uint32_t bad_start = 0;               ///< likewise
};

}  // namespace skybody
