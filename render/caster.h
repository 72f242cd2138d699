// Shapes that cast shadows: constants of the kernels.
#pragma once

#include "render/kernels/kernel_table.h"
#include "render/scene.h"

namespace skybody::render {

/// Most casters of a shape: a capsule is a cylinder and two spheres.
inline constexpr int kMostCasters = 3;

/// Unit vectors across the way to the sun, camera axes.
void set_sides(Light& light);

/// Adds the casters of a shape, in camera axes, to light->casters and its bounds. Planes cast no
/// shadow.
/// @param shape    number of the shape
/// @param casters  memory of light->casters
void cast(const PlacedShape& placed, int shape, const Eye& eye, Light& light, Caster* casters);

}  // namespace skybody::render
