// Separate from tree_kernel.cpp because each takes most of a minute to compile.
#include "core/physics/step/advance_trees.h"

namespace skybody {

StepKernel* tree_any_kernel(int lanes, Isa isa) {
  return kernel_for<AdvanceTrees<TreeKind::kAny>>(lanes, isa);
}

}  // namespace skybody
