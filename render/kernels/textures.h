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

/// The greatest whole number up to `a`, |a| < 2^31.
SKYBODY_RENDER Floats whole_below(const Floats& a) {
  const Floats whole = __builtin_convertvector(__builtin_convertvector(a, Ints), Floats);
  return select(greater(whole, a), whole - 1.0f, whole);
}

/// A share of the picture, in [0, 1]: of copies side by side, or held.
SKYBODY_RENDER Floats share_of(const Floats& a, bool repeats) {
  if (!repeats) return min(max(a, floats(0.0f)), floats(1.0f));
  const Floats near = min(max(a, floats(-4096.0f)), floats(4096.0f));
  return near - whole_below(near);
}

/// Two texels of an axis around a point, and the weight of the second in 1 / 256.
struct Pair {
  int32_t first, second;
  uint32_t weight;

  /// @param share  of the level's size, in [0, 1]
  SKYBODY_RENDER Pair(float share, int32_t size, bool repeats) {
    // In steps of 1 / 256 texel, from the centre of the first one.
    const int32_t steps = static_cast<int32_t>(share * static_cast<float>(256 * size)) - 128;
    first = steps >> 8;
    second = first + 1;
    weight = static_cast<uint32_t>(steps & 255);
    if (first < 0) first = repeats ? size - 1 : 0;
    if (second >= size) second = repeats ? 0 : size - 1;
  }
};

/// Bytes 0 and 2 of two texels, mixed. @param weight  of the second, in 1 / 256
SKYBODY_RENDER uint32_t mixed(uint32_t a, uint32_t b, uint32_t weight) {
  return ((a & 0xff00ffu) * (256u - weight) + (b & 0xff00ffu) * weight) >> 8 & 0xff00ffu;
}

/// The colour at a point of a level.
SKYBODY_RENDER uint32_t texel_at(const TexelLevel& level, const Pair& x, const Pair& y) {
  const uint32_t* const top = level.texels + y.first * level.width;
  const uint32_t* const bottom = level.texels + y.second * level.width;
  const auto of = [&](int shift) {
    const uint32_t above = mixed(top[x.first] >> shift, top[x.second] >> shift, x.weight);
    const uint32_t below = mixed(bottom[x.first] >> shift, bottom[x.second] >> shift, x.weight);
    return mixed(above, below, y.weight);
  };
  return of(0) | of(8) << 8;  // red and blue, green
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
  float u[kLanes], v[kLanes];
  store(share_of(place.u, repeats || is_round), u);
  store(share_of(place.v, repeats), v);
  // The exponent of a float, rounded up.
  const Ints bits = reinterpret_cast<Ints>(max(max(wide, high), floats(1.0f)));
  int32_t levels[kLanes];
  store(((bits + 0x7fffff) >> 23) - 127, levels);
  uint32_t colors[kLanes] = {};
  for (; wanted != 0; wanted &= wanted - 1) {
    const int i = __builtin_ctz(wanted);
    const TexelLevel& level = texels.level[levels[i] < texels.count ? levels[i] : texels.count - 1];
    colors[i] = texel_at(level, Pair(u[i], level.width, repeats || is_round),
                         Pair(v[i], level.height, repeats));
  }
  const Ints color = load<Ints>(colors);
  const auto channel = [&color](int shift) {
    return __builtin_convertvector(color >> shift & 255, Floats) * (1.0f / 255.0f);
  };
  return {channel(0), channel(8), channel(16)};
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
