// What the forces of couplings do: for each row, to u and to the rates of all rows. One function
// for each width of packs, since its code is long and several places call it.
#pragma once

#include "core/physics/coupling/coupling_workspace.h"

namespace skybody {

/// What to find the response of.
template <class Real>
struct CouplingResponseCall {
  const CouplingScene& scene;
  const MultibodyTree& multibody;
  const CouplingWorkspace<Real>& work;  ///< `rows` placed; `change`, `mass` and `least_pivot` are
                                        ///< written
  const Real* q;
  const BodyKinematics<Real>* motion;  ///< of all bodies that are held, at q
};

/// @param call  a CouplingResponseCall of the width's type of number
using CouplingResponseFunction = void(const void* call);

/// @param lanes  1: of doubles; else of packs
CouplingResponseFunction* coupling_response_function(int lanes);

/// Finds what a unit force of each row does.
template <class Real>
SKYBODY_INLINE void respond_to_unit_forces(const CouplingResponseCall<Real>& call) {
  coupling_response_function(kLanesOf<Real>)(&call);
}

}  // namespace skybody
