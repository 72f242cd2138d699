// The adjoint of a physics step: from the derivatives of a sum by a step's results to those by
// where it began and by what was held. Contact, which corrects a step afterwards, is no part of it.
#pragma once

#include <cstdint>

#include "core/physics/step/step_plan.h"

namespace skybody {

/// For the lanes in `lanes`.
/// @param call      the step; the group's blocks that change, or that effects and controllers give,
///                  lie in one run of rows from `q` on. None is written
/// @param adjoints  of the run's rows, after the step; overwritten by those before it
using AdjointKernel = void(const StepCall& call, std::uint32_t lanes, double* adjoints);

/// Whether the world is one free robot with level rotors and nothing else that moves it, stepped by
/// the midpoint rule.
bool has_free_adjoint(const StepPlan& plan);
/// Of such worlds.
AdjointKernel* free_adjoint_kernel(Isa isa);

}  // namespace skybody
