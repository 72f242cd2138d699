// Apart from tree_kernel.cpp since each takes the compiler most of a minute.
#include "core/physics/step/advance_trees.h"

namespace skybody {

StepKernel* tree_any_kernel(int lanes, Isa isa) {
  return kernel_for<AdvanceTrees<TreeKind::kAny>>(lanes, isa);
}

}  // namespace skybody
