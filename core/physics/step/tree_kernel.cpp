#include "core/physics/step/advance_trees.h"

namespace skybody {

StepKernel* tree_kernel(int lanes, Isa isa) {
  return kernel_for<AdvanceTrees<TreeKind::kUsual>>(lanes, isa);
}

}  // namespace skybody
