// The scenario's obstacles for plugins: each environment has its own positions and sizes.
#pragma once

#include <skybody/plugin.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace skybody::obstacles {

/// An obstacle, as found in configure().
struct Obstacle {
  int kind = SKYBODY_SPHERE;  ///< SkybodyShapeKind
  int first_param = 0;        ///< EnvParams, at the places of SkybodyObstacleConstant
  int index = 0;              ///< among the obstacles
};

/// All obstacles, in the scenario's order, height fields included.
/// @param reader  the caller, for messages, such as "task `obstacles`"
/// @throws std::runtime_error with the name of an obstacle that is a mesh
inline std::vector<Obstacle> find_with_fields(const Setup& setup, const std::string& reader) {
  std::vector<Obstacle> found;
  for (const ShapeInfo& shape : setup.shapes()) {
    if (shape.obstacle < 0) continue;
    if (shape.kind == SKYBODY_MESH) {
      refuse("obstacle `", shape.name, "` is a mesh, and ", reader,
             " knows boxes, spheres, cylinders, capsules, gates, planes and height fields: replace "
             "it by one of these, or take it out");
    }
    found.push_back({shape.kind, shape.first_param, shape.obstacle});
  }
  return found;
}

/// All obstacles, in the scenario's order.
/// @throws std::runtime_error with the name of an obstacle whose surface has no closed form
inline std::vector<Obstacle> find(const Setup& setup, const std::string& reader) {
  for (const ShapeInfo& shape : setup.shapes()) {
    if (shape.obstacle < 0) continue;
    if (shape.kind == SKYBODY_HEIGHT_FIELD || shape.kind == SKYBODY_MESH) {
      refuse("obstacle `", shape.name, "` is a ",
             (shape.kind == SKYBODY_MESH ? "mesh" : "height field"), ", and ", reader,
             " knows boxes, spheres, cylinders, capsules, gates and planes: replace it by one of "
             "these, or take it out");
    }
  }
  return find_with_fields(setup, reader);
}

/// Pose and size of an obstacle in an environment.
template <class Real>
struct PlacedObstacle {
  MaskOf<Real> present;  ///< whether it exists in this environment
  Vec3<Real> position;   ///< of its centre, W [m]
  Quat<Real> rotation;   ///< W from its frame
  Vec3<Real> size;       ///< see SkybodyShapeKind [m]

  /// A point of W in the obstacle's frame [m].
  SKYBODY_INLINE Vec3<Real> local(const Vec3<Real>& p) const {
    return rotate_inverse(rotation, p - position);
  }
};

/// Number of size values for an obstacle of that kind; environments have EnvParams for these only.
inline int size_count(int kind) {
  switch (kind) {
    case SKYBODY_BOX:
    case SKYBODY_GATE:
      return 3;
    case SKYBODY_CYLINDER:
    case SKYBODY_CAPSULE:
      return 2;
    case SKYBODY_SPHERE:
      return 1;
    default:
      return 0;
  }
}

/// Current pose and size of an obstacle; size values that its kind does not use are 0.
template <class Real>
SKYBODY_INLINE PlacedObstacle<Real> place(const EnvView<Real>& env, const Obstacle& obstacle) {
  const int first = obstacle.first_param, turn = first + SKYBODY_OBSTACLE_ROTATION;
  const int sizes = size_count(obstacle.kind);
  const auto size = [&](int k) {
    return k < sizes ? env.param(first + SKYBODY_OBSTACLE_SIZE + k) : Real(0.0);
  };
  return {env.param(first + SKYBODY_OBSTACLE_PRESENT) > 0.5,
          env.param_vec3(first + SKYBODY_OBSTACLE_POSITION),
          {env.param(turn), env.param(turn + 1), env.param(turn + 2), env.param(turn + 3)},
          {size(0), size(1), size(2)}};
}

/// A bar of a gate, in the gate's frame: a box (docs/contact.md).
template <class Real>
struct Bar {
  Vec3<Real> position;  ///< of its centre [m]
  Vec3<Real> half;      ///< half of its edges [m]
};
inline constexpr int kBars = 4;  ///< two posts, two beams

/// Bar k of a gate of that size (width and height of the opening, thickness).
template <class Real>
SKYBODY_INLINE Bar<Real> bar_of_gate(const Vec3<Real>& size, int k) {
  const Real thick = 0.5 * size.z, zero(0.0);
  const double side = k % 2 == 0 ? 1.0 : -1.0;
  if (k < 2) {
    return {{zero, side * (0.5 * size.x + thick), zero}, {thick, thick, 0.5 * size.y + size.z}};
  }
  return {{zero, zero, side * (0.5 * size.y + thick)}, {thick, 0.5 * size.x, thick}};
}

}  // namespace skybody::obstacles
