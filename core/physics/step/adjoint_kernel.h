// The adjoint of a physics step: converts the gradient of a scalar with respect to a step's results
// into its gradient with respect to the initial state and the held inputs. Contact, which corrects
// a step afterwards, is not included.
#pragma once

#include <cstdint>

#include "core/physics/step/step_plan.h"

namespace skybody {

/// Computes the lanes in `lanes`.
/// @param call      the step. All of the group's blocks that change, or that effects and
///                  controllers set, must lie in one run of rows from `q` on. No block is written
/// @param adjoints  of the run's rows: in: after the step; out: before the step
using AdjointKernel = void(const StepCall& call, std::uint32_t lanes, double* adjoints);

/// Whether the world is one free robot with level rotors and no other moving force, stepped by the
/// midpoint rule.
bool has_free_adjoint(const StepPlan& plan);
/// The kernel for such worlds.
AdjointKernel* free_adjoint_kernel(Isa isa);

}  // namespace skybody
