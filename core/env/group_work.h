// Scratch of one lane group while it steps: physics of each lane, derived values, buffers.
#pragma once

#include <memory>
#include <vector>

#include "core/env/environment.h"
#include "core/physics/stepper.h"

namespace skybody {

/// Made by Environment::make_work. Nothing in it survives as information: all of it follows from
/// WorldState, so a group may be stepped with any work of its environment.
class GroupWork {
 public:
  struct Lane {
    std::unique_ptr<Stepper> stepper;  ///< made when the lane is first stepped
    LaneState state;                   ///< contiguous copy of the lane's physical values
    bool current = false;              ///< state.bodies belong to the values in `state`
  };

  std::vector<Lane> lanes;
  std::vector<double> bodies;          ///< 13 per body, in lanes: what plugins see
  std::vector<double> signal[2];       ///< between controllers, in lanes
  std::vector<double> observation;     ///< in lanes
  std::vector<double> reward;          ///< 1 per lane
  std::vector<double> robot_reward;    ///< 1 per robot, in lanes
  std::vector<double> info;            ///< in lanes
  std::vector<std::uint64_t> end;      ///< 1 per lane
  std::vector<std::uint64_t> request;  ///< counters of requested draws, 1 per lane
  std::uint32_t bad_action = 0;        ///< lanes of the present transition with such a fault
  std::uint32_t bad_state = 0;         ///< likewise
};

}  // namespace skybody
