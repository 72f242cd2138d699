// Work arrays of joint reactions, in a thread's scratch memory.
#pragma once

#include "core/physics/bodies/joint_reactions.h"
#include "core/physics/step/step_arrays.h"

namespace skybody {

/// Per body; behind the arrays of a step.
template <class Real>
struct ReactionArrays {
  StepArrays<Real> step;
  BodyAccelerationOf<Real>* accelerations;
  SpatialForce<Real>*no_contact, *reactions;

  SKYBODY_INLINE ReactionArrays(const StepPlan& plan, std::byte* memory) : step(plan, memory) {
    lay_out(plan, memory);
  }
  static std::size_t bytes(const StepPlan& plan) {
    return ReactionArrays(plan, nullptr).lay_out(plan, nullptr);
  }

 private:
  /// @returns the number of bytes used
  SKYBODY_INLINE std::size_t lay_out(const StepPlan& plan, std::byte* memory) {
    const std::size_t bodies = plan.world.bodies.size();
    StepArena arena{memory, StepArrays<Real>::bytes(plan)};
    arena.take(accelerations, bodies);
    arena.take(no_contact, bodies);
    arena.take(reactions, bodies);
    return arena.used;
  }
};

}  // namespace skybody
