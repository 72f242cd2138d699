#include "core/physics/bodies/checked_mass.h"

#include <cstdio>

#include "core/base/math/inertia.h"
#include "core/base/system/error.h"

namespace skybody {

namespace {

bool has_mass(const MassProperties& mass) {
  return mass.mass > 0.0 && is_finite(mass.mass) && is_finite(mass.com);
}

}  // namespace

bool is_possible(const MassProperties& mass) {
  return has_mass(mass) && is_physical_inertia(mass.inertia);
}

MassProperties checked_mass(const std::string& name, const double* params) {
  MassProperties out = mass_properties(params);
  SymMat3<double>& inertia = out.inertia;
  if (!has_mass(out)) {
    char value[32];
    std::snprintf(value, sizeof(value), "%g", out.mass);
    throw Error("body '" + name + "' has mass " + value +
                " kg; it must be positive, and the centre of mass finite");
  }
  if (!is_physical_inertia(inertia)) {
    throw Error("body '" + name +
                "' has an inertia that no rigid body can have: principal moments " +
                "must be positive, none above the sum of the other two");
  }
  // Simbody rejects every inertia beyond the bound.
  const Vec3<double> moments = eigenvalues(inertia);
  const double excess = moments.z - (moments.x + moments.y);
  if (excess > 0.0) {
    const double more = 1.001 * excess;
    inertia = inertia + SymMat3<double>{more, more, more, 0.0, 0.0, 0.0};
  }
  return out;
}

}  // namespace skybody
