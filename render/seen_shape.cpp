#include "render/seen_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/math/math.h"
#include "render/mesh.h"

namespace skybody::render {
namespace {

/// Least distance of an eye from a face, and least depth of a projected point [m].
constexpr double kLeast = 1e-9;
/// Relative margin of covers, above the rounding of pixels' directions.
constexpr double kMargin = 1e-5;

constexpr float kEverywhere = std::numeric_limits<float>::infinity();
constexpr Cover kWholeImage{-kEverywhere, kEverywhere, -kEverywhere, kEverywhere};

/// A shape in camera axes.
struct Placed {
  Vec3<double> center;   ///< from the eye
  Vec3<double> axis[3];  ///< of its frame
  double eye[3];         ///< in its frame

  Placed(const PlacedShape& shape, const Eye& from)
      : center(transpose_times(from.axes, shape.position - from.position)) {
    for (int i = 0; i < 3; ++i) {
      axis[i] = transpose_times(from.axes, shape.axes.column(i));
      eye[i] = -dot(axis[i], center);
    }
  }
  /// Mirrors an axis, about which the shape is symmetric, so that it points to the eye's side.
  void face_eye(int i) {
    if (eye[i] >= 0.0) return;
    eye[i] = -eye[i];
    axis[i] = -axis[i];
  }
};

Linear linear(const Vec3<double>& v, double scale) {
  return {static_cast<float>(v.z * scale), static_cast<float>(v.x * scale),
          static_cast<float>(v.y * scale)};
}

void copy(const Vec3<double>& v, float (&out)[3]) {
  out[0] = static_cast<float>(v.x);
  out[1] = static_cast<float>(v.y);
  out[2] = static_cast<float>(v.z);
}

/// The cover of points and spheres, as the union of their covers.
class CoverSum {
 public:
  /// A sphere. @param radius  [m]; 0: a point
  void add(const Vec3<double>& center, double radius) {
    const double nearest = center.z - radius, farthest = center.z + radius;
    is_behind_ &= farthest <= 0.0;
    is_crossing_ |= nearest < kLeast;
    if (is_crossing_) return;
    const auto least = [&](double v) { return v / (v >= 0.0 ? farthest : nearest); };
    const auto most = [&](double v) { return v / (v >= 0.0 ? nearest : farthest); };
    left_ = std::min(left_, least(center.x - radius));
    right_ = std::max(right_, most(center.x + radius));
    top_ = std::min(top_, least(center.y - radius));
    bottom_ = std::max(bottom_, most(center.y + radius));
  }
  bool is_behind() const { return is_behind_; }
  Cover cover() const {
    if (is_crossing_) return kWholeImage;
    const auto below = [](double v) {
      return static_cast<float>(v - kMargin * (1.0 + std::abs(v)));
    };
    return {below(left_), -below(-right_), below(top_), -below(-bottom_)};
  }

 private:
  bool is_behind_ = true, is_crossing_ = false;
  double left_ = HUGE_VAL, right_ = -HUGE_VAL, top_ = HUGE_VAL, bottom_ = -HUGE_VAL;
};

SeenShape start_part(const PlacedShape& shape, Form form) {
  SeenShape part{};
  part.form = form;
  part.id = shape.instance | static_cast<std::uint32_t>(shape.label) << 16;
  std::copy(shape.paint.color.begin(), shape.paint.color.end(), part.color);
  return part;
}

/// w of entry and exit of a pair of faces at `half` to both sides, of which the eye is outside, or
/// of two exits, if it is between them.
void set_pair(double eye, double half, const Vec3<double>& axis, Linear& f, float& ratio) {
  const double before = std::max(eye - half, kLeast), beyond = std::max(eye + half, kLeast);
  const bool is_outside = eye > half;
  f = linear(axis, -1.0 / (is_outside ? before : beyond));
  ratio = static_cast<float>(is_outside ? before / beyond : -beyond / std::max(half - eye, kLeast));
}

bool see_box(const PlacedShape& shape, Placed& placed, SeenShape& part, Cover& cover) {
  const double half[3] = {shape.half.x, shape.half.y, shape.half.z};
  CoverSum corners;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3<double> at = placed.center;
    for (int i = 0; i < 3; ++i)
      at += placed.axis[i] * ((corner >> i & 1) != 0 ? half[i] : -half[i]);
    corners.add(at, 0.0);
  }
  if (corners.is_behind()) return false;
  cover = corners.cover();
  int order[3], outer = 0, inner = 3;
  for (int i = 0; i < 3; ++i) {
    placed.face_eye(i);
    order[placed.eye[i] > half[i] ? outer++ : --inner] = i;
  }
  part = start_part(shape, outer == 1 ? Form::kBox1 : outer == 2 ? Form::kBox2 : Form::kBox3);
  for (int k = 0; k < 3; ++k) {
    const int i = order[k];
    set_pair(placed.eye[i], half[i], placed.axis[i], part.f[k], part.n[k]);
    copy(placed.axis[i], part.axis[k]);
  }
  return true;
}

bool see_sphere(const PlacedShape& shape, const Vec3<double>& center, double radius,
                SeenShape& part, Cover& cover) {
  CoverSum sphere;
  sphere.add(center, radius);
  if (sphere.is_behind()) return false;
  cover = sphere.cover();
  part = start_part(shape, Form::kSphere);
  const double square = radius * radius;
  const double scale = 1.0 / std::max(dot(center, center) - square, kLeast * square);
  part.f[0] = linear(center, scale);
  part.f[1] = linear({-center.y, center.x, 0.0}, scale);  // of the cross product: along the axis
  const double n[] = {square * scale * scale, center.y * scale, center.z * scale, center.x * scale};
  for (int k = 0; k < 4; ++k) part.n[k] = static_cast<float>(n[k]);
  copy(center, part.center);
  part.inverse_radius = static_cast<float>(1.0 / radius);
  return true;
}

/// A cylinder, or a tube. @returns false: behind the eye, or the eye sees no part of a tube
bool see_cylinder(const PlacedShape& shape, Placed& placed, bool is_tube, SeenShape& part,
                  Cover& cover) {
  const double radius = shape.half.x, half = shape.half.z;
  CoverSum ends;
  ends.add(placed.center + placed.axis[2] * half, radius);
  ends.add(placed.center - placed.axis[2] * half, radius);
  if (ends.is_behind()) return false;
  cover = ends.cover();
  placed.face_eye(2);
  const double x = placed.eye[0], y = placed.eye[1], z = placed.eye[2];
  const double beyond = x * x + y * y - radius * radius;
  const bool is_within = beyond < 0.0;
  if (is_tube && is_within) return false;
  const Form outside = z > half ? Form::kCylinderBoth : Form::kCylinderSide;
  part = start_part(shape, is_tube ? Form::kTube : is_within ? Form::kCylinderCap : outside);
  const double least = kLeast * radius * radius;
  const double scale = 1.0 / (is_within ? std::min(beyond, -least) : std::max(beyond, least));
  part.f[0] = linear(placed.axis[0] * x + placed.axis[1] * y, -scale);
  part.f[1] = linear(placed.axis[0], radius * scale);
  part.f[2] = linear(placed.axis[1], radius * scale);
  part.f[3] = linear(placed.axis[1] * x - placed.axis[0] * y, scale);
  if (is_tube) {
    part.f[4] = linear(placed.axis[2], 1.0);
    part.n[0] = static_cast<float>(z);
    part.n[1] = static_cast<float>(half);
  } else {
    set_pair(z, half, placed.axis[2], part.f[4], part.n[0]);
  }
  copy(placed.center, part.center);
  for (int i = 0; i < 3; ++i) copy(placed.axis[i], part.axis[i]);
  part.inverse_radius = static_cast<float>(1.0 / radius);
  return true;
}

int see_capsule(const PlacedShape& shape, Placed& placed, SeenShape* parts, Cover* covers) {
  const Vec3<double> along = placed.axis[2] * shape.half.z;
  int count = see_cylinder(shape, placed, true, parts[0], covers[0]) ? 1 : 0;
  for (const double side : {1.0, -1.0}) {
    const Vec3<double> end = placed.center + along * side;
    count += see_sphere(shape, end, shape.half.x, parts[count], covers[count]) ? 1 : 0;
  }
  return count;
}

/// The box about a mesh, as a cover of it.
bool cover_mesh(const PlacedShape& shape, Placed& placed, SeenShape& part, Cover& cover) {
  const Vec3<double>&middle = shape.mesh->center(), &half = shape.mesh->half();
  CoverSum corners;
  for (int corner = 0; corner < 8; ++corner) {
    const auto side = [corner](int axis) { return (corner >> axis & 1) != 0 ? 1.0 : -1.0; };
    corners.add(placed.center + placed.axis[0] * (middle.x + side(0) * half.x) +
                    placed.axis[1] * (middle.y + side(1) * half.y) +
                    placed.axis[2] * (middle.z + side(2) * half.z),
                0.0);
  }
  if (corners.is_behind()) return false;
  cover = corners.cover();
  part = start_part(shape, Form::kBox1);  // it is in no tile's list
  return true;
}

/// `value` modulo 2, in [0, 2).
double modulo_two(double value) { return value - 2.0 * floor(0.5 * value); }

void see_plane(const PlacedShape& shape, const Placed& placed, SeenShape& part, Cover& cover) {
  cover = kWholeImage;
  part = start_part(shape, Form::kPlane);
  part.f[0] = linear(placed.axis[2], -1.0 / std::max(placed.eye[2], kLeast));
  for (int i = 0; i < 3; ++i) copy(placed.axis[i], part.axis[i]);
  const Paint& paint = shape.paint;
  if (!(paint.square > 0.0f)) return;
  std::copy(paint.checker.begin(), paint.checker.end(), part.checker);
  part.square = 1.0f / paint.square;
  for (int i = 0; i < 2; ++i) {
    part.place[i] = static_cast<float>(modulo_two(placed.eye[i] / paint.square));
  }
}

}  // namespace

bool contains(const PlacedShape& shape, const Vec3<double>& eye) {
  const Vec3<double> at = transpose_times(shape.axes, eye - shape.position);
  const Vec3<double>& half = shape.half;
  const double aside = at.x * at.x + at.y * at.y;
  switch (shape.solid) {
    case Solid::kBox:
      return std::abs(at.x) <= half.x && std::abs(at.y) <= half.y && std::abs(at.z) <= half.z;
    case Solid::kSphere:
      return aside + at.z * at.z <= half.x * half.x;
    case Solid::kCylinder:
      return aside <= half.x * half.x && std::abs(at.z) <= half.z;
    case Solid::kCapsule: {
      const double over = std::max(std::abs(at.z) - half.z, 0.0);
      return aside + over * over <= half.x * half.x;
    }
    case Solid::kPlane:
      return at.z <= 0.0;
    case Solid::kMesh:
      return false;
  }
  return false;
}

int see(const PlacedShape& shape, const Eye& eye, SeenShape* parts, Cover* covers) {
  Placed placed(shape, eye);
  switch (shape.solid) {
    case Solid::kBox:
      return see_box(shape, placed, parts[0], covers[0]) ? 1 : 0;
    case Solid::kSphere:
      return see_sphere(shape, placed.center, shape.half.x, parts[0], covers[0]) ? 1 : 0;
    case Solid::kCylinder:
      return see_cylinder(shape, placed, false, parts[0], covers[0]) ? 1 : 0;
    case Solid::kCapsule:
      return see_capsule(shape, placed, parts, covers);
    case Solid::kPlane:
      see_plane(shape, placed, parts[0], covers[0]);
      return 1;
    case Solid::kMesh:
      return cover_mesh(shape, placed, parts[0], covers[0]) ? 1 : 0;
  }
  return 0;
}

}  // namespace skybody::render
