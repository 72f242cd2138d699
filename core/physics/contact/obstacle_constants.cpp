// Poses and sizes of an environment's obstacles, from its parameters.
#include <string>

#include "core/base/math/mat3.h"
#include "core/base/system/error.h"
#include "core/model/gate.h"
#include "core/physics/bodies/kinematics.h"
#include "core/physics/contact/contact_scene.h"

namespace skybody {
namespace {

/// Half the size of a plane [m].
constexpr double kEverywhere = 1e30;

/// Number of size parameters of an obstacle's shape.
int count_sizes(ShapeType type) {
  switch (type) {
    case ShapeType::kBox:
      return 3;
    case ShapeType::kCylinder:
    case ShapeType::kCapsule:
    case ShapeType::kHeightField:
      return 2;
    case ShapeType::kSphere:
      return 1;
    case ShapeType::kPlane:
    case ShapeType::kMesh:
      break;
  }
  return 0;
}

/// @param params  the obstacle's
void check_obstacle(const Obstacle& obstacle, const double* params) {
  const auto check = [&](int place, const char* key) {
    if (params[place] > 0.0) return;
    throw Error("the obstacle `" + obstacle.name + "` has the " + key + " " +
                std::to_string(params[place]) + "; allowed: above 0");
  };
  const int sizes = count_sizes(obstacle.shape.type);
  for (int k = 0; k < sizes; ++k) check(kObstacleSize + k, "size");
  const Quat<double> rotation = load_quat(params + kObstacleRotation);
  if (!(squared_norm(rotation) > 0.0)) {
    throw Error("the obstacle `" + obstacle.name + "` has a rotation of norm 0");
  }
}

}  // namespace

int count_obstacle_shapes(const Scenario& scenario) {
  std::size_t count = 0;
  for (const Obstacle& obstacle : scenario.obstacles) count += obstacle_shapes_of(obstacle).size();
  return static_cast<int>(count);
}

void make_obstacle_constants(const World& world, const double* params, double* out) {
  std::size_t i = 0;
  for (const Obstacle& obstacle : world.scenario.obstacles) {
    const double* p = params + world.layout.obstacle_params[i++];
    const ShapeType type = obstacle.shape.type;
    const bool is_there = p[kObstaclePresent] != 0.0 && type != ShapeType::kMesh;
    if (is_there) check_obstacle(obstacle, p);
    const double* size = p + kObstacleSize;
    const Vec3<double> place = load_vec3(p + kObstaclePosition);
    const Mat3<double> axes = to_mat3(normalized(load_quat(p + kObstacleRotation)));
    const auto put = [&](const Vec3<double>& position, const Vec3<double>& half, double rounding) {
      store(place + axes * position, out + kShapePosition);
      for (int k = 0; k < 9; ++k) out[kShapeAxes + k] = axes.m[k];
      store(half, out + kShapeHalf);
      out[kShapeRounding] = is_there ? rounding : kNoShape;
      const double reach = is_unbounded_below(type) ? kEverywhere : norm(half);
      out[kShapeReach] = reach + out[kShapeRounding];
      out += kShapeConstantCount;
    };
    const Vec3<double> middle{0.0, 0.0, 0.0};
    if (obstacle.is_gate) {
      for (const GateBar& bar : gate_bars(load_vec3(size))) put(bar.position, 0.5 * bar.size, 0.0);
    } else if (type == ShapeType::kBox) {
      put(middle, 0.5 * load_vec3(size), 0.0);
    } else if (type == ShapeType::kCylinder) {
      put(middle, {size[0], size[0], 0.5 * size[1]}, 0.0);
    } else if (type == ShapeType::kCapsule) {
      put(middle, {0.0, 0.0, 0.5 * size[1]}, size[0]);
    } else if (type == ShapeType::kPlane) {
      put(middle, {kEverywhere, kEverywhere, 0.0}, 0.0);
    } else if (type == ShapeType::kHeightField) {
      put(middle, {0.5 * size[0], 0.5 * size[1], obstacle.shape.heights->highest()}, 0.0);
    } else {
      put(middle, middle, type == ShapeType::kSphere ? size[0] : 0.0);
    }
  }
}

}  // namespace skybody
