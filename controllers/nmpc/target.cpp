#include "controllers/nmpc/target.h"

namespace skybody::nmpc {

ReferencePoint<double> extrapolated(const ReferencePoint<double>& point, double time) {
  const double t = time;
  ReferencePoint<double> out = point;
  out.jerk += point.snap * t;
  out.acceleration += (point.jerk + point.snap * (t / 2.0)) * t;
  out.velocity += (point.acceleration + (point.jerk + point.snap * (t / 3.0)) * (t / 2.0)) * t;
  out.position +=
      (point.velocity +
       (point.acceleration + (point.jerk + point.snap * (t / 4.0)) * (t / 3.0)) * (t / 2.0)) *
      t;
  out.yaw += point.yaw_rate * t;
  return out;
}

Target target_of(const Model& model, const ShareRow* rows, double least,
                 const Disturbance& disturbance, const ReferencePoint<double>& point) {
  // Thrust compensates drag. The drag's axes follow from the thrust without it; the difference is
  // of second order.
  Vec3<double> thrust = point.acceleration - model.gravity - disturbance.acceleration;
  const double size = norm(thrust);
  if (size > control::kLeastThrust) {
    const Vec3<double> up = thrust / size;
    const Vec3<double> along = up * dot(up, point.velocity);
    thrust +=
        (point.velocity - along) * (0.5 * (model.drag.x + model.drag.y)) + along * model.drag.z;
  }
  const control::FlatMotion<double> flat =
      control::flat_motion<double>({thrust, point.jerk, point.snap}, point.yaw, point.yaw_rate);
  const Vec3<double> gyro = model.inverse_inertia * cross(flat.rates, model.inertia * flat.rates);
  const Vec3<double> angular = flat.angular_acceleration + gyro - disturbance.angular_acceleration;
  Target target{point.position, point.velocity, flat.rotation, flat.rates, {}};
  for (int i = 0; i < model.rotors; ++i) {
    const double share = rows[i].thrust * flat.thrust + dot(rows[i].angular, angular);
    target.share[i] = clamp(share, least, 1.0);
  }
  return target;
}

}  // namespace skybody::nmpc
