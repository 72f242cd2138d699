// Chains of controllers: from a command to actuators.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/env/plugin_instance.h"
#include "core/model/located_error.h"
#include "core/physics/world/world.h"

namespace skybody {

/// A part of the last controller's output, and where it goes.
struct ChainEnd {
  int robot = 0;   ///< to whose actuators, or to whose own chain
  int signal = 0;  ///< SkybodySignal
  int count = 0;   ///< values
  Block Layout::*block =
      nullptr;  ///< rotor_command, wrench, drive, joint_command; of a chain that it feeds: command
  int first = 0;   ///< within that block
  int feeds = -1;  ///< the first controller of the chain that it feeds, or -1
};

/// Consecutive controllers of one robot or team, each taking what the one before it gives.
struct ControllerChain {
  int robot = 0;             ///< whose action commands it: of a team its first robot's
  int first = 0, count = 0;  ///< within the world's controllers
  int signal = 0;            ///< SkybodySignal that the first one takes
  int command = 0;           ///< first word within the command block
  int inputs = 0;            ///< number of these
  int team = -1;             ///< of a team: its index
  bool is_fed = false;       ///< a team's chain gives its command, and no action
  std::vector<ChainEnd> ends;
};

/// Levels of a chain that do not meet: nothing takes what a controller gives. Whoever knows all
/// plugins can say which of them lead from one level to the other.
class ChainMismatchError : public LocatedError {
 public:
  /// @param given  signal of the controller before the gap
  /// @param taken  signal of the one behind it; -1: there is none, and actuators do not take
  /// `given`
  ChainMismatchError(SourceLocation where, const std::string& message, int given, int taken)
      : LocatedError(std::move(where), message), given_(given), taken_(taken) {}
  int given() const { return given_; }
  int taken() const { return taken_; }

 private:
  int given_, taken_;
};

/// Chains the controllers of each robot and team: behind one that gives signals to actuators
/// another chain begins. A team's chain ends in actuators, too, or in robots' own chains, which it
/// feeds. Gives commands, sites and drives their places in the plan.
/// @param controllers  of all robots, in robot order, then those of teams; one that passes its
///                     command on gets the range of the one that takes it
/// @returns those that actions command, in robot order, then those that are fed: a chain comes
///          behind the one that feeds it
/// @throws LocatedError at the scenario's line where they do not fit; ChainMismatchError where
/// levels do not
///         meet
std::vector<ControllerChain> connect_controllers(const Scenario& scenario,
                                                 std::vector<PluginInstance>& controllers,
                                                 WorldPlan& plan);

/// Whether actuators take a signal: rotors, wrench sites, joints' drives or the base's drive.
bool actuates(int signal);

/// The word for a signal, such as "rotor_speed".
const char* signal_name(int signal);

/// Its values in words, with units and frames.
const char* signal_meaning(int signal);

}  // namespace skybody
