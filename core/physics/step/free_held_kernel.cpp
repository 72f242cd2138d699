// Kernels of free robots with held inputs.
#include "core/physics/step/free_kernels.h"

namespace skybody {

StepKernel* free_held_kernel(IntegratorChoice integrator, int lanes, Isa isa) {
  switch (integrator) {
    case IntegratorChoice::kRk4:
      return kernel_for<AdvanceFreeRobots<IntegratorChoice::kRk4, HeldInputSet::kAnything>>(lanes,
                                                                                            isa);
    case IntegratorChoice::kMidpoint:
      return kernel_for<AdvanceFreeRobots<IntegratorChoice::kMidpoint, HeldInputSet::kAnything>>(
          lanes, isa);
    default:  // semi-implicit Euler: other integrators have no kernels
      return kernel_for<
          AdvanceFreeRobots<IntegratorChoice::kSemiImplicitEuler, HeldInputSet::kAnything>>(lanes,
                                                                                            isa);
  }
}

}  // namespace skybody
