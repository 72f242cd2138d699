// URDF -> RobotModel.
//
// Supported:
// - links with inertials in rotated frames, visuals and collisions (box, cylinder, sphere, mesh)
// - joints: fixed (merged exactly), revolute, continuous, prismatic, floating. Two or three
//   revolute or continuous joints in one place make a universal or ball joint (urdf_bodies.h).
//   Planar and other types are errors.
// Warnings, each with its line: unknown elements, missing meshes, massless links on fixed joints,
// joints that are read as fixed. A missing mesh is an error only if the link has no collision shape
// of another kind.
//
// The base. The root link moves freely, or is welded to the world with `fixed_base`. A root link
// called `world` is the world itself; it has no body and no mass. Its joints:
// - fixed: the child is a fixed base
// - floating: the child is a free base. It must be the only child of `world`. The joint's <origin>
//   is ignored: the scenario's pose places the base. `fixed_base` welds it.
// - any other: the child moves relative to the world
#pragma once

#include <optional>
#include <set>
#include <string>

#include "core/io/yaml/diagnostics.h"
#include "core/model/robot_model.h"

namespace skybody {

/// The scenario's options for a model.
struct UrdfOptions {
  bool fixed_base = false;      ///< weld the root link to the world; it then needs no mass
  bool repair_inertia = false;  ///< repair physically invalid inertias instead of reporting errors
  std::set<std::string> fixed_joints = {};  ///< turn with a rotor: read as fixed, with a warning
  std::set<std::string> own_joints = {};    ///< excluded from universal joints
};

/// Reads `file`. Returns nullopt and errors with file and line if it is invalid. Rotors stay empty.
std::optional<RobotModel> read_urdf(const std::string& file, const UrdfOptions& options,
                                    Diagnostics& diagnostics);

/// The same for a text; `file` is for messages and for finding meshes.
std::optional<RobotModel> parse_urdf(const std::string& text, const std::string& file,
                                     const UrdfOptions& options, Diagnostics& diagnostics);

}  // namespace skybody
