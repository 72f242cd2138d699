// Colours of textures at points of surfaces.
//
// A pixel's footprint chooses the level of the texture whose texels are as large as the pixel or
// larger; its four nearest texels are mixed in whole numbers. Angles come from a polynomial, the
// same in all instruction sets.
#pragma once

#include "render/kernels/kernel_table.h"
#include "render/kernels/lanes.h"
#include "render/kernels/surfaces.h"

namespace skybody::render::kernels::SKYBODY_KERNEL_SET {

/// A point of a texture: u to the right, v down, 0 to 1 over the picture; and the change of u and v
/// by a metre on the surface.
struct TexturePlace {
  Floats u, v, u_per_metre, v_per_metre;
};

/// Turns, from -1/2 to 1/2: the angle of (x, y) by 2 pi. Error below 1e-5.
SKYBODY_RENDER Floats turns_of(const Floats& y, const Floats& x) {
  const Floats ax = abs(x), ay = abs(y);
  const Floats small = min(ax, ay), large = max(max(ax, ay), floats(1e-30f));
  const Floats t = small / large, s = t * t;
  // C. Hastings, "Approximations for Digital Computers", 1955: arctangent by 2 pi.
  constexpr float kTerms[] = {0.05265332f, -0.11643287f, 0.19354346f, -0.33262347f, 0.99997726f};
  Floats angle = floats(-0.0117212f);
  for (const float term : kTerms) angle = angle * s + term;
  angle = angle * t * 0.15915494f;
  angle = select(greater(ay, ax), 0.25f - angle, angle);
  angle = select(greater(floats(0.0f), x), 0.5f - angle, angle);
  return select(greater(floats(0.0f), y), -angle, angle);
}

/// A face of a box shows the whole picture, upright.
SKYBODY_RENDER TexturePlace place_on_box(const TexturedShape& s, const Triple& at) {
  const Floats x = at.x * s.scale[0], y = at.y * s.scale[1], z = at.z * s.scale[2];
  const Floats ax = abs(x), ay = abs(y), az = abs(z), zero = floats(0.0f);
  const Mask is_end = at_least(az, max(ax, ay)), is_side = at_least(ax, max(ay, az));
  // Seen from outside, y is to the right on the face +x, and -x on +y.
  const Floats mirror = select(greater(zero, select(is_side, x, -y)), floats(-1.0f), floats(1.0f));
  const Floats side = select(is_side, y, x) * mirror;
  const Floats up = select(greater(zero, z), -y, y);
  TexturePlace place;
  place.u = 0.5f + 0.5f * select(is_end, x, side);
  place.v = 0.5f - 0.5f * select(is_end, up, z);
  const Floats of_x = floats(0.5f * s.scale[0]);
  place.u_per_metre = select(is_end, of_x, select(is_side, floats(0.5f * s.scale[1]), of_x));
  place.v_per_metre = select(is_end, floats(0.5f * s.scale[1]), floats(0.5f * s.scale[2]));
  return place;
}

/// The picture is wrapped once around z, its middle at +x; v by the latitude.
SKYBODY_RENDER TexturePlace place_on_sphere(const TexturedShape& s, const Triple& at) {
  const Floats aside = sqrt(at.x * at.x + at.y * at.y);
  const Floats per_metre = floats(0.15915494f * s.scale[0]);
  return {0.5f + turns_of(at.y, at.x), 0.5f - 2.0f * turns_of(at.z, aside), per_metre,
          2.0f * per_metre};
}

/// Likewise around the side of a cylinder, v along z; its caps show the middle of the picture.
SKYBODY_RENDER TexturePlace place_on_cylinder(const TexturedShape& s, const Triple& at) {
  const Floats x = at.x * s.scale[0], y = at.y * s.scale[0], z = at.z * s.scale[2];
  const Mask is_cap = greater(z * z, x * x + y * y);
  const Floats up = select(greater(floats(0.0f), z), -y, y);
  const Floats across = floats(0.5f * s.scale[0]);
  return {select(is_cap, 0.5f + 0.5f * x, 0.5f + turns_of(at.y, at.x)),
          select(is_cap, 0.5f - 0.5f * up, 0.5f - 0.5f * z),
          select(is_cap, across, floats(0.15915494f * s.scale[0])),
          select(is_cap, across, floats(0.5f * s.scale[2]))};
}

/// @param point  from the eye, camera axes [m]
SKYBODY_RENDER TexturePlace place_on(const TexturedShape& s, const Triple& point) {
  if (s.form == TextureForm::kPlane) {
    return {dot(point, s.axis[0]) * s.scale[0] + s.place[0],
            -(dot(point, s.axis[1]) * s.scale[1] + s.place[1]), floats(s.scale[0]),
            floats(s.scale[1])};
  }
  const Triple from{point.x - s.center[0], point.y - s.center[1], point.z - s.center[2]};
  const Triple at{dot(from, s.axis[0]), dot(from, s.axis[1]), dot(from, s.axis[2])};
  if (s.form == TextureForm::kBox) return place_on_box(s, at);
  if (s.form == TextureForm::kSphere) return place_on_sphere(s, at);
  return place_on_cylinder(s, at);
}

/// A whole number modulo the size of a level, or held within it.
SKYBODY_RENDER int32_t wrapped(int32_t at, int32_t size, bool repeats) {
  if (!repeats) return at < 0 ? 0 : at >= size ? size - 1 : at;
  const int32_t rest = at % size;
  return rest < 0 ? rest + size : rest;
}

/// One channel of four texels, mixed by weights of 1 / 256.
SKYBODY_RENDER float mixed(const uint32_t (&texels)[4], int byte, uint32_t x, uint32_t y) {
  const auto of = [&](int k) { return texels[k] >> (8 * byte) & 0xffu; };
  const uint32_t top = of(0) * (256u - x) + of(1) * x, bottom = of(2) * (256u - x) + of(3) * x;
  return static_cast<float>(top * (256u - y) + bottom * y) * (1.0f / (255.0f * 65536.0f));
}

/// The colour at a point of a level. @param u, v  within some thousands of pictures
SKYBODY_RENDER void look_up(const TexelLevel& level, float u, float v, bool u_repeats,
                            bool v_repeats, float (&color)[3]) {
  // In steps of 1 / 256 texel, from the centre of the first one.
  const auto steps = [](float share, int32_t size) {
    const double exact = static_cast<double>(share) * (256.0 * size) - 128.0;
    const auto whole = static_cast<int64_t>(exact);
    return static_cast<double>(whole) > exact ? whole - 1 : whole;
  };
  const int64_t x = steps(u, level.width), y = steps(v, level.height);
  const auto left = static_cast<int32_t>(x >> 8), top = static_cast<int32_t>(y >> 8);
  const int32_t columns[2] = {wrapped(left, level.width, u_repeats),
                              wrapped(left + 1, level.width, u_repeats)};
  const int32_t rows[2] = {wrapped(top, level.height, v_repeats),
                           wrapped(top + 1, level.height, v_repeats)};
  uint32_t texels[4];
  for (int k = 0; k < 4; ++k) texels[k] = level.texels[rows[k / 2] * level.width + columns[k % 2]];
  for (int c = 0; c < 3; ++c) {
    color[c] = mixed(texels, c, static_cast<uint32_t>(x & 255), static_cast<uint32_t>(y & 255));
  }
}

/// The colours at points. @param size  of the pixels' footprints on the surface [m]
/// @param wanted  bit per lane: the others are 0
SKYBODY_RENDER Triple colors_at(const TexturedShape& s, const TexturePlace& place,
                                const Floats& size, uint32_t wanted) {
  const TexelLevels& texels = *s.texels;
  const Floats wide = size * place.u_per_metre * static_cast<float>(texels.level[0].width);
  const Floats high = size * place.v_per_metre * static_cast<float>(texels.level[0].height);
  const bool repeats = s.form == TextureForm::kPlane || s.form == TextureForm::kMesh;
  const bool is_round = s.form == TextureForm::kSphere || s.form == TextureForm::kCylinder;
  float u[kLanes], v[kLanes], texels_per_pixel[kLanes], red[kLanes] = {}, green[kLanes] = {},
                                                        blue[kLanes] = {};
  const Floats least = floats(-4096.0f), most = floats(4096.0f);
  store(min(max(place.u, least), most), u);
  store(min(max(place.v, least), most), v);
  store(max(wide, high), texels_per_pixel);
  for (; wanted != 0; wanted &= wanted - 1) {
    const int i = __builtin_ctz(wanted);
    int level = 0;
    for (float rest = texels_per_pixel[i]; rest > 1.0f && level + 1 < texels.count; rest *= 0.5f) {
      ++level;
    }
    float color[3];
    look_up(texels.level[level], u[i], v[i], repeats || is_round, repeats, color);
    red[i] = color[0];
    green[i] = color[1];
    blue[i] = color[2];
  }
  return {load<Floats>(red), load<Floats>(green), load<Floats>(blue)};
}

/// The texture of a shape. Not inlined: kernels without textures stay as they are.
/// @param facing  cosine of the angle between the normal and the way to the eye
__attribute__((noinline)) inline void paint_texture(const SeenShape& s, const Triple& point,
                                                    const Floats& distance, const Floats& facing,
                                                    float pixel, uint32_t wanted, Triple& paint) {
  const Floats size = distance * pixel / max(facing, floats(1e-6f));
  paint = colors_at(*s.textured, place_on(*s.textured, point), size, wanted);
}

/// The texture of a triangle. Its edges' functions weigh the corners.
__attribute__((noinline)) inline void paint_triangle(const SeenTriangle& s,
                                                     const TexturedShape& textured, const Floats& x,
                                                     const Floats& y, const Floats& size,
                                                     uint32_t wanted, Triple& paint) {
  const auto at = [&](const Linear& f) { return (f.c + f.x * x) + f.y * y; };
  const Floats c = at(s.f[1]), a = at(s.f[2]), b = at(s.f[3]);  // of the corners opposite
  const Floats whole = max((a + b) + c, floats(1e-30f));
  const float* const point = textured.points + kTexturePoints * s.triangle;
  TexturePlace place;
  place.u = ((a * point[0] + b * point[2]) + c * point[4]) / whole;
  place.v = 1.0f - ((a * point[1] + b * point[3]) + c * point[5]) / whole;
  place.u_per_metre = place.v_per_metre = floats(point[6]);
  paint = colors_at(textured, place, size, wanted);
}

}  // namespace skybody::render::kernels::SKYBODY_KERNEL_SET
