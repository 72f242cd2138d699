// How textures lie on shapes, as seen from an eye.
#pragma once

#include "render/kernels/kernel_table.h"
#include "render/scene.h"

namespace skybody::render {

/// The texture of a shape in camera axes. @param shape  with paint.texture
TexturedShape lay_texture(const PlacedShape& shape, const Eye& eye);

}  // namespace skybody::render
