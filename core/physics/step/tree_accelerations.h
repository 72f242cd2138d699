// The two kinds of kernels for trees, and the algorithm of their accelerations.
#pragma once

#include "core/physics/step/step_arrays.h"

namespace skybody {

/// Accelerations by the tree's algorithms. Couplings need no extra computation here.
struct TreeAccelerations {
  template <class... Args>
  SKYBODY_INLINE void constrain(const Args&...) const {}
  template <class... Args>
  SKYBODY_INLINE void project(const Args&...) const {}

  template <class Real, class Values>
  SKYBODY_INLINE void operator()(const StepPlan& plan, const Values& derived,
                                 const StepArrays<Real>& a, const Real* q, const Real* u,
                                 Real* udot) const {
    plan.multibody.accelerations(q, u, a.motion, derived + plan.derived.bodies, a.forces,
                                 a.joint_forces, a.multibody, udot);
  }
};

/// Kinds of kernels for trees. Rare cases have their own kernel: compiled into the usual one, their
/// code costs a tenth of a step.
enum class TreeKind {
  kUsual,  ///< no held inputs, no rotor that may spin backwards, no joint stops; packs with a fast
           ///< spinning body fail
  kAny     ///< all worlds and lanes
};

}  // namespace skybody
