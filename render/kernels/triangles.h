// Triangles of a mesh as seen from an eye, and where rays enter them.
//
// With a, b, c the corners from the eye, a ray along d passes through the triangle if d . (a x b),
// d . (b x c) and d . (c x a) all have the sign of a . (b x c); then
//   w = 1 / t = (d . n) / (a . n),   n = (b - a) x (c - a)
// All are linear in d. a x b is computed as (a + b) x (b - a) / 2, without cancellation for corners
// close to each other, as Embree does. The edge that two triangles share has the same function but
// for its sign, bit by bit: no ray passes through the edge between them.
#pragma once

#include "render/kernels/hits.h"
#include "render/kernels/surfaces.h"

namespace skybody::render::kernels::SKYBODY_KERNEL_SET {

SKYBODY_RENDER Triple cross(const Triple& a, const Triple& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
SKYBODY_RENDER Triple plus(const Triple& a, const Triple& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
SKYBODY_RENDER Triple minus(const Triple& a, const Triple& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
SKYBODY_RENDER Triple times(const Triple& a, const Floats& s) {
  return {a.x * s, a.y * s, a.z * s};
}
/// Camera axes from the mesh's.
SKYBODY_RENDER Triple turned(const float (&axes)[3][3], const Triple& v) {
  return {dot(v, axes[0]), dot(v, axes[1]), dot(v, axes[2])};
}

/// Bounds of the pictures of corners in front of the eye.
struct Bounds {
  Floats left = floats(3e38f), right = floats(-3e38f), top = floats(3e38f), bottom = floats(-3e38f);

  SKYBODY_RENDER void add(const Triple& corner) {
    const Floats w = 1.0f / corner.z, x = corner.x * w, y = corner.y * w;
    left = min(left, x);
    right = max(right, x);
    top = min(top, y);
    bottom = max(bottom, y);
  }
};

/// Whether an axis of a grid has a pixel centre between two bounds; a little more is taken.
SKYBODY_RENDER Mask has_pixel(const Floats& low, const Floats& high, const GridAxis& axis) {
  const Floats first = (low - axis.first) * axis.inverse_step - 1e-2f;
  const Floats last = (high - axis.first) * axis.inverse_step + 1e-2f;
  const Floats least = floats(-1.0f), most = floats(axis.count);
  const Floats from = min(max(first, least), most), to = max(min(last, most), least);
  // Truncation rounds down, because both are made positive.
  const Ints before = __builtin_convertvector(from + 2.0f, Ints);
  const Ints at = __builtin_convertvector(to + 2.0f, Ints);
  return greater(__builtin_convertvector(at - before, Floats), floats(0.5f));
}

/// The constants of a block of triangles.
struct Block {
  Triple f[4];  ///< w, edges
  Bounds bounds;
  uint32_t seen;     ///< bit per lane: it may be seen
  uint32_t crosses;  ///< bit per lane: it reaches behind the eye
};

SKYBODY_RENDER Block block_of(const MeshCall& call, int first) {
  const auto corner = [&](int k) {
    const auto from_eye = [&](int axis) {
      const Floats coordinate = load<Floats>(call.coordinates[3 * k + axis] + first);
      return (coordinate - call.eye[axis]) - call.eye_rest[axis];
    };
    return Triple{from_eye(0), from_eye(1), from_eye(2)};
  };
  const Triple a = corner(0), b = corner(1), c = corner(2);
  const Triple n = cross(minus(b, a), minus(c, a));
  const Floats height = (n.x * a.x + n.y * a.y) + n.z * a.z;
  const Floats sign = select(greater(floats(0.0f), height), floats(-1.0f), floats(1.0f));
  Block block;
  block.f[0] = turned(call.axes, times(n, 1.0f / height));
  const auto edge = [&](const Triple& from, const Triple& to) {
    return turned(call.axes, times(cross(plus(from, to), minus(to, from)), sign));
  };
  block.f[1] = edge(a, b);
  block.f[2] = edge(b, c);
  block.f[3] = edge(c, a);
  const Triple corners[3] = {turned(call.axes, a), turned(call.axes, b), turned(call.axes, c)};
  Floats nearest = corners[0].z, farthest = corners[0].z;
  for (const Triple& at : corners) {
    nearest = min(nearest, at.z);
    farthest = max(farthest, at.z);
    block.bounds.add(at);
  }
  const uint32_t is_ahead = lanes_of(greater(nearest, floats(1e-6f)));
  const uint32_t is_seen =
      lanes_of(greater(farthest, floats(0.0f)) & greater(abs(height), floats(0.0f)));
  uint32_t has_pixels = ~0u;
  if (call.has_grid) {
    has_pixels = lanes_of(has_pixel(block.bounds.left, block.bounds.right, call.columns) &
                          has_pixel(block.bounds.top, block.bounds.bottom, call.rows));
  }
  block.crosses = is_seen & ~is_ahead;
  block.seen = is_seen & (~is_ahead | has_pixels);
  return block;
}

SKYBODY_RENDER void store_triple(const Triple& v, float (*out)[kLanes]) {
  store(v.x, out[0]);
  store(v.y, out[1]);
  store(v.z, out[2]);
}

/// A little less, above the rounding of directions.
SKYBODY_RENDER float below(float v) { return v - 1e-5f * (1.0f + (v < 0.0f ? -v : v)); }

/// Writes the triangles that may be seen. @returns their number
inline int see_triangles(const MeshCall& call) {
  int count = 0;
  for (int first = 0; first < call.count; first += kLanes) {
    const Block block = block_of(call, first);
    const int rest = call.count - first;
    uint32_t lanes = block.seen & (rest < kLanes ? (1u << rest) - 1u : ~0u);
    if (lanes == 0) continue;
    float values[16][kLanes];
    for (int k = 0; k < 4; ++k) store_triple(block.f[k], values + 3 * k);
    store(block.bounds.left, values[12]);
    store(block.bounds.right, values[13]);
    store(block.bounds.top, values[14]);
    store(block.bounds.bottom, values[15]);
    for (; lanes != 0; lanes &= lanes - 1) {
      const int i = __builtin_ctz(lanes);
      SeenTriangle& seen = call.seen[count++];
      for (int k = 0; k < 4; ++k) {
        seen.f[k] = {values[3 * k + 2][i], values[3 * k][i], values[3 * k + 1][i]};
      }
      if ((block.crosses >> i & 1u) != 0) {
        seen.cover = {-3e38f, 3e38f, -3e38f, 3e38f};
      } else {
        seen.cover = {below(values[12][i]), -below(-values[13][i]), below(values[14][i]),
                      -below(-values[15][i])};
      }
      seen.id = call.id;
      seen.part = call.part;
      seen.triangle = first + i;
    }
  }
  return count;
}

/// @param code  of the surface
template <class Rays, bool kSurfaces>
SKYBODY_RENDER void meet_triangle(const SeenTriangle& s, int32_t code, const Rays& rays,
                                  Nearest<kSurfaces>& nearest) {
  const Along<Rays> middle(s.f[0], rays), e0(s.f[1], rays), e1(s.f[2], rays), e2(s.f[3], rays);
#pragma GCC unroll 4
  for (int r = 0; r < kTileHeight; ++r) {
    const Floats w = middle.at(r);
    const Floats inside = min(min(e0.at(r), e1.at(r)), e2.at(r));
    const Mask hit = at_least(inside, floats(0.0f)) & greater(w, nearest.w[r]);
    nearest.put(r, hit, w, s.id);
    nearest.put_surface(r, hit, ints(code));
  }
}

}  // namespace skybody::render::kernels::SKYBODY_KERNEL_SET
