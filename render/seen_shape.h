// Shapes as seen from an eye: constants of the kernels, and the part of the image that they can
// cover.
#pragma once

#include "render/kernels/kernel_table.h"
#include "render/scene.h"

namespace skybody::render {

/// The cover of nothing.
inline constexpr Cover kNowhere{__builtin_huge_valf(), -__builtin_huge_valf(),
                                __builtin_huge_valf(), -__builtin_huge_valf()};

/// Most SeenShapes of a shape: a capsule is a tube and two spheres.
inline constexpr int kMostParts = 3;

/// Whether the eye is inside of a shape, or on its surface.
bool contains(const PlacedShape& shape, const Vec3<double>& eye);

/// The parts of a shape that an eye outside of it may see. A mesh is one part, with its paint
/// alone.
/// @param parts   kMostParts
/// @param covers  kMostParts
/// @returns their number; 0: the shape is behind the eye
int see(const PlacedShape& shape, const Eye& eye, SeenShape* parts, Cover* covers);

}  // namespace skybody::render
