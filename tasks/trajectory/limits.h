// Failure limits of a flight along a path: the box, the tilt and the rates of the reference's task.
#pragma once

#include <skybody/task_kit.h>

#include "plugins/reference/path_start.h"

namespace skybody::tracking {

using namespace task_kit;

/// The limits and their parameters: a member of the task.
class PathLimits {
 public:
  explicit PathLimits(Plugin* owner) : owner_(owner) {}

  /// Declares the infos about failures.
  void configure(const Setup& setup, InfoParts& infos) {
    tilt_cosine_ = tilt_cosine_limit(tilt_max_.value());
    side_failure_ = declare_failure(setup, infos, "side", "|x| or |y| beyond `side_max`");
    height_failure_ =
        declare_failure(setup, infos, "height", "z below `height_min` or above `height_max`");
    tilt_failure_ = declare_failure(setup, infos, "tilt", "tilt beyond `tilt_max`");
    rate_failure_ = declare_failure(setup, infos, "rate", "angular velocity beyond `rate_max`");
  }

  template <class Real>
  SKYBODY_INLINE void judge(Verdict<Real>& verdict, const BodyMotion<Real>& body) const {
    const Vec3<Real>& p = body.position;
    verdict.fail(side_failure_, max(abs(p.x), abs(p.y)) > side_max_.value());
    verdict.fail(height_failure_, logical_or(p.z<height_min_.value(), p.z> height_max_.value()));
    verdict.fail(tilt_failure_, tilt_cosine(body.rotation) < tilt_cosine_);
    verdict.fail(rate_failure_,
                 squared_norm(body.angular_velocity) > rate_max_.value() * rate_max_.value());
  }

  /// Rejects a box whose minimum is above its maximum, and a nominal path that leaves the box
  /// within an episode.
  void require_within(const reference::PathNumbers<double>& numbers, reference::Path path,
                      double duration) const {
    if (!(height_min_.value() < height_max_.value())) {
      refuse("`height_min` ", height_min_.value(), " is not below `height_max` ",
             height_max_.value(), ": let heights lie between");
    }
    constexpr int kSamples = 1024;
    path.approach = 0.0;  // the approach's start is random
    const double length = path.length(numbers);
    const double end = duration > 0.0 && duration < length ? duration : length;
    for (int i = 0; i <= kSamples; ++i) {
      const double time = end * i / kSamples;
      const Vec3<double> r = reference::derivative(path.at<1>(numbers, time).point, 0);
      require_inside("x", r.x, -side_max_.value(), side_max_.value(), time);
      require_inside("y", r.y, -side_max_.value(), side_max_.value(), time);
      require_inside("z", r.z, height_min_.value(), height_max_.value(), time);
    }
  }

 private:
  static void require_inside(const char* axis, double value, double low, double high, double time) {
    if (value >= low && value <= high) return;
    refuse("the path leads to ", axis, " = ", value, " m after ", time, " s, and beyond ",
           value < low ? low : high,
           " m an episode has failed: move the path, or widen `side_max`, `height_min` or "
           "`height_max`");
  }

  Plugin* owner_;
  RealParameter side_max_{owner_, real("side_max", "m", 9.0, at_least(1e-3),
                                       "a robot fails if |x| or |y| exceeds this (W)")};
  RealParameter height_min_{owner_,
                            real("height_min", "m", 0.1, kAny, "a robot fails below this height")};
  RealParameter height_max_{owner_,
                            real("height_max", "m", 10.0, kAny, "a robot fails above this height")};
  RealParameter tilt_max_{owner_, real("tilt_max", "rad", 157.5 * kPi / 180.0, between(0.0, kPi),
                                       "a robot fails beyond this tilt")};
  RealParameter rate_max_{owner_, real("rate_max", "rad/s", 10.0, at_least(1e-3),
                                       "a robot fails if it rotates faster than this")};

  double tilt_cosine_ = -2.0;
  Part side_failure_, height_failure_, tilt_failure_, rate_failure_;
};

}  // namespace skybody::tracking
