// Effects of unit coupling forces: for each row, on u and on the rates of all rows. The code is
// long and several callers need it, so each width of packs has one function.
#pragma once

#include "core/physics/coupling/coupling_workspace.h"

namespace skybody {

/// Arguments of the response.
template <class Real>
struct CouplingResponseCall {
  const CouplingScene& scene;
  const MultibodyTree& multibody;
  const CouplingWorkspace<Real>& work;  ///< `rows` are set; `change`, and `mass` and `least_pivot`
                                        ///< of the equations, are written
  const Real* q;
  const BodyKinematics<Real>* motion;  ///< of all bodies of constrained robots, at q
};

/// @param call  a CouplingResponseCall with the number type of the width
using CouplingResponseFunction = void(const void* call);

/// @param lanes  1: doubles; otherwise packs
CouplingResponseFunction* coupling_response_function(int lanes);

/// Computes the effects of a unit force of each row.
template <class Real>
SKYBODY_INLINE void respond_to_unit_forces(const CouplingResponseCall<Real>& call) {
  coupling_response_function(kLanesOf<Real>)(&call);
}

}  // namespace skybody
