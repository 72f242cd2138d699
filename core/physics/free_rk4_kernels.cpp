// The kernels of FreeRobotStep on packs, rk4, for each instruction set. Apart from free_kernels.cpp
// since each takes the compiler most of a minute.
#include "core/base/isa.h"
#include "core/base/kernel_target.h"
#include "core/physics/free_pack.h"

namespace skybody {
namespace {

// One function per instruction set. A macro, because the target is an attribute.
#define SKYBODY_FREE_KERNEL(NAME, TARGET, WIDTH)                            \
  SKYBODY_KERNEL(TARGET)                                                    \
  std::uint32_t advance_##NAME(const PackCall& call, std::uint32_t lanes) { \
    return advance_free<WIDTH, IntegratorChoice::kRk4>(call, lanes);        \
  }
SKYBODY_FREE_KERNEL(v2, "arch=x86-64-v2", 2)
SKYBODY_FREE_KERNEL(v3, "arch=x86-64-v3", 4)
SKYBODY_FREE_KERNEL(v4, "arch=x86-64-v4", 8)
#undef SKYBODY_FREE_KERNEL

}  // namespace

PackAdvance* choose_free_rk4_kernel() {
  switch (best_isa()) {
    case Isa::v4:
      return &advance_v4;
    case Isa::v3:
      return &advance_v3;
    case Isa::v2:
      break;
  }
  return &advance_v2;
}

}  // namespace skybody
