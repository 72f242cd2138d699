// Makes the layout of a world: the physics' blocks first; what plugins need is added by core/env.
#pragma once

#include "core/physics/world/world.h"

namespace skybody {

/// Sizes of the blocks header, q, u, rotor_speed and rotor_command, the layout of each robot, and
/// the EnvParams of the physical constants.
Layout physics_layout(const Topology& topology);

/// Appends one randomizable value. @returns its index within the parameter block.
int add_param(Layout& layout, const EnvParam& param);

/// The plan's layout with the sizes of wrench, drive, joint drives, held inputs and params, the
/// offsets of all blocks and the number of words. World's constructor calls it.
Layout finish_layout(const WorldPlan& plan);

/// Words of an input that effects hold (SkybodyHeldInput), were it used.
int held_size(const WorldPlan& plan, int input);

/// Number of robots whose base is driven; kDriveSize values of each lie in the drive block, in
/// robot order.
int count_driven(const std::vector<DriveKind>& drives);

}  // namespace skybody
