// The kernels of one instruction set; compiled once per set (CMakeLists.txt).
#include "render/kernels/hits.h"
#include "render/kernels/shades.h"

namespace skybody::render::kernels::SKYBODY_KERNEL_SET {
namespace {

void draw(const TileCall& call) {
  if (call.surface != nullptr) {
    draw_tile<true>(call);
  } else {
    draw_tile<false>(call);
  }
}

void shade(const ShadeCall& call) {
  if (call.color != nullptr) {
    shade_tile<true>(call);
  } else {
    shade_tile<false>(call);
  }
}

}  // namespace

extern const KernelTable kTable;  // also of sets that kernel_table.h does not list
const KernelTable kTable = {.draw = draw, .shade = shade};

}  // namespace skybody::render::kernels::SKYBODY_KERNEL_SET
