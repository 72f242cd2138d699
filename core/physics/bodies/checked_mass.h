// Mass properties from an environment's parameters, checked so that every dynamics accepts them.
#pragma once

#include <string>

#include "core/model/robot_model.h"

namespace skybody {

/// Whether the mass properties are physical: the rule of checked_mass().
bool is_possible(const MassProperties& mass);

/// One body's mass properties, checked. Round-off can put the inertia of a flat body just beyond
/// the bound of is_physical_inertia. Such an inertia is moved onto the bound (a change below 1e-6
/// of its moments), so that all dynamics simulate the same body.
/// @param name    the body's, for the message
/// @param params  its kBodyParamCount values
/// @throws Error if the mass properties are not physical
MassProperties checked_mass(const std::string& name, const double* params);

}  // namespace skybody
