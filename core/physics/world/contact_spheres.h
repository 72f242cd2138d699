// Spheres at the extremities of collision shapes: what rests on the ground.
#pragma once

#include <vector>

#include "core/physics/world/world.h"

namespace skybody {

/// Per body and shape, in order: a box gives its 8 corners, a cylinder 8 points on each rim, a
/// sphere itself; meshes give nothing. Stiffness k per robot: resting upright on the n spheres that
/// lie lowest with joints at zero, each sinks in by x0 = ContactSettings::penetration,
///   k = m |g| / (n x0^1.5),
/// but no more than lets dt follow the oscillation of the sphere's own body (contact_spheres.cpp).
std::vector<ContactSphere> make_contact_spheres(const World& world);

/// |g| for contact stiffness [m/s^2]: the scenario's, or 9.81 where it has no gravity.
double contact_gravity(const Scenario& scenario);

}  // namespace skybody
