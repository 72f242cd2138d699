// Normals and colours of the pixels of a drawn tile.
#pragma once

#include "render/kernels/kernel_table.h"
#include "render/kernels/lanes.h"
#include "render/kernels/shadows.h"
#include "render/kernels/surfaces.h"
#include "render/kernels/textures.h"

namespace skybody::render::kernels::SKYBODY_KERNEL_SET {

/// Results of a kernel. Kernels without textures are as quick as if there were none.
enum class Shades { kNormals, kColors, kTextures };

SKYBODY_RENDER Floats clamp_to_one(const Floats& a) {
  return min(max(a, floats(0.0f)), floats(1.0f));
}

/// The greatest whole number up to `a`; |a| is limited to 10^6.
SKYBODY_RENDER Ints floor_of(Floats a) {
  a = min(max(a, floats(-1e6f)), floats(1e6f));
  const Ints whole = __builtin_convertvector(a, Ints);
  return select(greater(__builtin_convertvector(whole, Floats), a), whole - 1, whole);
}

/// Outward normal at a point of the shape's surface.
/// @param point  from the eye [m]
/// @param face   of the shape, in each lane
SKYBODY_RENDER Triple normal_at(const SeenShape& s, const Triple& point, const Ints& face) {
  const Triple first = triple(s.axis[0]), third = triple(s.axis[2]);
  if (s.form == Form::kPlane) return third;
  if (s.inverse_radius == 0.0f) {
    const Triple later = select(equal(face, ints(1)), triple(s.axis[1]), third);
    return select(equal(face, ints(0)), first, later);
  }
  const Triple out{point.x - s.center[0], point.y - s.center[1], point.z - s.center[2]};
  const Floats along = s.form == Form::kSphere ? floats(0.0f) : dot(out, s.axis[2]);
  const Triple round{(out.x - along * s.axis[2][0]) * s.inverse_radius,
                     (out.y - along * s.axis[2][1]) * s.inverse_radius,
                     (out.z - along * s.axis[2][2]) * s.inverse_radius};
  return select(equal(face, ints(0)), round, third);
}

/// The colour of a surface in white light. Squares smaller than a pixel fade into their mean.
/// @param facing  cosine of the angle between the normal and the way to the eye
SKYBODY_RENDER Triple paint_at(const SeenShape& s, const Triple& point, const Floats& distance,
                               const Floats& facing, float pixel) {
  const Triple own = triple(s.color);
  if (s.square == 0.0f) return own;
  const Ints sum = floor_of(dot(point, s.axis[0]) * s.square + s.place[0]) +
                   floor_of(dot(point, s.axis[1]) * s.square + s.place[1]);
  const Mask is_other = equal(sum & 1, ints(1));
  const Floats size = distance * (pixel * s.square) / max(facing, floats(1e-6f));
  const Floats sharp = clamp_to_one(1.5f - size);
  const Floats share = select(is_other, 0.5f + 0.5f * sharp, 0.5f - 0.5f * sharp);
  return {own.x + share * (s.checker[0] - s.color[0]), own.y + share * (s.checker[1] - s.color[1]),
          own.z + share * (s.checker[2] - s.color[2])};
}

/// A gradient from the horizon to the zenith.
SKYBODY_RENDER Triple sky_at(const Light& light, const Floats& height) {
  const Floats share = clamp_to_one(height);
  return {light.horizon[0] + share * (light.zenith[0] - light.horizon[0]),
          light.horizon[1] + share * (light.zenith[1] - light.horizon[1]),
          light.horizon[2] + share * (light.zenith[2] - light.horizon[2])};
}

/// Directions (x, y, 1) of a pack of a tile.
struct Directions {
  Floats x, y;

  SKYBODY_RENDER Directions(const TileCall& tile, int row, int column)
      : x(load<Floats>(tile.x + (tile.is_scattered ? row * kTileWidth + column : column))),
        y(tile.is_scattered ? load<Floats>(tile.y + row * kTileWidth + column)
                            : floats(tile.y[row])) {}
};

/// Normals and paints of the lanes that see triangles. Both sides of a triangle are seen: its
/// normal is towards the eye.
template <Shades kShades>
SKYBODY_RENDER void add_triangles(const TileCall& tile, const Ints& surface, const Floats& x,
                                  const Floats& y, float pixel, Surfaces& seen) {
  for (int k = 0; k < tile.triangle_count; ++k) {
    const Mask is_seen = equal(surface, ints(code_of_triangle(tile.triangle_list[k])));
    if (!any(is_seen)) continue;
    const SeenTriangle& s = tile.triangles[tile.triangle_list[k]];
    const Linear& f = s.f[0];
    const Floats length = sqrt(floats((f.x * f.x + f.y * f.y) + f.c * f.c));
    const Triple normal{-f.x / length, -f.y / length, -f.c / length};
    const SeenShape& part = tile.shapes[s.part];
    seen.normal = select(is_seen, normal, seen.normal);
    seen.shape = select(is_seen, ints(part.shape), seen.shape);
    if constexpr (kShades != Shades::kNormals) {
      Triple paint = triple(part.color);
      if (kShades == Shades::kTextures && part.textured != nullptr) {
        // Of a pixel at that distance, seen at that angle.
        const Floats toward = abs((normal.x * x + normal.y * y) + normal.z);
        const Floats size =
            seen.point.z * ((x * x + y * y) + 1.0f) * pixel / max(toward, floats(1e-6f));
        paint_triangle(s, *part.textured, x, y, size, lanes_of(is_seen), paint);
      }
      seen.paint = select(is_seen, paint, seen.paint);
    }
  }
}

/// Goes through the shapes of the tile, and looks at each one that some lane sees.
template <Shades kShades>
SKYBODY_RENDER Surfaces surfaces_of(const TileCall& tile, float pixel, int row, int column) {
  const int at = row * kTileWidth + column;
  const auto [x, y] = Directions(tile, row, column);
  const Floats depth = load<Floats>(tile.depth + at), length = sqrt((x * x + y * y) + 1.0f);
  const Ints surface = load<Ints>(tile.surface + at), index = surface >> 2, face = surface & 3;
  Surfaces seen{{depth * x, depth * y, depth}, {}, {}, ints(-1)};
  for (int k = 0; k < tile.count; ++k) {
    const Mask is_seen = equal(index, ints(tile.list[k]));
    if (!any(is_seen)) continue;
    const SeenShape& s = tile.shapes[tile.list[k]];
    const Triple out = normal_at(s, seen.point, face);
    seen.normal = select(is_seen, out, seen.normal);
    seen.shape = select(is_seen, ints(s.shape), seen.shape);
    if constexpr (kShades != Shades::kNormals) {
      const Floats toward = (out.x * x + out.y * y) + out.z;
      const Floats facing = max(-toward, floats(0.0f)) / length;
      Triple paint = paint_at(s, seen.point, depth * length, facing, pixel);
      if (kShades == Shades::kTextures && s.textured != nullptr) {
        paint_texture(s, seen.point, depth * length, facing, pixel, lanes_of(is_seen), paint);
      }
      seen.paint = select(is_seen, paint, seen.paint);
    }
  }
  add_triangles<kShades>(tile, surface, x, y, pixel, seen);
  return seen;
}

/// A share in [0, 1] as a whole number up to 255.
SKYBODY_RENDER Ints byte_of(const Floats& share) {
  return __builtin_convertvector(clamp_to_one(share) * 255.0f + 0.5f, Ints);
}

/// A colour at a depth.
SKYBODY_RENDER Triple hazy(const Triple& color, const Light& light, const Floats& depth) {
  const Floats square = depth * depth, share = square / (square + light.haze);
  return {color.x + share * (light.horizon[0] - color.x),
          color.y + share * (light.horizon[1] - color.y),
          color.z + share * (light.horizon[2] - color.z)};
}

SKYBODY_RENDER Ints color_of(const Surfaces& seen, const Light& light, const Floats& lit,
                             const Floats& x, const Floats& y) {
  const Floats slope = max(dot(seen.normal, light.sun), floats(0.0f));
  const Floats brightness = slope * (light.direct * lit) + light.ambient;
  Triple shaded{seen.paint.x * brightness, seen.paint.y * brightness, seen.paint.z * brightness};
  if (light.haze > 0.0f) shaded = hazy(shaded, light, seen.point.z);
  const Floats length = sqrt((x * x + y * y) + 1.0f);
  const Floats rise = ((x * light.up[0] + y * light.up[1]) + light.up[2]) / length;
  const Triple color = select(equal(seen.shape, ints(-1)), sky_at(light, rise), shaded);
  return byte_of(color.x) | byte_of(color.y) << 8 | byte_of(color.z) << 16;
}

SKYBODY_RENDER void store_normal(const Triple& normal, float* out) {
  store(normal.x, out);
  store(normal.y, out + kTilePixels);
  store(normal.z, out + 2 * kTilePixels);
}

template <Shades kShades>
SKYBODY_RENDER void shade_tile(const ShadeCall& call) {
  constexpr int kPacks = kTilePixels / kLanes, kAcross = kTileWidth / kLanes;
  const TileCall& tile = *call.tile;
  const Light& light = *call.light;
  Surfaces seen[kPacks];
  for (int p = 0; p < kPacks; ++p) {
    const int row = p / kAcross, column = p % kAcross * kLanes;
    seen[p] = surfaces_of<kShades>(tile, light.pixel, row, column);
    if (call.normal != nullptr) store_normal(seen[p].normal, call.normal + p * kLanes);
  }
  if constexpr (kShades != Shades::kNormals) {
    const int casters = list_casters(light, seen, kPacks, call.list);
    for (int p = 0; p < kPacks; ++p) {
      const auto [x, y] = Directions(tile, p / kAcross, p % kAcross * kLanes);
      const Floats lit = light_at(light, seen[p], call.list, casters);
      store(color_of(seen[p], light, lit, x, y), call.color + p * kLanes);
    }
  }
}

}  // namespace skybody::render::kernels::SKYBODY_KERNEL_SET
