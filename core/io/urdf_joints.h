// From groups of links and URDF joints to bodies with canonical joints. Internal to core/io's URDF
// reader.
#pragma once

#include "core/io/diagnostics.h"
#include "core/io/urdf_document.h"
#include "core/io/urdf_merge.h"
#include "core/io/urdf_reader.h"
#include "core/model/robot_model.h"

namespace skybody {

/// Fills bodies and links of `model`. Two (three) consecutive revolute or continuous joints with
/// one origin, orthogonal axes, no limits, of two none in `own_joints`, and nothing but massless,
/// shapeless links between them become one universal (ball) joint, named after the last of them.
/// Every other massless link that moves gets a light mass, with a warning, or an error where that
/// would leave a motion without inertia. The base is welded to the world with `fixed_base`.
void make_bodies(const UrdfDocument& document, const UrdfGroups& groups, const UrdfOptions& options,
                 RobotModel& model, Diagnostics& diagnostics);

/// Sets stiffness and damping of every joint limit from the masses that it has to stop: with I the
/// reduced inertia about the joint's axis at zero (mass along it for a slider) of what hangs on the
/// joint against the rest of the robot (the world, if the robot is fixed), stiffness = I w^2 and
/// damping = 2 I w with w = 100 rad/s: a critically damped stop that 1 ms steps resolve.
void derive_limit_springs(RobotModel& model);

}  // namespace skybody
