// Scenarios, models, references and policies shipped with Skybody, by name. A scenario is in the
// folder of its task, with its presets and its policy:
//
//   scenarios/TASK/NAME.yaml
//   scenarios/TASK/training/NAME.yaml
//   scenarios/TASK/policies/NAME.h5
//   scenarios/models/NAME/NAME.urdf
//   scenarios/references/NAME.yaml
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace skybody {

/// The shipped scenario called `name` (racing_drawn -> scenarios/racing/racing_drawn.yaml), or
/// nullopt.
std::optional<std::filesystem::path> find_shipped_scenario(const std::string& name);

/// Names of all shipped scenarios, sorted.
std::vector<std::string> shipped_scenarios();

/// The shipped model called `name` (crazyflie -> scenarios/models/crazyflie/crazyflie.urdf), or
/// nullopt. `name` may also be the path that scenarios contain, models/crazyflie/crazyflie.urdf.
std::optional<std::filesystem::path> find_shipped_model(const std::string& name);

/// Names of all shipped models, sorted.
std::vector<std::string> shipped_models();

/// The shipped reference called `name` (circle -> scenarios/references/circle.yaml), or nullopt.
std::optional<std::filesystem::path> find_shipped_reference(const std::string& name);

/// Names of all shipped references, sorted.
std::vector<std::string> shipped_references();

/// The policy shipped for the scenario called `name` (racing -> scenarios/racing/policies/
/// racing.h5), or nullopt.
std::optional<std::filesystem::path> find_shipped_policy(const std::string& name);

/// Names of all scenarios with a shipped policy, sorted.
std::vector<std::string> shipped_policies();

}  // namespace skybody
