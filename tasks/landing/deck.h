// A deck, and the height of a robot's lowest point above it.
#pragma once

#include <skybody/plugin.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace skybody::landing {

/// A robot's motion relative to the deck. Deck frame: origin at the centre of its upper face, z out
/// of it.
template <class Real>
struct OverDeck {
  Vec3<Real> position;  ///< of the robot's base, deck axes [m]
  Vec3<Real> velocity;  ///< relative to the deck's material below it, deck axes [m/s]
  Quat<Real> rotation;  ///< deck from B
  Real height;          ///< of the robot's lowest point over the face's plane [m]
};

/// The upper face of a box of a robot's base.
class Deck {
 public:
  /// @param pad  index of the robot whose base has the box; the largest of several is used
  /// @throws std::runtime_error if there is none
  void configure(const Setup& setup, int pad) {
    const RobotInfo& info = setup.robots()[pad];
    body_ = info.first_body;
    double area = 0.0;
    for (const ShapeInfo& shape : setup.shapes()) {
      const double own = shape.size[0] * shape.size[1];
      if (shape.body != body_ || shape.kind != SKYBODY_BOX || own <= area) continue;
      area = own;
      turn_ = {shape.rotation[0], shape.rotation[1], shape.rotation[2], shape.rotation[3]};
      const Vec3<double> up = rotate(turn_, Vec3<double>{0.0, 0.0, 0.5 * shape.size[2]});
      middle_ = Vec3<double>{shape.position[0], shape.position[1], shape.position[2]} + up;
      half_x_ = 0.5 * shape.size[0];
      half_y_ = 0.5 * shape.size[1];
    }
    if (area > 0.0) return;
    refuse("the base of robot `", info.name,
           "` has no box to land on: give its link a `<collision>` with a box");
  }

  double half_x() const { return half_x_; }  ///< half the length of its edges [m]
  double half_y() const { return half_y_; }

  /// W from the deck's frame.
  template <class Real>
  SKYBODY_INLINE Quat<Real> rotation(const EnvView<Real>& env) const {
    return env.body(body_).rotation * to_real<Real>(turn_);
  }
  /// Centre of the upper face, W [m].
  template <class Real>
  SKYBODY_INLINE Vec3<Real> middle(const EnvView<Real>& env) const {
    const BodyMotion<Real> pad = env.body(body_);
    return pad.position + rotate(pad.rotation, to_real<Real>(middle_));
  }
  /// Velocity of the deck's material at a point of W, W [m/s].
  template <class Real>
  SKYBODY_INLINE Vec3<Real> velocity(const EnvView<Real>& env, const Vec3<Real>& place) const {
    const BodyMotion<Real> pad = env.body(body_);
    return pad.velocity + cross(rotate(pad.rotation, pad.angular_velocity), place - pad.position);
  }
  /// Whether a point in the deck's frame is over it, at least `inset` [m] within its edges.
  template <class Real>
  SKYBODY_INLINE MaskOf<Real> is_under(const Vec3<Real>& place, double inset) const {
    return logical_and(abs(place.x) <= half_x_ - inset, abs(place.y) <= half_y_ - inset);
  }

 private:
  int body_ = 0;
  Vec3<double> middle_{};                  ///< centre of the face, in the pad's frame [m]
  Quat<double> turn_{1.0, 0.0, 0.0, 0.0};  ///< pad's frame from the deck's
  double half_x_ = 0.0, half_y_ = 0.0;
};

/// Contact points of a robot's base: corners of the boxes about its shapes, and centres of its
/// spheres.
class TouchdownPoints {
 public:
  /// @throws std::runtime_error if the base has no shape
  void configure(const Setup& setup, int robot) {
    const RobotInfo& info = setup.robots()[robot];
    body_ = info.first_body;
    for (const ShapeInfo& shape : setup.shapes()) {
      if (shape.body == body_) add(shape);
    }
    if (!points_.empty()) return;
    refuse(
        "the base of robot `", info.name,
        "` has no collision shape, so that it cannot touch a deck: give its link a `<collision>`");
  }

  template <class Real>
  SKYBODY_INLINE OverDeck<Real> over(const Deck& deck, const EnvView<Real>& env) const {
    const BodyMotion<Real> body = env.body(body_);
    const Quat<Real> turn = deck.rotation(env);
    OverDeck<Real> found;
    found.position = rotate_inverse(turn, body.position - deck.middle(env));
    found.velocity = rotate_inverse(turn, body.velocity - deck.velocity(env, body.position));
    found.rotation = conjugate(turn) * body.rotation;
    Real lowest(kInfinity);
    for (const Point& point : points_) {
      lowest = min(lowest, rotate(found.rotation, to_real<Real>(point.place)).z - point.radius);
    }
    found.height = found.position.z + lowest;
    return found;
  }

 private:
  struct Point {
    Vec3<double> place;  ///< in the body's frame [m]
    double radius;       ///< [m]
  };

  void add(const ShapeInfo& shape) {
    const Vec3<double> at{shape.position[0], shape.position[1], shape.position[2]};
    const Quat<double> turn{shape.rotation[0], shape.rotation[1], shape.rotation[2],
                            shape.rotation[3]};
    const double* size = shape.size;
    switch (shape.kind) {
      case SKYBODY_SPHERE:
        points_.push_back({at, size[0]});
        return;
      case SKYBODY_CAPSULE:
        for (const double side : {-0.5, 0.5})
          points_.push_back({at + rotate(turn, Vec3<double>{0.0, 0.0, side * size[1]}), size[0]});
        return;
      case SKYBODY_CYLINDER:
        add_corners(at, turn, {size[0], size[0], 0.5 * size[1]});
        return;
      default:  // a box, or a mesh's bounding box
        add_corners(at, turn, {0.5 * size[0], 0.5 * size[1], 0.5 * size[2]});
    }
  }

  void add_corners(const Vec3<double>& at, const Quat<double>& turn, const Vec3<double>& half) {
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3<double> place{(corner & 1) != 0 ? half.x : -half.x,
                               (corner & 2) != 0 ? half.y : -half.y,
                               (corner & 4) != 0 ? half.z : -half.z};
      points_.push_back({at + rotate(turn, place), 0.0});
    }
  }

  int body_ = 0;
  std::vector<Point> points_;
};

}  // namespace skybody::landing
