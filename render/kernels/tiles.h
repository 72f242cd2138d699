// Depth, id and surface of the pixels of a tile.
#pragma once

#include "render/kernels/hits.h"
#include "render/kernels/triangles.h"

namespace skybody::render::kernels::SKYBODY_KERNEL_SET {

/// w at the farthest depth of an image, or at the farthest range of scattered rays.
SKYBODY_RENDER Floats least_w(const Grid&, int, float farthest) { return floats(1.0f / farthest); }
SKYBODY_RENDER Floats least_w(const Scattered& rays, int r, float farthest) {
  const Floats &x = rays.x(r), &y = rays.y(r);
  return sqrt((x * x + y * y) + 1.0f) / farthest;
}

/// Depth, id and surface of every pixel of a tile.
template <class Rays, bool kSurfaces>
SKYBODY_RENDER void draw_tile(const TileCall& call) {
  for (int column = 0; column < kTileWidth; column += kLanes) {
    const Rays rays(call, column);
    Nearest<kSurfaces> nearest;
    for (int r = 0; r < kTileHeight; ++r) {
      nearest.w[r] = least_w(rays, r, call.farthest);
      nearest.id[r] = ints(0);
      nearest.surface[r] = ints(-1);
    }
    for (int k = 0; k < call.count; ++k) {
      const int32_t index = call.list[k];
      meet(call.shapes[index], 4 * index, rays, nearest);
    }
    for (int k = 0; k < call.triangle_count; ++k) {
      const int32_t index = call.triangle_list[k];
      meet_triangle(call.triangles[index], code_of_triangle(index), rays, nearest);
    }
    for (int r = 0; r < kTileHeight; ++r) {
      const int at = r * kTileWidth + column;
      const Mask is_empty = equal(nearest.id[r], ints(0));
      store(select(is_empty, floats(call.farthest), 1.0f / nearest.w[r]), call.depth + at);
      store(nearest.id[r], call.id + at);
      if constexpr (kSurfaces) store(nearest.surface[r], call.surface + at);
    }
  }
}

}  // namespace skybody::render::kernels::SKYBODY_KERNEL_SET
