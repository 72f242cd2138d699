// Robots and their bodies by name, for an effect's configure().
#pragma once

#include <skybody/plugin.h>

#include <algorithm>
#include <string>
#include <vector>

namespace skybody::effect {

/// Indices of the robots called `names`, in the scenario's order; without names all.
/// @throws std::runtime_error if there is no robot of a name
inline std::vector<int> robots_called(const Setup& setup, const std::vector<std::string>& names) {
  std::vector<int> robots;
  for (const std::string& name : names) robots.push_back(setup.robot(name));
  for (int r = 0; names.empty() && r < setup.robots().size(); ++r) robots.push_back(r);
  std::sort(robots.begin(), robots.end());
  robots.erase(std::unique(robots.begin(), robots.end()), robots.end());
  return robots;
}

/// World indices of all their bodies.
inline std::vector<int> bodies_of(const Setup& setup, const std::vector<int>& robots) {
  std::vector<int> bodies;
  for (const int robot : robots) {
    const RobotInfo& r = setup.robots()[robot];
    for (int b = 0; b < r.body_count; ++b) bodies.push_back(r.first_body + b);
  }
  return bodies;
}

}  // namespace skybody::effect
