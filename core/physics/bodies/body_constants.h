// Constants of one body in the form that the tree dynamics uses: recomputed when the parameter
// block changes, read in every step.
#pragma once

#include "core/base/math/mat3.h"
#include "core/physics/bodies/kinematics.h"

namespace skybody {

/// Indices of a body's constants.
enum BodyConstant : int {
  kBodyMass = 0,             ///< [kg]
  kBodyCom = 1,              ///< 3: centre of mass from the body's origin, body axes [m]
  kBodyInertia = 4,          ///< 6: about the centre of mass, body axes [kg m^2]
  kBodyInverseMass = 10,     ///< [1/kg]
  kBodyInverseInertia = 11,  ///< 6: [1/(kg m^2)]
  kBodyConstantCount = 17
};

/// @param values  a pointer to six reals, or a view
template <class Values>
SKYBODY_INLINE auto load_sym_mat3(const Values& p) {
  return SymMat3<std::decay_t<decltype(p[0])>>{p[0], p[1], p[2], p[3], p[4], p[5]};
}

/// Constants of the bodies of a world, one body after another.
/// @param params  the parameter block of one environment
/// @param out     kBodyConstantCount values per body
/// @throws Error (naming the body) for mass properties that no rigid body can have
void make_body_constants(const World& world, const double* params, double* out);

}  // namespace skybody
