// Collision shapes of a scenario, for Python.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/env/compiled_scenario.h"

namespace skybody::python {

/// SkybodyShapeInfo with its own texts.
struct NamedShape {
  int id = 0;
  std::string name, kind, mesh;
  std::vector<double> size;
  std::array<double, 3> position{};
  std::array<double, 4> rotation{};
  std::optional<std::string> robot;
  int body = -1, obstacle = -1, first_param = -1;
};

std::vector<NamedShape> shapes_of(const CompiledScenario& compiled);
std::vector<NamedShape> obstacles_of(const CompiledScenario& compiled);

}  // namespace skybody::python
