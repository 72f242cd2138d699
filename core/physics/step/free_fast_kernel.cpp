// Kernels of free robots that spin fast, whatever effects hold of them.
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
    default:  // rk4 takes them as all others
      return nullptr;
  }
}

}  // namespace skybody
