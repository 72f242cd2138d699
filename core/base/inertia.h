// Principal moments of an inertia matrix and whether a body can have it.
#pragma once

#include "core/base/mat3.h"

namespace skybody {

/// Eigenvalues in ascending order. All NaN where an entry is not finite.
Vec3<double> eigenvalues(const SymMat3<double>& matrix);

/// Whether a rigid body can have this inertia about its centre of mass [kg m^2]: finite, positive
/// definite, and no principal moment above the sum of the other two (by more than `tolerance` of
/// it; rounded URDF values of flat bodies reach the bound).
bool is_physical_inertia(const SymMat3<double>& inertia, double tolerance = 1e-6);

/// The inertia of a rigid body near one that no body has, with the same principal axes: moments
/// below the floor are raised to it, then the largest is lowered to the sum of the other two. The
/// floor is 1e-3 of the largest moment, or `mass` times (1 mm)^2 if that is more.
/// @param inertia  about the centre of mass [kg m^2], finite; @param mass  [kg], positive
SymMat3<double> repaired_inertia(const SymMat3<double>& inertia, double mass);

}  // namespace skybody
