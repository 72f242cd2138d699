// Mass properties that any dynamics can be built from, out of an environment's parameters.
#pragma once

#include <string>

#include "core/model/robot_model.h"

namespace skybody {

/// Whether a rigid body can have them: the rule of checked_mass().
bool is_possible(const MassProperties& mass);

/// One body's mass properties, checked. The inertia of a flat body that rounding has put just
/// beyond the bound of is_physical_inertia is moved onto it (below 1e-6 of its moments), so that
/// all dynamics move the same body.
/// @param name    the body's, for the message
/// @param params  its kBodyParamCount values
/// @throws Error if no rigid body can have them
MassProperties checked_mass(const std::string& name, const double* params);

}  // namespace skybody
