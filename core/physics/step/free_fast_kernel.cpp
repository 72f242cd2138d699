// Kernels of free robots that spin fast, with any held inputs.
#include "core/physics/step/free_kernels.h"

namespace skybody {

StepKernel* free_fast_kernel(IntegratorChoice integrator, int lanes, Isa isa) {
  switch (integrator) {
    case IntegratorChoice::kMidpoint:
      return kernel_for<
          AdvanceFreeRobots<IntegratorChoice::kMidpoint, HeldInputSet::kAnything, SpinKind::kAny>>(
          lanes, isa);
    case IntegratorChoice::kSemiImplicitEuler:
      return kernel_for<AdvanceFreeRobots<IntegratorChoice::kSemiImplicitEuler,
                                          HeldInputSet::kAnything, SpinKind::kAny>>(lanes, isa);
    default:  // rk4 handles them in its usual kernel
      return nullptr;
  }
}

}  // namespace skybody
