// Range finder on any link: distance along rays to the nearest obstacle or the ground, with noise
// and rate.
#include <skybody/plugin.h>

#include <vector>

#include "plugins/obstacles/ray.h"

namespace skybody {
namespace {

using obstacles::Obstacle;
using obstacles::PlacedObstacle;
using obstacles::Ray;

class RangeFinder : public Sensor {
 public:
  void configure(const Setup& setup) override {
    const int robot = setup.robot(robot_.value());
    std::string name = link_.value();
    if (name.empty()) name = setup.bodies()[setup.robots()[robot].first_body].name;
    const LinkInfo& link = setup.link(robot, name);
    const Quat<double> frame{link.rotation[0], link.rotation[1], link.rotation[2],
                             link.rotation[3]};
    body_ = link.body;
    point_ = Vec3<double>{link.position[0], link.position[1], link.position[2]} +
             rotate(frame, position_.vec3());
    mount_ = frame * from_rpy(orientation_.value(0), orientation_.value(1), orientation_.value(2));
    obstacles_ = obstacles::find(setup, "sensor `range_finder`");
    add_rays();
    setup.period(static_cast<int>(period_.value()));
    if (period_.value() == 1) setup.only_when_read();
    setup.channel("range", "m", static_cast<int>(rays_.size()), 0.0, max_range_.value(), robot);
  }

  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>&, Values<Real> output) const {
    const Vec3<Real> from = origin(env);
    const Quat<Real> axes = axes_of(env);
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

 private:
  int count() const { return static_cast<int>(rays_.size()); }

  /// Rings in the order of `elevations`, each with its rays counter-clockwise.
  void add_rays() {
    const int around = static_cast<int>(count_.value());
    const double field = field_of_view_.value();
    const bool is_ring = field >= kTwoPi;  // the last ray would coincide with the first
    const int gaps = is_ring ? around : around - 1;
    if (elevations_.count() == 0) {
      throw std::runtime_error("`elevations` is empty: give one or more, such as [0]");
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

  template <class Real>
  SKYBODY_INLINE Vec3<Real> origin(const EnvView<Real>& env) const {
    const BodyMotion<Real> body = env.body(body_);
    return body.position + rotate(body.rotation, to_real<Real>(point_));
  }

  /// W from the rays' axes.
  template <class Real>
  SKYBODY_INLINE Quat<Real> axes_of(const EnvView<Real>& env) const {
    const Quat<Real> axes = env.body(body_).rotation * to_real<Real>(mount_);
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

  TextParameter robot_{
      this, {.name = "robot", .doc = "robot with the link; optional for a single robot"}};
  TextParameter link_{this, {.name = "link", .doc = "link of the sensor; empty: the base"}};
  RealsParameter position_{this,
                           {.name = "position",
                            .unit = "m",
                            .values = {0.0, 0.0, 0.0},
                            .doc = "position of the sensor in the link's frame"}};
  RealsParameter orientation_{
      this,
      {.name = "orientation",
       .unit = "rad",
       .values = {0.0, 0.0, 0.0},
       .doc = "roll, pitch, yaw of the sensor's axes in the link's frame; x is forward"}};
  BooleanParameter level_{
      this,
      {.name = "level",
       .value = false,
       .doc = "rays are level, as on a gimbal, and turn only with the heading"}};
  IntegerParameter count_{this,
                          {.name = "rays",
                           .value = 16,
                           .min = 1,
                           .max = 360,
                           .doc = "number of rays per ring, counter-clockwise"}};
  RealParameter field_of_view_{this,
                               {.name = "field_of_view",
                                .unit = "rad",
                                .value = kTwoPi,
                                .min = 0.0,
                                .max = kTwoPi,
                                .doc = "angle from the first ray of a ring to the last, forward in "
                                       "the middle; 2 pi: all round, starting forward"}};
  RealsParameter elevations_{this,
                             {.name = "elevations",
                              .unit = "rad",
                              .values = {0.0},
                              .count = -1,
                              .min = -0.5 * kPi,
                              .max = 0.5 * kPi,
                              .doc = "elevation of each ring above the sensor's horizontal plane"}};
  RealParameter max_range_{this,
                           {.name = "max_range",
                            .unit = "m",
                            .value = 5.0,
                            .min = 1e-3,
                            .max = 1e6,
                            .doc = "reading of a ray without a hit"}};
  RealParameter noise_{this,
                       {.name = "noise",
                        .unit = "m",
                        .value = 0.0,
                        .min = 0.0,
                        .doc = "standard deviation of each reading",
                        .randomizable = true}};
  BooleanParameter ground_{
      this, {.name = "ground", .value = true, .doc = "rays end at the plane z = 0 of W"}};
  IntegerParameter period_{this,
                           {.name = "period",
                            .unit = "physics steps",
                            .value = 1,
                            .min = 1,
                            .max = 1000000,
                            .doc = "interval of readings"}};

  std::vector<Obstacle> obstacles_;
  std::vector<Vec3<double>> rays_;  ///< unit vectors, sensor axes
  Vec3<double> point_{};            ///< position of the sensor, in the body's frame [m]
  Quat<double> mount_{1.0, 0.0, 0.0, 0.0};
  int body_ = 0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::RangeFinder, "range_finder", "1.0.0",
               "Distances along rays to obstacles and ground, with noise and a sample rate.");
