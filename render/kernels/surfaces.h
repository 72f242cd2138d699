// Points and normals of the surfaces that pixels see.
#pragma once

#include "render/kernels/lanes.h"

namespace skybody::render::kernels::SKYBODY_KERNEL_SET {

struct Triple {
  Floats x, y, z;
};
SKYBODY_RENDER Triple triple(const float (&v)[3]) {
  return {floats(v[0]), floats(v[1]), floats(v[2])};
}
SKYBODY_RENDER Floats dot(const Triple& a, const float (&b)[3]) {
  return (a.x * b[0] + a.y * b[1]) + a.z * b[2];
}
SKYBODY_RENDER Triple select(Mask m, const Triple& a, const Triple& b) {
  return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}
/// The surfaces that the lanes of a pack see.
struct Surfaces {
  Triple point;   ///< from the eye [m]
  Triple normal;  ///< 0: nothing
  Triple paint;
  Ints shape;  ///< SeenShape::shape; -1: nothing
};

}  // namespace skybody::render::kernels::SKYBODY_KERNEL_SET
