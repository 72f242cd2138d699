#include "core/physics/shapes/overlap.h"

#include "core/physics/shapes/height_field.h"
#include "core/physics/shapes/surface_distance.h"

namespace skybody {
namespace {

/// Sample positions along each of a shape's dimensions, from -1 to 1.
constexpr double kPlaces[] = {-1.0, -0.5, 0.0, 0.5, 1.0};
constexpr int kDirections = 8;

/// Greatest exact distance from a height field: four of its cells [m].
double reach_of(const Shape& shape) {
  const HeightField& field = *shape.heights;
  return 4.0 * max(shape.size.x / (field.columns() - 1), shape.size.y / (field.rows() - 1));
}

double distance(const Shape& shape, const Vec3<double>& point) {
  switch (shape.type) {
    case ShapeType::kBox:
      return box_distance(0.5 * shape.size, point).distance;
    case ShapeType::kCylinder:
      return cylinder_distance(shape.radius, 0.5 * shape.length, point).distance;
    case ShapeType::kSphere:
      return sphere_distance(shape.radius, point).distance;
    case ShapeType::kCapsule:
      return capsule_distance(shape.radius, 0.5 * shape.length, point).distance;
    case ShapeType::kPlane:
      return plane_distance(point).distance;
    case ShapeType::kHeightField:
      return distance_from_heights(*shape.heights, 0.5 * shape.size.x, 0.5 * shape.size.y,
                                   reach_of(shape), point)
          .distance;
    case ShapeType::kMesh:
      return box_distance(0.5 * shape.box_size, point - shape.box_center).distance;
  }
  return kInfinity;
}

/// Adds points on a circle about the z axis, and its centre.
void add_disc(double radius, double z, std::vector<Vec3<double>>& points) {
  points.push_back({0.0, 0.0, z});
  for (int i = 0; i < kDirections; ++i) {
    const SinCos<double> angle = sincos(i * (kTwoPi / kDirections));
    points.push_back({radius * angle.cos, radius * angle.sin, z});
  }
}

/// Greatest depth of the points in the shape.
double deepest(const std::vector<Vec3<double>>& points, const Pose& their_pose, const Shape& shape,
               const Pose& pose) {
  double depth = 0.0;
  for (const Vec3<double>& point : points) {
    const Vec3<double> common = their_pose.position + rotate(their_pose.rotation, point);
    const Vec3<double> own = rotate_inverse(pose.rotation, common - pose.position);
    depth = max(depth, -distance(shape, own));
  }
  return depth;
}

}  // namespace

double bounding_radius(const Shape& shape) {
  switch (shape.type) {
    case ShapeType::kBox:
      return 0.5 * norm(shape.size);
    case ShapeType::kCylinder:
      return sqrt(shape.radius * shape.radius + 0.25 * shape.length * shape.length);
    case ShapeType::kSphere:
      return shape.radius;
    case ShapeType::kCapsule:
      return shape.radius + 0.5 * shape.length;
    case ShapeType::kPlane:
    case ShapeType::kHeightField:
      return kInfinity;
    case ShapeType::kMesh:
      return norm(shape.box_center) + 0.5 * norm(shape.box_size);
  }
  return 0.0;
}

std::vector<Vec3<double>> points_of(const Shape& shape) {
  std::vector<Vec3<double>> points;
  const Vec3<double> half = 0.5 * shape.size;
  switch (shape.type) {
    case ShapeType::kBox:
      for (const double x : kPlaces) {
        for (const double y : kPlaces) {
          for (const double z : kPlaces) points.push_back({x * half.x, y * half.y, z * half.z});
        }
      }
      break;
    case ShapeType::kCylinder:
      for (const double z : kPlaces) {
        for (const double share : {0.5, 1.0}) {
          add_disc(share * shape.radius, z * 0.5 * shape.length, points);
        }
      }
      break;
    case ShapeType::kSphere:
      for (const double z : kPlaces) {
        add_disc(shape.radius * sqrt(1.0 - z * z), z * shape.radius, points);
      }
      break;
    case ShapeType::kCapsule:
      for (const double z : kPlaces) {
        add_disc(shape.radius, z * 0.5 * shape.length, points);
        const double cap = copysign(0.5 * shape.length, z) + z * shape.radius;
        add_disc(shape.radius * sqrt(1.0 - z * z), cap, points);
      }
      break;
    case ShapeType::kMesh: {
      Shape box;
      box.type = ShapeType::kBox;
      box.size = shape.box_size;
      for (const Vec3<double>& point : points_of(box)) points.push_back(point + shape.box_center);
      break;
    }
    case ShapeType::kPlane:
    case ShapeType::kHeightField:
      break;
  }
  return points;
}

double overlap(const Shape& a, const Pose& a_pose, const Shape& b, const Pose& b_pose) {
  const double reach = bounding_radius(a) + bounding_radius(b);
  if (norm(a_pose.position - b_pose.position) >= reach) return 0.0;
  return max(deepest(points_of(a), a_pose, b, b_pose), deepest(points_of(b), b_pose, a, a_pose));
}

}  // namespace skybody
