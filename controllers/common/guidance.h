// Guidance: position and velocity errors to a desired acceleration, with limits. Shared by the
// controllers that follow positions, velocities and trajectories, with one set of parameters.
//
//   a = kp o (p_ref - p) - kd o (v - v_ref) + i,   di/dt = ki o e
// The horizontal part of a is limited in length, the vertical part up and down. The specific thrust
// is the limited acceleration minus gravity; max_acceleration_down keeps its z above 0.
// The integral i has its own limits. Anti-windup: it is held in directions in which the desired
// acceleration exceeds its limits.
#pragma once

#include <stdexcept>
#include <utility>
#include <vector>

#include "controllers/common/limit_report.h"
#include "controllers/common/vehicle.h"

namespace skybody::control {

/// Default limits [m/s^2].
struct AccelerationDefaults {
  double side = 4.0, up = 5.0, down = 4.0;
  bool by_thrust = false;  ///< limit defaults to those that 0.9 of full thrust can give
};

/// Defaults of trajectory-following controllers, which also add the reference's acceleration.
inline constexpr AccelerationDefaults kTrajectoryLimits{20.0, 12.0, 6.0, true};

/// Specific thrust at 0.9 of the rotors' full thrust [m/s^2]; infinite without rotors.
inline double usable_thrust(const Setup& setup, int robot) {
  const View<RotorInfo> rotors = setup.rotors_of(robot);
  double sum = 0.0;
  for (const RotorInfo& rotor : rotors) {
    sum += max(0.0, rotor.axis_in_base[2]) * full_thrust(rotor);
  }
  return rotors.size() > 0 ? 0.9 * sum / total_mass(setup, robot) : kInfinity;
}

/// Limits of the desired acceleration.
class AccelerationLimits {
 public:
  AccelerationLimits(Plugin* owner, const AccelerationDefaults& defaults)
      : side_(owner, real("max_acceleration_side", "m/s^2", defaults.side, at_least(1e-3),
                          "limit of the desired horizontal acceleration")),
        up_(owner, real("max_acceleration_up", "m/s^2", defaults.up, at_least(1e-3),
                        "limit of the desired upward acceleration")),
        down_(owner, real("max_acceleration_down", "m/s^2", defaults.down, at_least(1e-3),
                          "limit of the desired downward acceleration; at most 0.9 g, to which the "
                          "default is lowered")),
        by_thrust_(defaults.by_thrust) {}

  /// @throws std::runtime_error if the downward limit leaves no thrust for steering
  void configure(const Setup& setup) {
    gravity_ = gravity_of(setup);
    most_down_ = down_.is_given() ? down_.value() : min(down_.value(), 0.9 * gravity_);
    if (!(gravity_ > 0.0) || most_down_ > 0.9 * gravity_) {
      refuse("`max_acceleration_down` ", down_.value(),
             " would leave no thrust to steer with: at most 0.9 g = ", 0.9 * gravity_);
    }
    most_side_ = side_.value();
    most_up_ = up_.value();
    if (by_thrust_) keep_within_thrust(usable_thrust(setup, setup.robot()));
    // Below this square, the horizontal acceleration is within the limit in spite of rounding.
    surely_within_ = most_side_ * most_side_ * (1.0 - 1e-12);
  }

  double side() const { return most_side_; }
  double up() const { return most_up_; }
  double down() const { return most_down_; }
  double gravity() const { return gravity_; }

  /// Acceleration within its limits [m/s^2].
  template <class Real>
  SKYBODY_INLINE Vec3<Real> held(const Vec3<Real>& a) const {
    Vec3<Real> out{a.x, a.y, clamp(a.z, -most_down_, most_up_)};
    if (any(a.x * a.x + a.y * a.y > surely_within_)) {
      const Real size = norm(a.x, a.y), most(most_side_);
      const auto beyond = size > most;
      const Real scale = select(beyond, most / select(beyond, size, Real(1.0)), Real(1.0));
      out.x = a.x * scale;
      out.y = a.y * scale;
    }
    return out;
  }

  /// Specific thrust for an acceleration within the limits.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> thrust_for(const Vec3<Real>& a) const {
    return {a.x, a.y, a.z + gravity_};
  }

  /// The integral's next value. It is held where the desired acceleration exceeds its limits and
  /// the change would increase the excess.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> unwound(const Vec3<Real>& now, const Vec3<Real>& next,
                                    const Vec3<Real>& asked) const {
    const auto wide = norm(asked.x, asked.y) > most_side_;
    const Vec3<Real> change = next - now;
    const auto outwards = asked.x * change.x + asked.y * change.y > 0.0;
    const auto is_held = logical_and(wide, outwards);
    const auto above = logical_and(asked.z > most_up_, change.z > 0.0);
    const auto below = logical_and(asked.z < -most_down_, change.z < 0.0);
    return {select(is_held, now.x, next.x), select(is_held, now.y, next.y),
            select(logical_or(above, below), now.z, next.z)};
  }

 private:
  /// Lowers limits that the scenario does not give, so that thrust still holds the height.
  void keep_within_thrust(double thrust) {
    const double level = sqrt(max(0.0, thrust * thrust - gravity_ * gravity_));
    if (!side_.is_given()) most_side_ = max(kLeast, min(most_side_, level));
    if (!up_.is_given()) most_up_ = max(kLeast, min(most_up_, thrust - gravity_));
  }

  static constexpr double kLeast = 0.5;  ///< [m/s^2], for vehicles that can barely fly

  RealParameter side_, up_, down_;
  bool by_thrust_;
  double most_side_ = 0.0, most_up_ = 0.0, most_down_ = 0.0;
  double gravity_ = 0.0, surely_within_ = 0.0;
};

/// Limits of the desired acceleration, with the info `limited`.
class ReportedLimits : public AccelerationLimits {
 public:
  using AccelerationLimits::AccelerationLimits;

  /// @param word  index of the info in the controller's buffer
  void configure(const Setup& setup, int word = 0) {
    AccelerationLimits::configure(setup);
    report_.configure(setup, word);
    setup.buffer(word + 1);
  }
  /// A desired acceleration within its limits [m/s^2].
  template <class Real>
  SKYBODY_INLINE Vec3<Real> held(const Vec3<Real>& setpoint, Values<Real> buffer) const {
    const Vec3<Real> out = AccelerationLimits::held(setpoint);
    report_.note(differs(out, setpoint), buffer);
    return out;
  }
  /// The specific thrust for the limited acceleration [m/s^2]; its z stays positive.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> thrust(const Vec3<Real>& setpoint, Values<Real> buffer) const {
    return thrust_for(held(setpoint, buffer));
  }

 private:
  LimitReport report_;
};

/// Integral part of a controller. It uses state words only if one of its gains is above 0.
class Integral {
 public:
  /// @param unit, doc  of the parameter `ki`
  Integral(Plugin* owner, const char* unit, const char* doc)
      : ki_(owner, reals("ki", unit, {0.0, 0.0, 0.0}, at_least(0.0), doc)),
        most_(owner, real("max_integral", "m/s^2", 2.0, at_least(1e-3),
                          "limit of the integral term, each axis")) {}

  void configure(const Setup& setup) {
    const Vec3<double> k = ki_.vec3();
    is_on_ = k.x > 0.0 || k.y > 0.0 || k.z > 0.0;
    per_step_ = k * setup.dt();
  }
  /// Number of buffer words, from 0 on.
  int words() const { return is_on_ ? 3 : 0; }

  /// Adds the integral to an acceleration, then integrates this step's error.
  /// @param setpoint    acceleration without the integral, W axes [m/s^2]
  /// @param error   the integrand, W axes
  /// @param buffer  of words()
  template <class Real>
  SKYBODY_INLINE Vec3<Real> added(const Vec3<Real>& setpoint, const Vec3<Real>& error,
                                  const AccelerationLimits& limits, Values<Real> buffer) const {
    if (!is_on_) return setpoint;
    const Vec3<Real> now = buffer.vec3(0), asked = setpoint + now;
    const Vec3<Real> next = clamp_symmetric(now + multiply_elements(lift<Real>(per_step_), error),
                                            {most_.value(), most_.value(), most_.value()});
    buffer.set(0, limits.unwound(now, next, asked));
    return asked;
  }

 private:
  RealsParameter ki_;
  RealParameter most_;
  bool is_on_ = false;
  Vec3<double> per_step_{};
};

/// Gains on position and velocity.
class Guidance {
 public:
  Guidance(Plugin* owner, std::vector<double> kp, std::vector<double> kd,
           const AccelerationDefaults& limits)
      : kp_(owner, randomizable(reals("kp", "1/s^2", std::move(kp), at_least(0.0),
                                      "acceleration per position error, W axes"))),
        kd_(owner, randomizable(reals("kd", "1/s", std::move(kd), at_least(0.0),
                                      "acceleration per velocity error, W axes"))),
        integral_(owner, "1/s^3", "acceleration per integral of position error, W axes; 0: none"),
        limits_(owner, limits) {}

  /// @param share  factor on default gains, applied once per order (lag_share)
  void configure(const Setup& setup, double share = 1.0) {
    kp_share_ = kp_.is_given() ? 1.0 : share * share;
    kd_share_ = kd_.is_given() ? 1.0 : share;
    integral_.configure(setup);
    limits_.configure(setup, integral_.words());
  }

  const ReportedLimits& limits() const { return limits_; }

  /// Desired acceleration: feedback plus `forward`, before limits [m/s^2].
  /// @param offset   p_ref - p [m]
  /// @param excess   v - v_ref [m/s]
  /// @param forward  feed-forward, W axes [m/s^2]
  /// @param buffer   of the integral
  template <class Real>
  SKYBODY_INLINE Vec3<Real> setpoint(const EnvView<Real>& env, const Vec3<Real>& offset,
                                     const Vec3<Real>& excess, const Vec3<Real>& forward,
                                     Values<Real> buffer) const {
    return integral_.added(feedback(env, offset, excess) + forward, offset, limits_, buffer);
  }

  /// The same without feed-forward.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> setpoint(const EnvView<Real>& env, const Vec3<Real>& offset,
                                     const Vec3<Real>& excess, Values<Real> buffer) const {
    return integral_.added(feedback(env, offset, excess), offset, limits_, buffer);
  }

 private:
  template <class Real>
  SKYBODY_INLINE Vec3<Real> feedback(const EnvView<Real>& env, const Vec3<Real>& offset,
                                     const Vec3<Real>& excess) const {
    return multiply_elements(shared(kp_.vec3(env), kp_share_), offset) -
           multiply_elements(shared(kd_.vec3(env), kd_share_), excess);
  }

  RealsParameter kp_, kd_;
  Integral integral_;
  ReportedLimits limits_;
  double kp_share_ = 1.0, kd_share_ = 1.0;
};

}  // namespace skybody::control
