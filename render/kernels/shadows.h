// Shadows: rays from the points of a tile towards the sun. The ones that can pass between are
// listed first, by their bounds.
#pragma once

#include "render/kernels/kernel_table.h"
#include "render/kernels/surfaces.h"

namespace skybody::render::kernels::SKYBODY_KERNEL_SET {

/// Least distance of a shadow's body, relative to the depth of the surface: the rounding of points.
inline constexpr float kLeastGap = 1e-4f;

/// The least and the greatest of some values.
struct Range {
  Floats low = floats(3e38f), high = floats(-3e38f);

  SKYBODY_RENDER void add(Mask is_one, const Floats& value) {
    low = select(is_one, min(value, low), low);
    high = select(is_one, max(value, high), high);
  }
  SKYBODY_RENDER float least() const {
    float lanes[kLanes];
    store(low, lanes);
    float least = lanes[0];
    for (int i = 1; i < kLanes; ++i) least = lanes[i] < least ? lanes[i] : least;
    return least;
  }
  SKYBODY_RENDER float greatest() const {
    float lanes[kLanes];
    store(high, lanes);
    float greatest = lanes[0];
    for (int i = 1; i < kLanes; ++i) greatest = lanes[i] > greatest ? lanes[i] : greatest;
    return greatest;
  }
};

/// Casters whose shadows can reach a point of the tile. @returns their number
SKYBODY_RENDER int list_casters(const Light& light, const Surfaces* seen, int packs,
                                uint16_t* list) {
  if (light.caster_count == 0) return 0;
  Range across, aside, along;
  for (int p = 0; p < packs; ++p) {
    const Mask is_lit = greater(dot(seen[p].normal, light.sun), floats(0.0f));
    across.add(is_lit, dot(seen[p].point, light.side[0]));
    aside.add(is_lit, dot(seen[p].point, light.side[1]));
    along.add(is_lit, dot(seen[p].point, light.sun));
  }
  const CasterBounds& b = light.bounds;
  const float left = across.least(), right = across.greatest(), bottom = aside.least(),
              top = aside.greatest(), foot = along.least();
  int count = 0;
  for (int i = 0; i < light.caster_count; i += kLanes) {
    const auto bound = [i](const float* values) { return load<Floats>(values + i); };
    const Mask meets =
        at_least(floats(right), bound(b.low[0])) & at_least(bound(b.high[0]), floats(left)) &
        at_least(floats(top), bound(b.low[1])) & at_least(bound(b.high[1]), floats(bottom)) &
        at_least(bound(b.top), floats(foot));
    const int rest = light.caster_count - i;
    uint32_t lanes = lanes_of(meets) & (rest < kLanes ? (1u << rest) - 1u : ~0u);
    for (; lanes != 0; lanes &= lanes - 1) {
      list[count++] = static_cast<uint16_t>(i + __builtin_ctz(lanes));
    }
  }
  return count;
}

SKYBODY_RENDER Floats value_at(const float (&n)[4], const Triple& p) {
  return ((p.x * n[0] + p.y * n[1]) + p.z * n[2]) + n[3];
}

/// Where the way to the sun passes through a caster.
SKYBODY_RENDER Mask passes(const Caster& c, const float (&sun)[3], const Triple& p,
                           const Floats& least) {
  const Floats x = value_at(c.n[0], p), y = value_at(c.n[1], p), z = value_at(c.n[2], p);
  if (c.form == CasterForm::kSphere) {
    const Floats along = dot(Triple{x, y, z}, sun);
    const Floats aside = ((x * x + y * y) + z * z) - along * along;
    return at_least(floats(c.e[0]), aside) & greater(-along, least);
  }
  Floats entry, exit;
  if (c.form == CasterForm::kBox) {
    entry = max(max(-x - c.e[0], -y - c.e[1]), -z - c.e[2]);
    exit = min(min(c.e[0] - x, c.e[1] - y), c.e[2] - z);
  } else {
    const Floats cross = x * c.e[1] - y * c.e[0], middle = -(x * c.e[0] + y * c.e[1]) * c.e[3];
    const Floats root = sqrt(c.e[2] * c.e[4] - cross * cross) * c.e[3];  // NaN: never a hit
    entry = max(-z - c.e[5], middle - root);
    exit = min(c.e[5] - z, middle + root);
  }
  return at_least(exit, entry) & greater(exit, least);
}

/// 1 for points in the sun, else 0.
SKYBODY_RENDER Floats light_at(const Light& light, const Surfaces& seen, const uint16_t* list,
                               int count) {
  Floats lit = floats(1.0f);
  const Floats least = seen.point.z * kLeastGap;
  for (int k = 0; k < count; ++k) {
    const Caster& caster = light.casters[list[k]];
    const Floats shaded = select(passes(caster, light.sun, seen.point, least), floats(0.0f), lit);
    lit = select(equal(seen.shape, ints(caster.shape)), lit, shaded);
  }
  return lit;
}

}  // namespace skybody::render::kernels::SKYBODY_KERNEL_SET
