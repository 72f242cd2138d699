// Apart from free_euler_kernel.cpp since each takes the compiler most of a minute.
#include "core/physics/step/free_kernels.h"

namespace skybody {

StepKernel* free_rk4_kernel(int lanes, Isa isa) {
  return kernel_for<AdvanceFreeRobots<IntegratorChoice::kRk4, HeldInputSet::kNothing>>(lanes, isa);
}

}  // namespace skybody
