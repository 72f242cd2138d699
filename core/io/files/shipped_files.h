// Scenarios, models, references and policies shipped with Skybody, by name.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace skybody {

/// The shipped scenario called `name` (hover -> scenarios/hover.yaml), or nullopt.
std::optional<std::filesystem::path> find_shipped_scenario(const std::string& name);

/// Names of all shipped scenarios, sorted.
std::vector<std::string> shipped_scenarios();

/// The shipped model called `name` (crazyflie -> scenarios/models/crazyflie/crazyflie.urdf), or
/// nullopt.
std::optional<std::filesystem::path> find_shipped_model(const std::string& name);

/// Names of all shipped models, sorted.
std::vector<std::string> shipped_models();

/// The shipped reference called `name` (circle -> scenarios/references/circle.yaml), or nullopt.
std::optional<std::filesystem::path> find_shipped_reference(const std::string& name);

/// Names of all shipped references, sorted.
std::vector<std::string> shipped_references();

/// The policy shipped for the scenario called `name` (hover_learn ->
/// scenarios/policies/hover_learn.h5), or nullopt.
std::optional<std::filesystem::path> find_shipped_policy(const std::string& name);

/// Names of all scenarios with a shipped policy, sorted.
std::vector<std::string> shipped_policies();

}  // namespace skybody
