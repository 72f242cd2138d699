// Image velocities of points, from the exact motion of camera and bodies.
#pragma once

#include "render/scene.h"
#include "sensors/imaging/world_shapes.h"

namespace skybody::camera {

/// Rate of change of the image coordinates x / z, y / z of a point [1/s].
struct ImageVelocity {
  double x, y;
};

/// The flow at one exposure. A point at z (x, y, 1) in camera axes that moves with v relative to
/// the camera has the image velocity (v_x - x v_z, v_y - y v_z) / z.
class FlowOfBodies {
 public:
  using Motion = sensor::WorldShapes::Motion;

  /// @param carrier  the body that carries the camera
  FlowOfBodies(const render::Eye& eye, const Motion& carrier)
      : eye_(eye),
        velocity_(carrier.velocity +
                  cross(carrier.angular_velocity, eye.position - carrier.position)),
        turn_(carrier.angular_velocity) {}

  /// Of a point at rest. @param along  (x, y, 1)  @param depth  z [m]
  ImageVelocity of_world(const Vec3<double>& along, double depth) const {
    return of_point(along, depth, Vec3<double>{0.0, 0.0, 0.0});
  }
  /// Of a point of a body.
  ImageVelocity of_body(const Vec3<double>& along, double depth, const Motion& body) const {
    const Vec3<double> point = eye_.position + eye_.axes * along * depth;
    return of_point(along, depth,
                    body.velocity + cross(body.angular_velocity, point - body.position));
  }
  /// Of a point at any distance: the camera's turning alone.
  ImageVelocity of_infinity(const Vec3<double>& along) const {
    const Vec3<double> v = transpose_times(eye_.axes, -cross(turn_, eye_.axes * along));
    return {v.x - along.x * v.z, v.y - along.y * v.z};
  }

 private:
  /// @param velocity  of the point, W [m/s]
  ImageVelocity of_point(const Vec3<double>& along, double depth,
                         const Vec3<double>& velocity) const {
    if (!(depth > 0.0)) return {0.0, 0.0};  // the eye is inside of a shape
    const Vec3<double> from_eye = eye_.axes * along * depth;
    const Vec3<double> relative = velocity - velocity_ - cross(turn_, from_eye);
    const Vec3<double> v = transpose_times(eye_.axes, relative) / depth;
    return {v.x - along.x * v.z, v.y - along.y * v.z};
  }

  render::Eye eye_;
  Vec3<double> velocity_;  ///< of the eye, W [m/s]
  Vec3<double> turn_;      ///< angular velocity of the camera, W [rad/s]
};

}  // namespace skybody::camera
