// Obstacles in a world by hand.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "tests/unit/plugin_world.h"

namespace skybody::testing {

/// Adds an obstacle, turned by `yaw` [rad]. @param size  as its kind says [m]
/// @returns its first EnvParam
inline int add_obstacle(PluginWorld& world, int kind, const std::vector<double>& size,
                        const std::vector<double>& position, double yaw = 0.0) {
  SkybodyShapeInfo shape{};
  for (const SkybodyShapeInfo& other : world.shapes) shape.obstacle += other.obstacle >= 0 ? 1 : 0;
  const std::string path = "obstacles.solid_" + std::to_string(shape.obstacle + 1);
  shape.name = world.keep(path.substr(path.find('.') + 1));
  shape.mesh = "";
  shape.kind = kind;
  shape.robot = shape.body = -1;
  shape.first_param = world.add_param(path + ".present", 1.0);
  const double turn[4] = {std::cos(0.5 * yaw), 0.0, 0.0, std::sin(0.5 * yaw)};
  const auto add = [&](const char* what, double* to, const auto& from, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) {
      to[k] = k < std::size(from) ? from[k] : 0.0;
      world.add_param(path + "." + what + "[" + std::to_string(k) + "]", to[k]);
    }
  };
  add("position", shape.position, position, 3);
  add("rotation", shape.rotation, turn, 4);
  add("size", shape.size, size, 3);
  world.shapes.push_back(shape);
  return shape.first_param;
}

}  // namespace skybody::testing
