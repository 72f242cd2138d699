// Converts groups of links and URDF joints into bodies with canonical joints. Internal to core/io's
// URDF reader.
#pragma once

#include "core/io/urdf/urdf_links_and_joints.h"
#include "core/io/urdf/urdf_merge.h"
#include "core/io/urdf/urdf_reader.h"
#include "core/io/yaml/diagnostics.h"
#include "core/model/robot_model.h"

namespace skybody {

/// Fills bodies and links of `model`.
/// - Consecutive revolute or continuous joints become one joint, named after the last of them: two
///   a universal joint, three a ball joint. They must have one origin, orthogonal axes and no
///   limits, with only massless, shapeless links between them. Of two, none may be in `own_joints`.
/// - Every other massless link that moves gets a light mass, with a warning; or an error, if a
///   motion would then have no inertia.
/// - `fixed_base` welds the base to the world.
void make_bodies(const UrdfDocument& document, const UrdfGroups& groups, const UrdfOptions& options,
                 RobotModel& model, Diagnostics& diagnostics);

/// Sets stiffness and damping of every joint limit from the masses that it stops:
///   stiffness = I w^2,  damping = 2 I w,  w = 100 rad/s
/// This is a critically damped stop that 1 ms steps resolve. I is the reduced inertia about the
/// joint's axis at zero (for a slider: the reduced mass along it) of the outboard bodies against
/// the rest of the robot (against the world, if the robot is fixed).
void derive_limit_springs(RobotModel& model);

}  // namespace skybody
