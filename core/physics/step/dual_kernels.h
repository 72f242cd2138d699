// Physics of a lane group on dual numbers: forward mode through the engine's own equations of
// motion, whatever the world is. Blocks of the group have two rows for each value (lane_values.h),
// parameters and what derives from them one: they are constants.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/physics/step/step_plan.h"

namespace skybody {

/// For the lanes in `lanes`; lanes whose step does not come through keep values and tangents.
using DualKernel = void(const StepCall& call, std::uint32_t lanes);

/// Bodies from q and u.
DualKernel* dual_motion_kernel(Isa isa);
/// One physics step by a fixed rule, without contact.
DualKernel* dual_step_kernel(Isa isa);

/// Scratch memory that either takes.
std::size_t dual_scratch_bytes(const StepPlan& plan);

}  // namespace skybody
