#include "core/physics/step/free_kernels.h"

namespace skybody {

StepKernel* free_midpoint_kernel(int lanes, Isa isa) {
  return kernel_for<AdvanceFreeRobots<IntegratorChoice::kMidpoint, HeldInputSet::kNothing>>(lanes,
                                                                                            isa);
}

}  // namespace skybody
