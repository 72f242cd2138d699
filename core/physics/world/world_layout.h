// Makes the layout of a world. The blocks of the physics come first; core/env adds those of
// plugins.
#pragma once

#include "core/physics/world/world.h"

namespace skybody {

/// Sizes of the blocks header, q, u, rotor_speed and rotor_command, the layout of each robot, and
/// the EnvParams of the physical constants.
StateLayout physics_layout(const Topology& topology);

/// Appends one randomizable value. @returns its index within the parameter block.
int add_param(StateLayout& layout, const EnvParam& param);

/// The plan's layout, completed: sizes of wrench, drive, joint drives, held inputs and params,
/// offsets of all blocks, and the number of words. Called by World's constructor.
StateLayout finish_layout(const WorldPlan& plan);

/// Number of words of a held input (SkybodyHeldInput), whether or not the plan holds it.
int held_size(const WorldPlan& plan, int input);

/// Number of robots with a driven base. The drive block contains kDriveSize values of each, in
/// robot order.
int count_driven(const std::vector<DriveKind>& drives);

}  // namespace skybody
