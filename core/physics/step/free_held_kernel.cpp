// Kernels of free robots that effects hold something of.
#include "core/physics/step/free_kernels.h"

namespace skybody {

StepKernel* free_held_kernel(IntegratorChoice integrator, int lanes, Isa isa) {
  return integrator == IntegratorChoice::kRk4
             ? kernel_for<AdvanceFreeRobots<IntegratorChoice::kRk4, true>>(lanes, isa)
             : kernel_for<AdvanceFreeRobots<IntegratorChoice::kSemiImplicitEuler, true>>(lanes,
                                                                                         isa);
}

}  // namespace skybody
