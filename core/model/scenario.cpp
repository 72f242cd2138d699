#include "core/model/scenario.h"

namespace skybody {
namespace {

Shape bar(Vec3<double> position, Vec3<double> size) {
  Shape shape;
  shape.type = ShapeType::kBox;
  shape.pose.position = position;
  shape.size = size;
  return shape;
}

}  // namespace

std::vector<Shape> solids_of(const Obstacle& obstacle) {
  if (!obstacle.is_gate) {
    Shape shape = obstacle.shape;
    shape.pose = Pose{};
    return {shape};
  }
  const double width = obstacle.shape.size.x, height = obstacle.shape.size.y;
  const double thickness = obstacle.shape.size.z;
  const double aside = 0.5 * (width + thickness), above = 0.5 * (height + thickness);
  const Vec3<double> post{thickness, thickness, height + 2.0 * thickness};
  const Vec3<double> beam{thickness, width, thickness};
  return {bar({0.0, aside, 0.0}, post), bar({0.0, -aside, 0.0}, post), bar({0.0, 0.0, above}, beam),
          bar({0.0, 0.0, -above}, beam)};
}

}  // namespace skybody
