// The kernels of one instruction set; compiled once per set (CMakeLists.txt).
#include "render/kernels/shades.h"
#include "render/kernels/tiles.h"

namespace skybody::render::kernels::SKYBODY_KERNEL_SET {
namespace {

template <class Rays>
void draw_rays(const TileCall& call) {
  if (call.surface != nullptr) {
    draw_tile<Rays, true>(call);
  } else {
    draw_tile<Rays, false>(call);
  }
}

void draw(const TileCall& call) {
  if (call.is_scattered) {
    draw_rays<Scattered>(call);
  } else {
    draw_rays<Grid>(call);
  }
}

void shade(const ShadeCall& call) {
  if (call.color == nullptr) {
    shade_tile<Shades::kNormals>(call);
  } else if (!call.has_textures) {
    shade_tile<Shades::kColors>(call);
  } else {
    shade_tile<Shades::kTextures>(call);
  }
}

}  // namespace

extern const KernelTable kTable;  // also of sets that kernel_table.h does not list
const KernelTable kTable = {.see_triangles = see_triangles, .draw = draw, .shade = shade};

}  // namespace skybody::render::kernels::SKYBODY_KERNEL_SET
