#include "core/physics/step/reach.h"

#include <algorithm>

#include "core/base/math.h"
#include "core/physics/shapes/overlap.h"

namespace skybody {
namespace {

/// What a sphere is larger than it must be: what acceleration adds to its way in one step [m].
constexpr double kMargin = 1e-3;

/// Middle of the axis-aligned box around the shapes' bounding spheres, in the body's frame [m].
Vec3<double> middle(const std::vector<Shape>& shapes) {
  Vec3<double> low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  for (const Shape& shape : shapes) {
    const double r = bounding_radius(shape);
    const Vec3<double>& p = shape.pose.position;
    low = {min(low.x, p.x - r), min(low.y, p.y - r), min(low.z, p.z - r)};
    high = {max(high.x, p.x + r), max(high.y, p.y + r), max(high.z, p.z + r)};
  }
  return 0.5 * (low + high);
}

std::vector<Shape> without_meshes(std::vector<Shape> shapes) {
  std::erase_if(shapes, [](const Shape& shape) { return shape.type == ShapeType::kMesh; });
  return shapes;
}

}  // namespace

Reach::Reach(const World& world) : dt_(world.scenario.stepping.dt) {
  add_spheres(world);
  add_boxes(world);
  is_possible_ =
      !spheres_.empty() && (!boxes_.empty() || spheres_.front().next_robot < spheres_.size());
}

void Reach::add_spheres(const World& world) {
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    const std::vector<Shape> shapes = without_meshes(world.bodies[i].model->collisions);
    if (shapes.empty()) continue;
    Sphere sphere{static_cast<int>(i), 0, middle(shapes), 0.0};
    for (const Shape& shape : shapes) {
      const double far = norm(shape.pose.position - sphere.center) + bounding_radius(shape);
      sphere.radius = max(sphere.radius, far + kMargin);
    }
    spheres_.push_back(sphere);
  }
  for (Sphere& sphere : spheres_) {
    const int robot = world.bodies[static_cast<std::size_t>(sphere.body)].robot;
    sphere.next_robot = static_cast<std::size_t>(
        std::count_if(spheres_.begin(), spheres_.end(), [&](const Sphere& other) {
          return world.bodies[static_cast<std::size_t>(other.body)].robot <= robot;
        }));
  }
}

void Reach::add_boxes(const World& world) {
  for (const Obstacle& obstacle : world.scenario.obstacles) {
    const Shape& shape = obstacle.shape;
    if (shape.type == ShapeType::kMesh) continue;
    const Mat3<double> axes = to_mat3(shape.pose.rotation);
    Box box;
    box.center = shape.pose.position;
    for (int k = 0; k < 3; ++k) box.axis[k] = axes.column(k);
    if (shape.type == ShapeType::kBox) box.half = 0.5 * shape.size;
    if (shape.type == ShapeType::kCylinder) {
      box.half = {shape.radius, shape.radius, 0.5 * shape.length};
    }
    if (shape.type == ShapeType::kSphere) box.rounding = shape.radius;
    boxes_.push_back(box);
  }
}

}  // namespace skybody
