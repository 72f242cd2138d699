// Optical flow and height, as on a Crazyflie's flow deck: a camera and a range finder that look
// along -z of the sensor.
#include <vector>

#include "plugins/obstacles/ray.h"
#include "sensors/common/errors.h"
#include "sensors/common/mount.h"
#include "sensors/common/settings.h"
#include "sensors/common/timed_sensor.h"

namespace skybody {
namespace {

using obstacles::Obstacle;
using obstacles::PlacedObstacle;
using obstacles::Ray;

class Flow : public sensor::TimedSensor {
 public:
  Flow()
      : TimedSensor({.steps = 0,
                     .rate = 100.0,
                     .doc = "interval of samples; 0: 100 Hz, to the nearest physics step"}) {}

  void configure(const Setup& setup) override {
    mount_.configure(setup);
    obstacles_ = obstacles::find(setup, "sensor `flow`");
    configure_timing(setup, {.size = 3, .has_stamp = true, .may_leave_out = true});
    setup.channel("flow", "rad/s", 2, -kInfinity, kInfinity, mount_.robot());
    setup.channel("height", "m", 1, 0.0, max_height_.value(), mount_.robot());
    setup.channel("stamp", "s", 1, 0.0, kInfinity, mount_.robot());
  }

  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>&, Values<Real> output,
             Values<Real> buffer) const {
    const auto is_due = due(env, buffer);
    const Values<Real> sample = room(env, output);
    if (any(is_due)) measure(env, sample);
    deliver(env, is_due, sample, output, buffer);
  }

 private:
  template <class Real>
  SKYBODY_INLINE void measure(const EnvView<Real>& env, const Values<Real>& sample) const {
    const BodyMotion<Real> body = env.body(mount_.body());
    const Quat<Real> mounting = mount_.rotation(env);
    const Quat<Real> axes = body.rotation * mounting;
    const Ray<Real> ray{mount_.position(env, body), -body_z(axes)};
    const Vec3<Real> v = rotate_inverse(axes, mount_.velocity(env, body));
    const Vec3<Real> w = rotate_inverse(mounting, body.angular_velocity);
    const Real distance = max(until_surface(env, ray), 1e-3);
    Real flow[2] = {v.x / distance - w.y, v.y / distance + w.x};
    Real height = distance;
    if (flow_noise_.is_given() || height_noise_.is_given()) {
      Real draws[4];
      sensor::fill_normal(random(env), draws);
      flow[0] = sensor::with_noise(flow[0], flow_noise_(env), draws[0]);
      flow[1] = sensor::with_noise(flow[1], flow_noise_(env), draws[1]);
      height = sensor::with_noise(height, height_noise_(env), draws[2]);
    }
    for (int i = 0; i < 2; ++i) {
      sample.set(i, max_flow_.is_given() ? sensor::saturated(flow[i], max_flow_(env)) : flow[i]);
    }
    sample.set(2, min(max(height, 0.0), max_height_.value()));
  }

  static constexpr double kFar = 1e15;  ///< [m]: no flow by translation

  /// Distance to the ground or the nearest obstacle; kFar without one.
  template <class Real>
  SKYBODY_INLINE Real until_surface(const EnvView<Real>& env, const Ray<Real>& ray) const {
    const Real far(kFar);
    Real nearest = ground_.value() ? min(obstacles::until_plane(ray), far) : far;
    for (const Obstacle& obstacle : obstacles_) {
      const PlacedObstacle<Real> placed = obstacles::place(env, obstacle);
      const Real distance = obstacles::until(obstacle, placed, ray);
      nearest = select(logical_and(placed.present, distance < nearest), distance, nearest);
    }
    return nearest;
  }

  sensor::Mount mount_{this};
  RealParameter max_height_{this, real("max_height", "m", 4.0, between(1e-3, 1e6),
                                       "height reading where no surface is nearer")};
  BooleanParameter ground_{this, boolean("ground", true, "the plane z = 0 of W is a surface")};
  RealParameter flow_noise_{
      this, sensor::error_size("flow_noise", "rad/s", "standard deviation of the flow, per axis")};
  RealParameter height_noise_{
      this, sensor::error_size("height_noise", "m", "standard deviation of the height")};
  RealParameter max_flow_{
      this, sensor::error_size("max_flow", "rad/s", "greatest magnitude of the flow; 0: no limit")};
  std::vector<Obstacle> obstacles_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Flow, "flow", "1.0.0",
               "Optical flow [rad/s] and height [m] of a camera and range finder that look down.");
