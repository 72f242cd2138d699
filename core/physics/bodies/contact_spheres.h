// Spheres at the extremities of collision shapes: what rests on the ground. World's constructor
// makes them (make_contact_spheres in world.h).
#pragma once

#include "core/model/scenario.h"

namespace skybody {

/// |g| for contact stiffness [m/s^2]: the scenario's, or 9.81 where it has no gravity.
double contact_gravity(const Scenario& scenario);

}  // namespace skybody
