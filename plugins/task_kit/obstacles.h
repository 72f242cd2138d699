// Obstacles as a robot sees them: the way to the nearest point of each, of those that are nearest.
#pragma once

#include <skybody/plugin.h>

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

namespace skybody::task_kit {

/// The way to an obstacle.
template <class Real>
struct ObstacleSight {
  Vec3<Real> offset;  ///< nearest point of the obstacle - point, W [m]; 0 where it is within
  Real distance;      ///< its length [m]; infinite: there is no such obstacle
};

/// All obstacles of a scenario. A member of a task.
class Obstacles {
 public:
  static constexpr int kMostSeen = 8;
  template <class Real>
  using Nearest = std::array<ObstacleSight<Real>, kMostSeen>;

  /// Takes the scenario's boxes, cylinders, spheres and capsules.
  /// @param task  its name, for the message
  /// @throws std::runtime_error on one of another kind, which has no nearest point here
  void configure(const Setup& setup, const std::string& task) {
    for (const ShapeInfo& shape : setup.shapes()) {
      if (shape.robot >= 0) continue;
      if (shape.kind != SKYBODY_BOX && shape.kind != SKYBODY_CYLINDER &&
          shape.kind != SKYBODY_SPHERE && shape.kind != SKYBODY_CAPSULE) {
        throw std::runtime_error(
            "obstacle `" + std::string(shape.name) + "` is " + word(shape.kind) + ", and task `" +
            task + "` sees boxes, cylinders, spheres and capsules alone: take one of these");
      }
      solids_.push_back({shape.kind, shape.first_param});
    }
  }
  int count() const { return static_cast<int>(solids_.size()); }

  /// The way to the nearest point of obstacle i. Where the environment has none of it the distance
  /// is infinite.
  template <class Real>
  SKYBODY_INLINE ObstacleSight<Real> sight(const EnvView<Real>& env, int i,
                                           const Vec3<Real>& point) const {
    const Solid& solid = solids_[static_cast<std::size_t>(i)];
    const int first = solid.first_param;
    const int turn = first + SKYBODY_OBSTACLE_ROTATION;
    const Quat<Real> rotation{env.param(turn), env.param(turn + 1), env.param(turn + 2),
                              env.param(turn + 3)};
    const Vec3<Real> size = size_of(env, solid);
    const Vec3<Real> local =
        rotate_inverse(rotation, point - env.param_vec3(first + SKYBODY_OBSTACLE_POSITION));
    const Vec3<Real> offset = rotate(rotation, nearest(solid.kind, size, local) - local);
    const auto is_there = env.param(first + SKYBODY_OBSTACLE_PRESENT) > 0.5;
    return {select(is_there, offset, Vec3<Real>{Real(0.0), Real(0.0), Real(0.0)}),
            select(is_there, norm(offset), Real(kInfinity))};
  }

  /// The `seen` <= kMostSeen nearest ones, the nearest first; without an obstacle 0 and infinite.
  template <class Real>
  SKYBODY_INLINE Nearest<Real> nearest_of(const EnvView<Real>& env, const Vec3<Real>& point,
                                          int seen) const {
    Nearest<Real> sorted;
    sorted.fill({{Real(0.0), Real(0.0), Real(0.0)}, Real(kInfinity)});
    for (int i = 0; i < count(); ++i) {
      ObstacleSight<Real> next = sight(env, i, point);
      for (int k = 0; k < seen; ++k) {  // what is nearer pushes the others one place on
        ObstacleSight<Real>& place = sorted[static_cast<std::size_t>(k)];
        const auto nearer = next.distance < place.distance;
        const ObstacleSight<Real> pushed{select(nearer, place.offset, next.offset),
                                         select(nearer, place.distance, next.distance)};
        place = {select(nearer, next.offset, place.offset),
                 select(nearer, next.distance, place.distance)};
        next = pushed;
      }
    }
    return sorted;
  }

 private:
  struct Solid {
    int kind;         ///< SkybodyShapeKind
    int first_param;  ///< EnvParams, at the places of SkybodyObstacleConstant
  };

  static const char* word(int kind) {
    switch (kind) {
      case SKYBODY_GATE:
        return "a gate";
      case SKYBODY_PLANE:
        return "a plane";
      case SKYBODY_HEIGHT_FIELD:
        return "a height field";
      default:
        return "a mesh";
    }
  }

  /// As SkybodyShapeKind says; a kind has no EnvParams for what it does not need, which is 0 here.
  template <class Real>
  static SKYBODY_INLINE Vec3<Real> size_of(const EnvView<Real>& env, const Solid& solid) {
    const int first = solid.first_param + SKYBODY_OBSTACLE_SIZE;
    const int count = solid.kind == SKYBODY_BOX ? 3 : solid.kind == SKYBODY_SPHERE ? 1 : 2;
    Real size[3] = {Real(0.0), Real(0.0), Real(0.0)};
    for (int k = 0; k < count; ++k) size[k] = env.param(first + k);
    return {size[0], size[1], size[2]};
  }

  /// Of a solid about its frame's origin, the point that is nearest to p; p itself within.
  template <class Real>
  static SKYBODY_INLINE Vec3<Real> nearest(int kind, const Vec3<Real>& size, const Vec3<Real>& p) {
    switch (kind) {
      case SKYBODY_BOX:
        return {clamp_to(p.x, 0.5 * size.x), clamp_to(p.y, 0.5 * size.y),
                clamp_to(p.z, 0.5 * size.z)};
      case SKYBODY_CYLINDER: {
        const Real share = within(sqrt(p.x * p.x + p.y * p.y), size.x);
        return {p.x * share, p.y * share, clamp_to(p.z, 0.5 * size.y)};
      }
      case SKYBODY_SPHERE:
        return p * within(norm(p), size.x);
      default: {  // a capsule: a sphere about the nearest point of its axis
        const Vec3<Real> centre{Real(0.0), Real(0.0), clamp_to(p.z, 0.5 * size.y)};
        const Vec3<Real> aside = p - centre;
        return centre + aside * within(norm(aside), size.x);
      }
    }
  }
  template <class Real>
  static SKYBODY_INLINE Real clamp_to(const Real& x, const Real& most) {
    return max(min(x, most), -most);
  }
  /// The factor that brings a length down to `most`; 1 where it is shorter.
  template <class Real>
  static SKYBODY_INLINE Real within(const Real& length, const Real& most) {
    return most / max(length, most);
  }

  std::vector<Solid> solids_;
};

}  // namespace skybody::task_kit
