// Feasibility check: whether a vehicle can fly a reference, and the fastest feasible time scale.
//
// A reference is sampled over time. Each sample needs a thrust, an attitude, body rates and a
// torque (flatness.h), which must be within the vehicle's limits:
//   thrust   m |a + g e_z|           at most the total thrust of the rotors
//   fall     |a + g e_z|             at least kLeastShare of g: below it the attitude is undefined
//   tilt     angle of z of B to e_z  at most max_tilt
//   rates    of B, by axis           at most max_rate
//   torque   I dw/dt + w x I w       within the rotors' limits, in addition to the thrust
//   jumps    of the velocity at the reference's beginning and end: none
// The check uses nominal constants, the base's inertia, the whole robot's mass and still air. For
// robots whose rotors do not reach thrust and all torques, it covers thrust, fall, tilt and rates.
#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "controllers/common/allocated_rotors.h"
#include "controllers/common/flatness.h"
#include "plugins/api/reference_point.h"

namespace skybody::control {

/// A violated limit.
struct LimitViolation {
  std::string limit;        ///< name of the limit, such as "thrust"
  std::string unit;         ///< unit of the two values
  double time = 0.0;        ///< since the reset [s]
  double value = 0.0;       ///< value of the reference
  double allowed = 0.0;     ///< limit of the vehicle
  double excess = 0.0;      ///< relative excess over the limit
  std::string remedy = {};  ///< empty: fly slower
  bool is_least = false;    ///< `allowed` is a lower limit
};

/// Limits of a vehicle. Immutable after configure().
class FlightEnvelope {
 public:
  static constexpr double kLeastShare = 0.05;  ///< least thrust, as a share of g
  static constexpr double kTolerance = 1e-6;   ///< relative tolerance for rounding
  static constexpr double kLeastJump = 0.05;   ///< smallest velocity jump that counts [m/s]

  /// @param max_tilt  [rad]
  /// @param max_rate  [rad/s]
  void configure(const Setup& setup, int robot, double max_tilt, double max_rate) {
    const View<RotorInfo> rotors = working_rotors(setup, robot, "a reference that is checked");
    const BodyInfo& base = setup.bodies()[base_of(setup, robot)];
    mass_ = total_mass(setup, robot);
    gravity_ = gravity_of(setup);
    inertia_ = inertia_of(base);
    limits_ = limits_of(rotors, base);
    max_tilt_ = max_tilt;
    max_rate_ = max_rate;
    allocate(setup, robot, rotors, base);
  }

  /// The worst violation at one moment. For an upside-down or falling moment, the violation `fall`.
  std::optional<LimitViolation> breach(const ReferencePoint<double>& point, double time) const {
    Worst worst{time, {}};
    const SpecificThrust<double> u{point.acceleration + Vec3<double>{0.0, 0.0, gravity_},
                                   point.jerk, point.snap};
    const double size = norm(u.value);
    if (!(size >= kLeastShare * gravity_)) {
      worst.take("thrust", "N", mass_ * size, mass_ * kLeastShare * gravity_,
                 kLeastShare * gravity_ / max(size, 1e-9) - 1.0);
      if (worst.breach) worst.breach->is_least = true;
      return worst.breach;
    }
    const FlatMotion<double> flat = flat_motion(u, point.yaw, point.yaw_rate);
    worst.at_most("thrust", "N", mass_ * flat.thrust, limits_.thrust);
    worst.at_most("tilt", "rad", acos(clamp(u.value.z / size, -1.0, 1.0)), max_tilt_);
    worst.at_most("roll rate", "rad/s", abs(flat.rates.x), max_rate_);
    worst.at_most("pitch rate", "rad/s", abs(flat.rates.y), max_rate_);
    worst.at_most("yaw rate", "rad/s", abs(flat.rates.z), max_rate_);
    if (!worst.breach && !rotors_.empty()) check_rotors(flat, worst);
    return worst.breach;
  }

  /// Velocity jump, which no vehicle can follow. @param where  "start" or "end"
  static std::optional<LimitViolation> jump(const Vec3<double>& velocity, const std::string& where,
                                            double time) {
    const double speed = norm(velocity);
    if (!(speed > kLeastJump)) return std::nullopt;
    return LimitViolation{"jump of the velocity at the " + where,
                          "m/s",
                          time,
                          speed,
                          0.0,
                          speed / kLeastJump - 1.0,
                          where == "end" ? "let the path end at rest" : "add a `ramp`",
                          false};
  }

 private:
  struct Worst {
    double time;
    std::optional<LimitViolation> breach;

    void take(const char* limit, const char* unit, double value, double allowed, double excess) {
      if (!(excess > kTolerance) || (breach && breach->excess >= excess)) return;
      breach = LimitViolation{limit, unit, time, value, allowed, excess, "", false};
    }
    void at_most(const char* limit, const char* unit, double value, double allowed) {
      take(limit, unit, value, allowed, value / allowed - 1.0);
    }
  };

  /// Allocation needs at least four rotors, fixed to the base, that reach thrust and all torques.
  /// For other robots, torques are not checked.
  void allocate(const Setup& setup, int robot, const View<RotorInfo>& rotors,
                const BodyInfo& base) {
    for (const RotorInfo& rotor : rotors) {
      if (rotor.body != base_of(setup, robot)) return;
    }
    try {
      rotors_ = allocated_rotors(rotors, base, robot_name(setup, robot),
                                 "a reference that is checked", RotorSelection::kUseful);
    } catch (const std::runtime_error&) {
      return;
    }
  }

  /// Records the shares of thrust and torques that the rotors cannot give within their limits with
  /// allocation by priority.
  void check_rotors(const FlatMotion<double>& flat, Worst& worst) const {
    const Vec3<double> torque =
        inertia_ * flat.angular_acceleration + cross(flat.rates, inertia_ * flat.rates);
    const double thrust = mass_ * flat.thrust;
    const Priority::Shares<double> use = Priority(rotors_).fitting(thrust, torque);
    const double tilting = norm(torque.x, torque.y), turning = abs(torque.z);
    // Relative to the vehicle's limits, so that rounding errors are negligible.
    worst.take("torque about x and y beside the thrust", "N m", tilting, use.tilt * tilting,
               (1.0 - use.tilt) * tilting / min(limits_.torque.x, limits_.torque.y));
    worst.take("torque about z beside the thrust", "N m", turning, use.yaw * turning,
               (1.0 - use.yaw) * turning / limits_.torque.z);
    worst.take("thrust beside the torques", "N", thrust, use.thrust,
               abs(thrust - use.thrust) / limits_.thrust);
  }

  double mass_ = 0.0, gravity_ = 0.0, max_tilt_ = kPi, max_rate_ = kLargest;
  SymMat3<double> inertia_{};
  ThrustTorqueLimits limits_;
  std::vector<AllocatedRotor> rotors_;
};

/// Reference with adjustable pace: its points and its duration as functions of a time scale.
template <class Point, class Duration>
struct PacedReference {
  Point point;
  Duration duration;
  bool ends = false;  ///< it must end at rest
};
template <class Point, class Duration>
PacedReference(Point, Duration, bool) -> PacedReference<Point, Duration>;

/// The worst violation at a time scale, of 2000 samples.
template <class Reference>
std::optional<LimitViolation> worst_breach(const FlightEnvelope& envelope,
                                           const Reference& reference, double scale) {
  constexpr int kSamples = 2000;
  const double duration = reference.duration(scale);
  std::optional<LimitViolation> worst;
  const auto take = [&](const std::optional<LimitViolation>& breach) {
    // Of moments that differ by rounding, as on a circle, take the first.
    const double known = worst ? worst->excess * (1.0 + 1e-6) : 0.0;
    if (breach && (!worst || breach->excess > known)) worst = breach;
  };
  // At the end itself, rounding decides whether the velocity is before or after the jump to rest.
  const double last = duration * (1.0 - 1e-9);
  for (int k = 0; k <= kSamples; ++k) {
    const double time = last / kSamples * k;
    take(envelope.breach(reference.point(time, scale), time));
  }
  take(FlightEnvelope::jump(reference.point(0.0, scale).velocity, "start", 0.0));
  if (reference.ends) {
    take(FlightEnvelope::jump(reference.point(last, scale).velocity, "end", duration));
  }
  return worst;
}

/// The largest feasible time scale below `scale`, which is infeasible. Bisection to 0.1 %. Returns
/// 0 if no scale above a thousandth of `scale` is feasible.
template <class Reference>
double fastest_scale(const FlightEnvelope& envelope, const Reference& reference, double scale) {
  double low = 0.0, high = scale;
  for (double tried = 0.5 * scale; tried > 1e-3 * scale; tried *= 0.5) {
    if (!worst_breach(envelope, reference, tried)) {
      low = tried;
      break;
    }
    high = tried;
  }
  while (low > 0.0 && high - low > 1e-3 * low) {
    const double middle = 0.5 * (low + high);
    (worst_breach(envelope, reference, middle) ? high : low) = middle;
  }
  return low;
}

/// A time scale with four digits, rounded down: rounding to nearest could print an infeasible one.
inline std::string scale_text(double scale) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.4g", scale);
  if (std::strtod(digits, nullptr) > scale) {
    // Subtract one unit of the fourth digit.
    const double unit = std::pow(10.0, std::floor(std::log10(scale)) - 3.0);
    std::snprintf(digits, sizeof digits, "%.4g", std::strtod(digits, nullptr) - unit);
  }
  return digits;
}

/// Throws if the reference is infeasible. The message names the limit, time, excess and the fastest
/// feasible time scale. @throws std::runtime_error
template <class Reference>
void require_feasible(const FlightEnvelope& envelope, const Reference& reference, double scale) {
  const std::optional<LimitViolation> worst = worst_breach(envelope, reference, scale);
  if (!worst) return;
  const auto text = [](double value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.4g", value);
    return std::string(digits);
  };
  std::string remedy = worst->remedy + ", or take `check: false`";
  if (worst->remedy.empty()) {
    const double fastest = fastest_scale(envelope, reference, scale);
    remedy = fastest > 0.0 ? "the fastest `time_scale` that breaks no limit is " +
                                 scale_text(fastest) + ": take it or less, or `check: false`"
                           : "no `time_scale` is slow enough: change the path, add a `ramp`, or "
                             "take `check: false`";
  }
  const std::string has =
      worst->is_least ? "the least with which it keeps an attitude is " : "the vehicle has ";
  refuse("the reference cannot be flown: ", worst->limit, " at ", text(worst->time), " s takes ",
         text(worst->value), " ", worst->unit, ", ", has, text(worst->allowed), " ", worst->unit,
         "; ", remedy);
}

}  // namespace skybody::control
