// Chains of controllers: from a command to actuators.
#pragma once

#include <string>
#include <vector>

#include "core/env/plugin_instance.h"
#include "core/physics/world/world.h"

namespace skybody {

/// A part of the last controller's output, and where it goes.
struct ChainEnd {
  int signal = 0;                  ///< SkybodySignal
  int count = 0;                   ///< values
  Block Layout::*block = nullptr;  ///< rotor_command, wrench, drive or joint_command
  int first = 0;                   ///< within that block
};

/// Consecutive controllers of one robot, each taking what the one before it gives.
struct ControllerChain {
  int robot = 0;
  int first = 0, count = 0;  ///< within the world's controllers, in robot order
  int signal = 0;            ///< SkybodySignal that the first one takes
  int command = 0;           ///< first word within the command block
  int inputs = 0;            ///< number of these
  std::vector<ChainEnd> ends;
};

/// Chains the controllers of each robot: behind one that gives signals to actuators another chain
/// begins. Gives commands, sites and drives their places in the plan.
/// @param controllers  of all robots, in robot order
/// @throws MarkedError at the scenario's line where they do not fit
std::vector<ControllerChain> connect_controllers(const Scenario& scenario,
                                                 const std::vector<PluginInstance>& controllers,
                                                 WorldPlan& plan);

/// The word for a signal, such as "rotor_speed".
const char* signal_name(int signal);

}  // namespace skybody
