#include "render/kernels/kernels.h"

namespace skybody::render {

const KernelTable& kernels_of(Isa isa) {
#define SKYBODY_ROW(NAME, LANES, TARGET) &kernels::NAME::kTable,
  static constexpr const KernelTable* kTables[] = {SKYBODY_ISAS(SKYBODY_ROW)};
#undef SKYBODY_ROW
  return *kTables[static_cast<int>(isa)];
}

}  // namespace skybody::render
