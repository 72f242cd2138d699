// Fills the layout of a world: the physics' blocks first, what core/env appends afterwards.
#pragma once

#include "core/physics/world.h"

namespace skybody {

/// Sizes of the blocks header, q, u, rotor_speed and rotor_command, the layout of each robot, and
/// the EnvParams of bodies, rotors and disturbances. World's constructor calls it.
void add_physics_layout(World& world);

/// Appends one randomizable value. @returns its index within the parameter block.
int add_param(Layout& layout, const EnvParam& param);

/// Sizes of wrench, drive and params from `sites`, `drives` and `param_info`, then the offsets of
/// all blocks and the number of words. Call it once everything else has its size; calling it again
/// after a change is fine.
void finish_layout(World& world);

/// Number of robots whose base is driven; their 13 values lie in the drive block in robot order.
int count_driven(const World& world);

}  // namespace skybody
