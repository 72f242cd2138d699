#include "core/physics/step/free_kernels.h"

namespace skybody {

StepKernel* free_euler_kernel(int lanes, Isa isa) {
  return kernel_for<
      AdvanceFreeRobots<IntegratorChoice::kSemiImplicitEuler, HeldInputSet::kNothing>>(lanes, isa);
}

}  // namespace skybody
