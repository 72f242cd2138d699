#include "render/caster.h"

#include <algorithm>
#include <cmath>

#include "core/base/math/math.h"
#include "render/mesh.h"

namespace skybody::render {
namespace {

/// Least component of the way to the sun along an axis: avoids divisions by 0.
constexpr double kLeast = 1e-6;

Vec3<double> vec3_of(const float (&v)[3]) { return {v[0], v[1], v[2]}; }

void copy(const Vec3<double>& v, float (&out)[3]) {
  out[0] = static_cast<float>(v.x);
  out[1] = static_cast<float>(v.y);
  out[2] = static_cast<float>(v.z);
}

/// Away from 0.
double apart(double v) { return std::abs(v) > kLeast ? v : v < 0.0 ? -kLeast : kLeast; }

/// A shape's frame in camera axes, with the sun.
struct Lit {
  Vec3<double> center;   ///< from the eye
  Vec3<double> axis[3];  ///< of its frame
  double sun[3];         ///< in its frame

  Lit(const PlacedShape& shape, const Eye& eye, const Light& light)
      : center(transpose_times(eye.axes, shape.position - eye.position)) {
    for (int i = 0; i < 3; ++i) {
      axis[i] = transpose_times(eye.axes, shape.axes.column(i));
      sun[i] = dot(axis[i], vec3_of(light.sun));
    }
  }
  /// scale * (p - center) along an axis, as a function of p.
  void set_function(int i, double scale, float (&n)[4]) const {
    const Vec3<double> along = axis[i] * scale;
    n[0] = static_cast<float>(along.x);
    n[1] = static_cast<float>(along.y);
    n[2] = static_cast<float>(along.z);
    n[3] = static_cast<float>(-dot(along, center));
  }
};

/// Adds a caster with the bounds of a box with half edges `half` about `center`.
void add(const Caster& caster, const Lit& lit, const Vec3<double>& center, const double (&half)[3],
         Light& light, Caster* casters) {
  const int at = light.caster_count++;
  casters[at] = caster;
  const auto reach = [&](const Vec3<double>& along) {
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) sum += std::abs(dot(lit.axis[i], along)) * half[i];
    return sum * (1.0 + 1e-6);
  };
  for (int k = 0; k < 2; ++k) {
    const Vec3<double> side = vec3_of(light.side[k]);
    light.bounds.low[k][at] = static_cast<float>(dot(center, side) - reach(side));
    light.bounds.high[k][at] = static_cast<float>(dot(center, side) + reach(side));
  }
  const Vec3<double> sun = vec3_of(light.sun);
  light.bounds.top[at] = static_cast<float>(dot(center, sun) + reach(sun));
}

void cast_box(const PlacedShape& placed, int shape, const Lit& lit, Light& light, Caster* casters) {
  const double half[3] = {placed.half.x, placed.half.y, placed.half.z};
  Caster caster{CasterForm::kBox, shape, {}, {}};
  for (int i = 0; i < 3; ++i) {
    const double scale = 1.0 / apart(lit.sun[i]);
    lit.set_function(i, scale, caster.n[i]);
    caster.e[i] = static_cast<float>(half[i] * std::abs(scale));
  }
  add(caster, lit, lit.center, half, light, casters);
}

/// A sphere about a point of the shape's axis.
void cast_sphere(const PlacedShape& placed, int shape, double along, const Lit& lit, Light& light,
                 Caster* casters) {
  const double radius = placed.half.x;
  const Vec3<double> center = lit.center + lit.axis[2] * along;
  Caster caster{CasterForm::kSphere, shape, {}, {}};
  const double from[3] = {center.x, center.y, center.z};
  for (int i = 0; i < 3; ++i) {
    caster.n[i][i] = 1.0f;
    caster.n[i][3] = static_cast<float>(-from[i]);
  }
  caster.e[0] = static_cast<float>(radius * radius);
  add(caster, lit, center, {radius, radius, radius}, light, casters);
}

void cast_cylinder(const PlacedShape& placed, int shape, const Lit& lit, Light& light,
                   Caster* casters) {
  const double radius = placed.half.x, half = placed.half.z;
  const double x = lit.sun[0], y = lit.sun[1], scale = 1.0 / apart(lit.sun[2]);
  const double across = std::max(x * x + y * y, kLeast * kLeast);
  Caster caster{CasterForm::kCylinder, shape, {}, {}};
  lit.set_function(0, 1.0, caster.n[0]);
  lit.set_function(1, 1.0, caster.n[1]);
  lit.set_function(2, scale, caster.n[2]);
  const double e[6] = {x, y, across, 1.0 / across, radius * radius, half * std::abs(scale)};
  std::transform(e, e + 6, caster.e, [](double v) { return static_cast<float>(v); });
  add(caster, lit, lit.center, {radius, radius, half}, light, casters);
}

/// The box about a mesh casts its shadow.
PlacedShape box_about(const PlacedShape& placed) {
  PlacedShape box = placed;
  box.solid = Solid::kBox;
  box.position += placed.axes * placed.mesh->center();
  box.half = placed.mesh->half();
  return box;
}

}  // namespace

void set_sides(Light& light) {
  const Vec3<double> sun = vec3_of(light.sun);
  const bool is_flat = std::abs(sun.z) < 0.5;
  const Vec3<double> other{0.0, is_flat ? 0.0 : 1.0, is_flat ? 1.0 : 0.0};
  const Vec3<double> first = cross(sun, other), side = first / norm(first);
  copy(side, light.side[0]);
  copy(cross(sun, side), light.side[1]);
}

void cast(const PlacedShape& placed, int shape, const Eye& eye, Light& light, Caster* casters) {
  if (placed.solid == Solid::kPlane) return;
  if (placed.solid == Solid::kMesh) {
    // All of a height field would lie in the shadow of the box about it.
    if (placed.label == Label::kGround) return;
    return cast(box_about(placed), shape, eye, light, casters);
  }
  const Lit lit(placed, eye, light);
  if (placed.solid == Solid::kBox) return cast_box(placed, shape, lit, light, casters);
  if (placed.solid == Solid::kSphere) return cast_sphere(placed, shape, 0.0, lit, light, casters);
  cast_cylinder(placed, shape, lit, light, casters);
  if (placed.solid != Solid::kCapsule) return;
  for (const double end : {placed.half.z, -placed.half.z}) {
    cast_sphere(placed, shape, end, lit, light, casters);
  }
}

}  // namespace skybody::render
