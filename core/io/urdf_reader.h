// URDF -> RobotModel.
//
// Supported: links with inertials in rotated frames, visuals and collisions (box, cylinder, sphere,
// mesh); fixed joints (merged exactly), revolute, continuous, prismatic, floating. Two or three
// revolute or continuous joints in one place make a universal or ball joint (urdf_joints.h). Planar
// and other types are errors. Elements that are not URDF, meshes that are missing, massless links
// on fixed joints and joints that are read as fixed are warnings, each with its line; a missing
// mesh is an error only where it is the link's sole kind of collision shape.
//
// The base. The root link moves freely, or is welded to the world with `fixed_base`. A root link
// called `world` stands for the world itself: what a fixed joint attaches to it is a fixed base, a
// floating joint gives a free one (which must be the only child of `world`; its <origin> is
// ignored, the scenario's pose places the base; `fixed_base` welds it), any other joint moves
// against the world. The link `world` has no body and no mass.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "core/io/diagnostics.h"
#include "core/model/robot_model.h"

namespace skybody {

/// What the scenario says about a model.
struct UrdfOptions {
  bool fixed_base = false;      ///< weld the root link to the world; it needs no mass then
  bool repair_inertia = false;  ///< an inertia that no rigid body has: mend it in place of an error
  std::set<std::string> fixed_joints = {};  ///< turn with a rotor: read as fixed, with a warning
  std::set<std::string> own_joints = {};    ///< kept out of universal joints
};

/// Reads `file`; nothing and errors with file and line if anything is wrong. Rotors stay empty.
std::optional<RobotModel> read_urdf(const std::string& file, const UrdfOptions& options,
                                    Diagnostics& diagnostics);

/// The same from text; `file` is for messages and for finding meshes.
std::optional<RobotModel> parse_urdf(const std::string& text, const std::string& file,
                                     const UrdfOptions& options, Diagnostics& diagnostics);

}  // namespace skybody
