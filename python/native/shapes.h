// Shapes, rotors and couplings of a scenario, for Python.
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

/// A shape that is drawn.
struct Visual : NamedShape {
  std::array<double, 4> color{};  ///< red, green, blue, opacity, each in [0, 1]
  std::vector<float> corners;     ///< of a mesh's triangles, nine numbers each, unscaled [m]
};

std::vector<NamedShape> shapes_of(const CompiledScenario& compiled);
std::vector<NamedShape> obstacles_of(const CompiledScenario& compiled);
/// @throws Error if a mesh cannot be read
std::vector<Visual> visuals_of(const CompiledScenario& compiled);
/// Triangles of a height field, nine numbers each [m], in the obstacle's frame.
/// @param obstacle  its place among the obstacles
std::vector<float> field_corners(const CompiledScenario& compiled, int obstacle);

/// SkybodyRotorInfo with its own texts.
struct PlacedRotor {
  std::string name;  ///< ROBOT.ROTOR
  int body = 0;
  std::array<double, 3> position{}, axis{};
  double direction = 1.0, thrust_constant = 0.0;
};
std::vector<PlacedRotor> rotors_of(const CompiledScenario& compiled);

/// A coupling with indices of bodies among all.
struct NamedCoupling {
  std::string name, kind;
  std::array<int, 2> bodies{};  ///< -1: the world
  std::array<std::array<double, 3>, 2> points{};
};
std::vector<NamedCoupling> couplings_of(const CompiledScenario& compiled);

}  // namespace skybody::python
