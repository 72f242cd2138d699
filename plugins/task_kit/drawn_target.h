// A target that is drawn in a box for each episode, unless the scenario gives it.
#pragma once

#include <skybody/plugin.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "plugins/task_kit/flight_limits.h"
#include "plugins/task_kit/spawn.h"

namespace skybody::task_kit {

/// A point and its parameters `target`, `target_min`, `target_max`: a member of a task, among its
/// parameters.
class DrawnTarget {
 public:
  /// What holds where a scenario says nothing: `target`, `low` and `high` [m], `doc` of `target`.
  struct Defaults {
    std::vector<double> target;  ///< x, y, z, W [m]; for a table, since an episode has a drawn one
    std::vector<double> low;     ///< lower corner of the box [m]
    std::vector<double> high;    ///< upper corner of the box [m]
    const char* doc = "x, y, z (W); where the scenario gives none, one is drawn for each episode";
  };

  DrawnTarget(Plugin* owner, const Defaults& defaults) : DrawnTarget(owner, defaults, "m") {}

  /// Refuses a box that is upside down, or beside a target that is given, and announces what
  /// randomize() draws.
  void configure(const Setup& setup) {
    if (!is_drawn() && (low_.is_given() || high_.is_given())) {
      throw std::runtime_error(std::string("`") + (low_.is_given() ? "target_min" : "target_max") +
                               "` says nothing beside `target`, which is not drawn: leave one of "
                               "them out (`target: ~` removes what an included file gives)");
    }
    require_box(low_, high_, "target");
    announce_drawn(setup, target_);
  }
  /// Refuses targets beyond the bound [m] where an episode ends.
  void require_within(double bound) const {
    if (!is_drawn()) return task_kit::require_within(target_, "target", bound);
    task_kit::require_within(low_, "target_min", bound);
    task_kit::require_within(high_, "target_max", bound);
  }
  /// Refuses targets below the height [m] where an episode ends.
  void require_above(double height_min) const {
    task_kit::require_above(is_drawn() ? low_ : target_, is_drawn() ? "target_min" : "target",
                            height_min);
  }

  bool is_drawn() const { return !target_.is_given(); }  ///< false: the scenario gives it

  /// What the task's randomize() does.
  template <class Real>
  SKYBODY_INLINE void randomize(Random<Real> draw, Start<Real>& start) const {
    if (is_drawn()) place(draw_point(draw), start);
  }
  /// For tasks that change what is drawn: a point of the box [m], ...
  template <class Real>
  SKYBODY_INLINE Vec3<Real> draw_point(Random<Real>& draw) const {
    return draw_in_box(draw, low_, high_);
  }
  /// ... and where the target is to be (W) [m], if it is drawn.
  template <class Real>
  SKYBODY_INLINE void place(const Vec3<Real>& point, Start<Real>& start) const {
    start.params.set(target_.env_param(), point);
  }

  /// Where it is in this episode, W [m].
  template <class Real>
  SKYBODY_INLINE Vec3<Real> position(const EnvView<Real>& env) const {
    return target_.vec3(env);
  }

 protected:
  DrawnTarget(Plugin* owner, const Defaults& defaults, const char* unit)
      : target_(owner, {.name = "target",
                        .unit = unit,
                        .values = defaults.target,
                        .count = static_cast<int>(defaults.target.size()),
                        .doc = defaults.doc,
                        .randomizable = true}),
        low_(owner, {.name = "target_min",
                     .unit = "m",
                     .values = defaults.low,
                     .doc = "lower corner of the box of drawn targets (W)"}),
        high_(owner, {.name = "target_max",
                      .unit = "m",
                      .values = defaults.high,
                      .doc = "upper corner of the box of drawn targets (W)"}) {}

  RealsParameter target_, low_, high_;
};

/// The same with a heading, the fourth value of `target`, and a parameter `target_yaw`.
class DrawnPose : public DrawnTarget {
 public:
  DrawnPose(Plugin* owner, const Defaults& defaults, double yaw_max,
            const char* yaw_doc = "largest magnitude of a drawn heading")
      : DrawnTarget(owner, defaults, "m, rad"),
        yaw_max_(owner, {.name = "target_yaw",
                         .unit = "rad",
                         .value = yaw_max,
                         .min = 0.0,
                         .max = kPi,
                         .doc = yaw_doc}) {}

  /// What the task's randomize() does.
  template <class Real>
  SKYBODY_INLINE void randomize(Random<Real> draw, Start<Real>& start) const {
    if (!is_drawn()) return;
    place(draw_point(draw), start);
    const Real limit(yaw_max_.value());
    start.params.set(target_.env_param() + 3, draw.uniform(-limit, limit));
  }

  /// Its heading in this episode [rad].
  template <class Real>
  SKYBODY_INLINE Real yaw(const EnvView<Real>& env) const {
    return target_(env, 3);
  }

 private:
  RealParameter yaw_max_;
};

}  // namespace skybody::task_kit
