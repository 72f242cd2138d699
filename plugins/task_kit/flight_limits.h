// Flight limits: tilt, heading, and a box about the origin. A flight that exceeds one has failed.
#pragma once

#include <skybody/plugin.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "plugins/task_kit/verdict.h"

namespace skybody::task_kit {

/// Cosine of the largest tilt [rad]; -2, which no cosine reaches, if every tilt is allowed.
inline double tilt_cosine_limit(double tilt_max) { return tilt_max < kPi ? cos(tilt_max) : -2.0; }

/// Refuses a point beyond the bound, such as a target.
/// The message has the point's name.
/// @param place  x, y, z, W [m]; further values are ignored
inline void require_within(const RealsParameter& place, const std::string& what, double bound) {
  for (int k = 0; k < 3; ++k) {
    if (std::abs(place.value(k)) <= bound) continue;
    refuse("`", what, "[", k, "]` ", place.value(k), " lies beyond `bound` ", bound,
           ", where an episode ends: raise that, or bring it nearer");
  }
}
/// The same for a point that is not a parameter.
inline void require_within(const Vec3<double>& place, const std::string& what, double bound) {
  const double coordinates[] = {place.x, place.y, place.z};
  for (int k = 0; k < 3; ++k) {
    if (std::abs(coordinates[k]) <= bound) continue;
    refuse(what, " lies beyond `bound` ", bound, ", at ", "xyz"[k], " = ", coordinates[k],
           " m, where an episode ends: raise that, or bring it nearer");
  }
}
/// Refuses a point below the height [m] at which an episode ends.
/// The message has the point's name.
/// @param place  x, y, z, W [m]; further values are ignored
inline void require_above(const RealsParameter& place, const std::string& what, double height_min) {
  if (place.value(2) >= height_min) return;
  refuse("`", what, "[2]` ", place.value(2), " lies below `height_min` ", height_min,
         ", where an episode ends: lower that, or lift the target");
}

/// The limits that are exceeded.
template <class Real>
struct PassedLimits {
  MaskOf<Real> tilt{false};     ///< beyond `tilt_max`
  MaskOf<Real> heading{false};  ///< beyond `yaw_max`
  MaskOf<Real> bound{false};    ///< a coordinate beyond `bound`

  /// Whether any limit is exceeded.
  SKYBODY_INLINE MaskOf<Real> any() const { return logical_or(logical_or(tilt, heading), bound); }
  /// Adds those of another robot.
  SKYBODY_INLINE void add(const PassedLimits& other) {
    tilt = logical_or(tilt, other.tilt);
    heading = logical_or(heading, other.heading);
    bound = logical_or(bound, other.bound);
  }
};

/// The limits and their parameters `tilt_max`, `yaw_max` and `bound`. Make it a member of a task,
/// among its parameters.
class FlightLimits {
 public:
  /// Default values: `tilt_max` and `yaw_max` [rad], `bound` [m].
  struct Defaults {
    double tilt_max = 1.57;  ///< [rad]
    double yaw_max = 1.57;   ///< [rad]; 4: every heading is allowed
    double bound = 7.0;      ///< [m]
  };

  explicit FlightLimits(Plugin* owner) : FlightLimits(owner, Defaults()) {}
  FlightLimits(Plugin* owner, const Defaults& defaults) : owner_(owner), defaults_(defaults) {}

  /// Declares the infos of the failures: failed.tilt, failed.heading, failed.bound.
  void configure(const Setup& setup, InfoParts& infos) {
    tilt_cosine_ = tilt_cosine_limit(tilt_max_.value());
    tilt_failure_ = declare_failure(setup, infos, "tilt", "tilt beyond `tilt_max`");
    heading_failure_ = declare_failure(setup, infos, "heading", "heading beyond `yaw_max`");
    bound_failure_ = declare_failure(setup, infos, "bound", "a coordinate beyond `bound`");
  }

  double bound() const { return bound_.value(); }  ///< of each coordinate's magnitude [m]

  /// The limits that a body exceeds.
  /// @param heading  the angle that `yaw_max` limits in either direction [rad]
  template <class Real>
  SKYBODY_INLINE PassedLimits<Real> passed(const BodyMotion<Real>& body,
                                           const Real& heading) const {
    const Vec3<Real>& p = body.position;
    const Real farthest = max(max(abs(p.x), abs(p.y)), abs(p.z));
    return {tilt_cosine(body.rotation) < tilt_cosine_, abs(heading) > yaw_max_.value(),
            farthest > bound_.value()};
  }
  /// The same with the body's yaw in W.
  template <class Real>
  SKYBODY_INLINE PassedLimits<Real> passed(const BodyMotion<Real>& body) const {
    return passed(body, yaw(body.rotation));
  }

  /// Reports exceeded limits to the verdict, each under its name.
  template <class Real>
  SKYBODY_INLINE void judge(Verdict<Real>& verdict, const PassedLimits<Real>& passed) const {
    verdict.fail(tilt_failure_, passed.tilt);
    verdict.fail(heading_failure_, passed.heading);
    verdict.fail(bound_failure_, passed.bound);
  }

 private:
  Plugin* owner_;
  Defaults defaults_;
  RealParameter tilt_max_{owner_, real("tilt_max", "rad", defaults_.tilt_max, between(0.0, kPi),
                                       "a robot fails beyond this tilt")};
  RealParameter yaw_max_{owner_, real("yaw_max", "rad", defaults_.yaw_max, between(0.0, 4.0),
                                      "a robot fails beyond this heading, in magnitude")};
  RealParameter bound_{owner_, real("bound", "m", defaults_.bound, at_least(1e-3),
                                    "a robot fails if a coordinate's magnitude exceeds this (W)")};

  double tilt_cosine_ = -2.0;
  Part tilt_failure_, heading_failure_, bound_failure_;
};

}  // namespace skybody::task_kit
