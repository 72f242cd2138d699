// The kernel of HeldInputSet::kAir.
#include "core/physics/step/free_kernels.h"

namespace skybody {

StepKernel* free_air_kernel(int lanes, Isa isa) {
  return kernel_for<AdvanceFreeRobots<IntegratorChoice::kMidpoint, HeldInputSet::kAir>>(lanes, isa);
}

}  // namespace skybody
