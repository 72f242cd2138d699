// Control levels as text for users and as JSON for programs.
#pragma once

#include <string>
#include <vector>

#include "core/assemble/controller_survey.h"
#include "core/env/compiled_scenario.h"

namespace skybody {

/// Control modes that are possible for one robot of a scenario.
struct RobotModes {
  std::string robot;
  ControllerSurvey survey;
};

/// All levels, and all controllers with their inputs and outputs.
std::string survey_text(const ControllerSurvey& survey);
std::string survey_json(const ControllerSurvey& survey);

/// The chains of a scenario, level by level, then the modes of each robot.
std::string chains_text(const CompiledScenario& compiled, const std::vector<RobotModes>& robots);
std::string chains_json(const CompiledScenario& compiled, const std::vector<RobotModes>& robots);

}  // namespace skybody
