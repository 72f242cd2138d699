#include "render/textured_shape.h"

#include <algorithm>

#include "core/base/math/math.h"
#include "render/mesh.h"
#include "render/texture.h"

namespace skybody::render {
namespace {

void copy(const Vec3<double>& v, float (&out)[3]) {
  out[0] = static_cast<float>(v.x);
  out[1] = static_cast<float>(v.y);
  out[2] = static_cast<float>(v.z);
}

float inverse(double size) { return static_cast<float>(1.0 / std::max(size, 1e-9)); }

/// The share of `value` by `size` beyond a whole number, in [0, 1).
double share_of(double value, double size) {
  const double count = value / size;
  return count - floor(count);
}

/// Of a plane: copies of the picture side by side, the first one with its lower left corner at the
/// origin of the plane's frame.
void lay_on_plane(const PlacedShape& shape, const Vec3<double>& eye, TexturedShape& textured) {
  const double width = std::max(static_cast<double>(shape.paint.texture_width), 1e-6);
  const Texture& texture = *shape.paint.texture;
  const double height = width * texture.height() / texture.width();
  textured.form = TextureForm::kPlane;
  textured.scale[0] = inverse(width);
  textured.scale[1] = inverse(height);
  // From the eye: far from the origin the rest of a division is exact enough in double alone.
  textured.place[0] = static_cast<float>(share_of(eye.x, width));
  textured.place[1] = static_cast<float>(share_of(eye.y, height));
}

TextureForm form_of(Solid solid) {
  switch (solid) {
    case Solid::kBox:
      return TextureForm::kBox;
    case Solid::kSphere:
      return TextureForm::kSphere;
    default:
      return TextureForm::kCylinder;
  }
}

}  // namespace

TexturedShape lay_texture(const PlacedShape& shape, const Eye& eye) {
  TexturedShape textured{};
  textured.texels = &shape.paint.texture->levels();
  const Vec3<double> center = transpose_times(eye.axes, shape.position - eye.position);
  copy(center, textured.center);
  for (int i = 0; i < 3; ++i) {
    copy(transpose_times(eye.axes, shape.axes.column(i)), textured.axis[i]);
  }
  if (shape.solid == Solid::kPlane) {
    lay_on_plane(shape, transpose_times(shape.axes, eye.position - shape.position), textured);
  } else if (shape.solid == Solid::kMesh) {
    textured.form = TextureForm::kMesh;
    textured.points = shape.mesh->texture();
  } else {
    const Vec3<double>& half = shape.half;
    const double length = shape.solid == Solid::kCapsule ? half.z + half.x : half.z;
    textured.form = form_of(shape.solid);
    const bool is_box = shape.solid == Solid::kBox;
    textured.scale[0] = inverse(half.x);
    textured.scale[1] = inverse(is_box ? half.y : half.x);
    textured.scale[2] = inverse(shape.solid == Solid::kSphere ? half.x : length);
  }
  return textured;
}

}  // namespace skybody::render
