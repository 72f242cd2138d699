// Chains of controllers, from a command to actuators.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/env/plugin_instance.h"
#include "core/model/located_error.h"
#include "core/physics/world/world.h"

namespace skybody {

/// A part of the last controller's output, and its destination.
struct ChainEnd {
  int robot = 0;   ///< robot whose actuators or own chain receive it
  int signal = 0;  ///< SkybodySignal
  int count = 0;   ///< number of values
  Block StateLayout::*block =
      nullptr;     ///< rotor_command, wrench, drive or joint_command; command if it feeds a chain
  int first = 0;   ///< first value within that block
  int feeds = -1;  ///< the first controller of the chain that it feeds, or -1
};

/// Consecutive controllers of one robot or team. Each takes the output of the one before it.
struct ControllerChain {
  int robot = 0;             ///< robot whose action commands it; for a team, its first robot
  int first = 0, count = 0;  ///< within the world's controllers
  int signal = 0;            ///< SkybodySignal of the first controller's input
  int command = 0;           ///< first word within the command block
  int inputs = 0;            ///< number of command words
  int team = -1;             ///< index of the team, or -1
  bool is_fed = false;       ///< whether a team's chain, not the action, gives its command
  std::vector<ChainEnd> ends;
};

/// Two levels of a chain do not match: nothing takes a controller's output. A caller with the list
/// of all plugins can suggest controllers that lead from one level to the other.
class ChainMismatchError : public LocatedError {
 public:
  /// @param given  output signal of the controller before the gap
  /// @param taken  input signal of the next controller; -1: there is no next controller, and
  ///   actuators do not take `given`
  ChainMismatchError(SourceLocation where, const std::string& message, int given, int taken)
      : LocatedError(std::move(where), message), given_(given), taken_(taken) {}
  int given() const { return given_; }
  int taken() const { return taken_; }

 private:
  int given_, taken_;
};

/// Builds the chains of each robot and team. A controller with an output to actuators ends a chain;
/// the next controller begins another. A team's chain ends in actuators or in robots' own chains,
/// which it feeds. Assigns the places of commands, sites and drives in the layout.
/// @param controllers  of all robots, in robot order, then those of teams; a controller that passes
///   its command on gets the range of the controller that takes it
/// @returns first the chains that actions command, in robot order, then the chains that are fed; a
///   chain always follows the one that feeds it
/// @throws LocatedError at the scenario's line where controllers do not match; ChainMismatchError
///   where levels do not match
std::vector<ControllerChain> connect_controllers(const Scenario& scenario,
                                                 std::vector<PluginInstance>& controllers,
                                                 WorldPlan& plan);

/// Whether actuators take a signal: rotors, wrench sites, joint drives or the base's drive.
bool actuates(int signal);

/// The name of a signal, such as "rotor_speed".
const char* signal_name(int signal);

/// The signal's values in words, with units and frames.
const char* signal_meaning(int signal);

}  // namespace skybody
