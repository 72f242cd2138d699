// Principal moments of an inertia matrix, and tests of physical validity.
#pragma once

#include "core/base/math/mat3.h"

namespace skybody {

/// Eigenvalues in ascending order. All NaN if an entry is not finite.
Vec3<double> eigenvalues(const SymMat3<double>& matrix);

/// Whether the inertia about the centre of mass [kg m^2] is physically valid: finite, positive
/// definite, and no principal moment above the sum of the other two (by more than the fraction
/// `tolerance`; rounded URDF values of flat bodies reach the bound).
bool is_physical_inertia(const SymMat3<double>& inertia, double tolerance = 1e-6);

/// A valid inertia near an invalid one, with the same principal axes: moments below the floor are
/// raised to it, then the largest is lowered to the sum of the other two. The floor is the larger
/// of 1e-3 of the largest moment and `mass` times (1 mm)^2.
/// @param inertia  about the centre of mass [kg m^2], finite; @param mass  [kg], positive
SymMat3<double> repaired_inertia(const SymMat3<double>& inertia, double mass);

}  // namespace skybody
