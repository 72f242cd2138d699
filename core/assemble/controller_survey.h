// A survey of the controllers' input and output signals: configures each controller for one robot
// and reads its declarations. Finds chains of controllers from one signal to another.
#pragma once

#include <string>
#include <vector>

#include "core/physics/world/world.h"
#include "core/plugin_host/registry.h"

namespace skybody {

/// A signal with its number of values.
struct Level {
  int signal = -1;  ///< SkybodySignal
  int count = 0;
};

/// One configuration of a controller.
struct ControllerMode {
  std::string plugin;
  std::string doc;                   ///< one line
  std::vector<std::string> options;  ///< `form: position`: the parameters that differ from defaults
  Level takes, gives;
  std::vector<double> low, high;  ///< inputs at actions -1 and +1, one per input value
  bool acts = false;              ///< drives actuators, so it can be the last of a chain
  bool passes_on = false;         ///< outputs its input's signal, any one, such as `delay`
};

/// A controller that could not be configured.
struct RefusedController {
  std::string plugin;
  std::string reason;  ///< the controller's message
};

/// The controllers' configurations for one robot.
struct ControllerSurvey {
  std::vector<ControllerMode> modes;  ///< in the order of the entries, defaults first
  std::vector<RefusedController> refused;
};

/// Configures each controller for one robot, once per combination of its choice parameters
/// (parameters with choices, and booleans). Of the combinations with the same input and output, the
/// one closest to the defaults is kept. Required parameters get a value within their range. If a
/// controller rejects its defaults, further values are filled in, step by step:
/// 1. lists of names get the name of the robot's first moving joint
/// 2. zeros become ones
/// 3. lists of any length get a path: two times, and three values for each
/// @param entries  usable controllers
ControllerSurvey survey_controllers(const std::vector<const PluginEntry*>& entries,
                                    const Topology& topology, int robot);

/// A quadrotor with a joint, for surveys without a specific robot.
Topology survey_vehicle();

/// The cheapest chain of controllers from one signal to another. One more controller costs less
/// than an option that differs from its default.
/// @param from  count 0: any number of values
/// @param to    SkybodySignal; -1: any signal of actuators
/// @returns indices into `survey.modes`; empty if no chain exists or none is needed
std::vector<int> shortest_chain(const ControllerSurvey& survey, const Level& from, int to);

/// "`attitude`, then `ctbr`"; with options "`position` (`input: trajectory`)".
std::string chain_text(const ControllerSurvey& survey, const std::vector<int>& chain);

/// The same as a scenario's list: "[{plugin: attitude}, {plugin: ctbr}]".
std::string chain_yaml(const ControllerSurvey& survey, const std::vector<int>& chain);

}  // namespace skybody
