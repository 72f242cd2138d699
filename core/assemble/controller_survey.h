// Which signals controllers take and give: each is configured for a robot and asked. The chains
// that lead from one level to another follow from that.
#pragma once

#include <string>
#include <vector>

#include "core/physics/world/world.h"
#include "plugins/host/registry.h"

namespace skybody {

/// A signal with its number of values.
struct Level {
  int signal = -1;  ///< SkybodySignal
  int count = 0;
};

/// One way in which a controller can be used.
struct ControllerMode {
  std::string plugin;
  std::string doc;                   ///< one line
  std::vector<std::string> options;  ///< `form: position`: parameters that differ from the defaults
  Level takes, gives;
  std::vector<double> low, high;  ///< what actions -1 and +1 mean, one per value that it takes
  bool passes_on = false;         ///< gives what it takes, of any level, such as `delay`
};

/// A controller that could not be asked.
struct RefusedController {
  std::string plugin;
  std::string reason;  ///< in its own words
};

/// What controllers do for one robot.
struct ControllerSurvey {
  std::vector<ControllerMode> modes;  ///< in the order of the entries, defaults first
  std::vector<RefusedController> refused;
};

/// Configures each controller for one robot, once for each combination of its words (parameters
/// that have choices or are switches). Of combinations that take and give the same, the one closest
/// to the defaults counts. Parameters that are required get a value within their range. Where a
/// controller refuses its defaults, lists of names get that of the robot's first moving joint, then
/// zeros become ones, then lists of any length a path: two times, and three values for each.
/// @param entries  usable controllers
ControllerSurvey survey_controllers(const std::vector<const PluginEntry*>& entries,
                                    const Topology& topology, int robot);

/// A quadrotor with a joint, for surveys that are about no robot in particular.
Topology survey_vehicle();

/// The shortest row of controllers that takes one level and gives another.
/// @param from  count 0: with any number of values
/// @param to    SkybodySignal; -1: any that actuators take
/// @returns places within `survey.modes`; empty: there is none, or nothing is between them
std::vector<int> shortest_chain(const ControllerSurvey& survey, const Level& from, int to);

/// "`attitude`, then `ctbr`"; with options "`position` (`input: trajectory`)".
std::string chain_text(const ControllerSurvey& survey, const std::vector<int>& chain);

/// The same as a scenario's list: "[{plugin: attitude}, {plugin: ctbr}]".
std::string chain_yaml(const ControllerSurvey& survey, const std::vector<int>& chain);

}  // namespace skybody
