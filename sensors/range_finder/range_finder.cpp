// Range finder on any link: distance along rays to the nearest obstacle or the ground, with noise
// and the times of sensors/common.
#include <vector>

#include "plugins/obstacles/ray.h"
#include "sensors/common/mount.h"
#include "sensors/common/timed_sensor.h"

namespace skybody {
namespace {

using obstacles::Obstacle;
using obstacles::PlacedObstacle;
using obstacles::Ray;

class RangeFinder : public sensor::TimedSensor {
 public:
  void configure(const Setup& setup) override {
    mount_.configure(setup);
    obstacles_ = obstacles::find(setup, "sensor `range_finder`");
    add_rays();
    configure_timing(setup, {.size = count(), .may_leave_out = true});
    setup.channel("range", "m", count(), 0.0, max_range_.value(), mount_.robot());
  }

  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>&, Values<Real> output,
             Values<Real> buffer) const {
    const auto is_due = due(env, buffer);
    const Values<Real> ranges = room(env, output);
    if (any(is_due)) scan(env, ranges);
    deliver(env, is_due, ranges, output, buffer);
  }

 private:
  int count() const { return static_cast<int>(rays_.size()); }

  template <class Real>
  SKYBODY_INLINE void scan(const EnvView<Real>& env, const Values<Real>& output) const {
    const BodyMotion<Real> body = env.body(mount_.body());
    const Vec3<Real> from = mount_.position(env, body);
    const Quat<Real> axes = axes_of(env, body);
    for (int i = 0; i < count(); ++i) output.set(i, to_ground(turned(from, axes, i)));
    for (const Obstacle& obstacle : obstacles_) {
      const PlacedObstacle<Real> placed = obstacles::place(env, obstacle);
      for (int i = 0; i < count(); ++i) {
        const Real range = obstacles::until(obstacle, placed, turned(from, axes, i));
        const auto nearer = logical_and(placed.present, range < output[i]);
        output.set(i, select(nearer, range, output[i]));
      }
    }
    if (any(noise_(env) > 0.0)) add_noise(env, output);
  }

  /// Rings in the order of `elevations`, each with its rays counter-clockwise.
  void add_rays() {
    const int around = static_cast<int>(count_.value());
    const double field = field_of_view_.value();
    const bool is_ring = field >= kTwoPi;  // the last ray would coincide with the first
    const int gaps = is_ring ? around : around - 1;
    if (elevations_.count() == 0) {
      refuse("`elevations` is empty: give one or more, such as [0]");
    }
    for (int e = 0; e < elevations_.count(); ++e) {
      const SinCos<double> rise = sincos(elevations_.value(e));
      for (int i = 0; i < around; ++i) {
        const double first = is_ring || around == 1 ? 0.0 : -0.5 * field;
        const SinCos<double> turn = sincos(gaps > 0 ? first + field * i / gaps : 0.0);
        rays_.push_back({rise.cos * turn.cos, rise.cos * turn.sin, rise.sin});
      }
    }
  }

  /// W from the rays' axes.
  template <class Real>
  SKYBODY_INLINE Quat<Real> axes_of(const EnvView<Real>& env, const BodyMotion<Real>& body) const {
    const Quat<Real> axes = body.rotation * mount_.rotation(env);
    if (!level_.value()) return axes;
    const SinCos<Real> half = sincos(0.5 * yaw(axes));
    return {half.cos, Real(0.0), Real(0.0), half.sin};
  }

  template <class Real>
  SKYBODY_INLINE Ray<Real> turned(const Vec3<Real>& from, const Quat<Real>& axes, int i) const {
    return {from, rotate(axes, to_real<Real>(rays_[static_cast<std::size_t>(i)]))};
  }

  template <class Real>
  SKYBODY_INLINE Real to_ground(const Ray<Real>& ray) const {
    const Real most(max_range_.value());
    return ground_.value() ? min(obstacles::until_plane(ray), most) : most;
  }

  /// Adds noise to hits only; a ray without a hit reads exactly max_range.
  template <class Real>
  SKYBODY_INLINE void add_noise(const EnvView<Real>& env, const Values<Real>& output) const {
    const Real most(max_range_.value()), zero(0.0);
    Random<Real> draw = random(env);
    for (int i = 0; i < count(); i += 2) {
      Real errors[2];
      draw.normal_pair(errors[0], errors[1]);
      for (int k = 0; k < 2 && i + k < count(); ++k) {
        const Real range = output[i + k];
        const Real noisy = min(max(range + noise_(env) * errors[k], zero), most);
        output.set(i + k, select(range < most, noisy, range));
      }
    }
  }

  sensor::Mount mount_{this};
  BooleanParameter level_{
      this,
      boolean("level", false, "rays are level, as on a gimbal, and turn only with the heading")};
  IntegerParameter count_{
      this, integer("rays", "", 16, between(1, 360), "number of rays per ring, counter-clockwise")};
  RealParameter field_of_view_{this,
                               real("field_of_view", "rad", kTwoPi, between(0.0, kTwoPi),
                                    "angle from the first ray of a ring to the last, forward in "
                                    "the middle; 2 pi: all round, starting forward")};
  RealsParameter elevations_{this,
                             list("elevations", "rad", {0.0}, between(-0.5 * kPi, 0.5 * kPi),
                                  "elevation of each ring above the sensor's horizontal plane")};
  RealParameter max_range_{
      this, real("max_range", "m", 5.0, between(1e-3, 1e6), "reading of a ray without a hit")};
  RealParameter noise_{this, randomizable(real("noise", "m", 0.0, at_least(0.0),
                                               "standard deviation of each reading"))};
  BooleanParameter ground_{this, boolean("ground", true, "rays end at the plane z = 0 of W")};
  std::vector<Obstacle> obstacles_;
  std::vector<Vec3<double>> rays_;  ///< unit vectors, sensor axes
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::RangeFinder, "range_finder", "1.1.0",
               "Distances along rays to obstacles and ground, with noise and a sample rate.");
