// Physics of a lane group on dual numbers: forward-mode derivatives of any world through the
// engine's own equations of motion. Blocks of the group have two rows per value (lane_values.h).
// Parameters and values derived from them have one row: they are constants.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/physics/step/step_plan.h"

namespace skybody {

/// Computes the lanes in `lanes`; lanes whose step fails keep values and tangents.
using DualKernel = void(const StepCall& call, std::uint32_t lanes);

/// Computes bodies from q and u.
DualKernel* dual_motion_kernel(Isa isa);
/// One physics step by a fixed rule, without contact.
DualKernel* dual_step_kernel(Isa isa);

/// Scratch memory that each of these kernels needs.
std::size_t dual_scratch_bytes(const StepPlan& plan);

}  // namespace skybody
