// Separate from free_euler_kernel.cpp because each takes most of a minute to compile.
#include "core/physics/step/free_kernels.h"

namespace skybody {

StepKernel* free_rk4_kernel(int lanes, Isa isa) {
  return kernel_for<AdvanceFreeRobots<IntegratorChoice::kRk4, HeldInputSet::kNothing>>(lanes, isa);
}

}  // namespace skybody
