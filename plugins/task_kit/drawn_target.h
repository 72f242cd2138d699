// A target given by the scenario, or drawn by the task from a box at every reset.
#pragma once

#include <skybody/plugin.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "plugins/task_kit/flight_limits.h"
#include "plugins/task_kit/spawn.h"

namespace skybody::task_kit {

/// A target point and the parameters `target`, `target_min` and `target_max`. Make it a member of
/// the task, among its parameters. The target is the value of the EnvParam `task.target`: a drawn
/// target is written there, and callers may set another one.
class DrawnTarget {
 public:
  /// Default values of the parameters, and their docs.
  struct Defaults {
    std::vector<double> target;  ///< x, y, z, W [m]; only shown in tables, never used in an episode
    std::vector<double> low;     ///< `target_min`, the lower corner of the box [m]
    std::vector<double> high;    ///< `target_max`, the upper corner of the box [m]
    const char* doc = "x, y, z (W); drawn for each episode if the scenario gives none";
    const char* low_doc = "lower corner of the box of drawn targets (W)";
    const char* high_doc = "upper corner of the box of drawn targets (W)";
  };

  DrawnTarget(Plugin* owner, const Defaults& defaults) : DrawnTarget(owner, defaults, "m") {}

  /// Call it in the task's configure(). Refuses a box whose lower corner is not the lower one, and
  /// a box together with a given target. Declares that the task writes `target`, if it draws it.
  void configure(const Setup& setup) {
    if (!is_drawn() && (low_.is_given() || high_.is_given())) {
      refuse_beside_target(low_.is_given() ? "target_min" : "target_max");
    }
    require_box(low_, high_, "target");
    announce_drawn(setup, target_);
  }
  /// Refuses a given target, or a box, with a coordinate beyond `bound` [m], where episodes end.
  void require_within(double bound) const {
    if (!is_drawn()) return task_kit::require_within(target_, "target", bound);
    task_kit::require_within(low_, "target_min", bound);
    task_kit::require_within(high_, "target_max", bound);
  }
  /// Refuses a given target, or a box, that reaches below `height_min` [m], where episodes end.
  void require_above(double height_min) const {
    task_kit::require_above(is_drawn() ? low_ : target_, is_drawn() ? "target_min" : "target",
                            height_min);
  }

  /// Whether the task draws the target; otherwise the scenario gives it.
  bool is_drawn() const { return !target_.is_given(); }

  /// Draws the target unless the scenario gives it. Call it in the task's randomize().
  template <class Real>
  SKYBODY_INLINE void randomize(Random<Real> draw, Start<Real>& start) const {
    if (is_drawn()) place(draw_point(draw), start);
  }
  /// Draws a point of the box [m]. Tasks that place the target elsewhere call it and place()
  /// instead of randomize(), if is_drawn().
  template <class Real>
  SKYBODY_INLINE Vec3<Real> draw_point(Random<Real>& draw) const {
    return draw_in_box(draw, low_, high_);
  }
  /// Writes the target of this episode, W [m].
  template <class Real>
  SKYBODY_INLINE void place(const Vec3<Real>& point, Start<Real>& start) const {
    start.params.set(target_.env_param(), point);
  }

  /// The target of this episode, W [m].
  template <class Real>
  SKYBODY_INLINE Vec3<Real> position(const EnvView<Real>& env) const {
    return target_.vec3(env);
  }

 protected:
  [[noreturn]] static void refuse_beside_target(const std::string& name) {
    refuse("`", name,
           "` says nothing beside `target`, which is not drawn: leave one of them out (`target: ~` "
           "removes what an included file gives)");
  }

  DrawnTarget(Plugin* owner, const Defaults& defaults, const char* unit)
      : target_(owner, {.name = "target",
                        .unit = unit,
                        .values = defaults.target,
                        .count = static_cast<int>(defaults.target.size()),
                        .doc = defaults.doc,
                        .randomizable = true}),
        low_(owner, reals("target_min", "m", defaults.low, kAny, defaults.low_doc)),
        high_(owner, reals("target_max", "m", defaults.high, kAny, defaults.high_doc)) {}

  RealsParameter target_, low_, high_;
};

/// A target with a heading, the fourth value of `target` [rad]. Drawn headings are uniform between
/// minus and plus the parameter `target_yaw`.
class DrawnPose : public DrawnTarget {
 public:
  DrawnPose(Plugin* owner, const Defaults& defaults, double yaw_max,
            const char* yaw_doc = "largest magnitude of a drawn heading")
      : DrawnTarget(owner, defaults, "m, rad"),
        yaw_max_(owner, real("target_yaw", "rad", yaw_max, between(0.0, kPi), yaw_doc)) {}

  /// As DrawnTarget::configure(); also refuses `target_yaw` together with a given target.
  void configure(const Setup& setup) {
    if (!is_drawn() && yaw_max_.is_given()) refuse_beside_target("target_yaw");
    DrawnTarget::configure(setup);
  }

  /// Draws point and heading unless the scenario gives them. Call it in the task's randomize().
  template <class Real>
  SKYBODY_INLINE void randomize(Random<Real> draw, Start<Real>& start) const {
    if (!is_drawn()) return;
    place(draw_point(draw), start);
    const Real limit(yaw_max_.value());
    start.params.set(target_.env_param() + 3, draw.uniform(-limit, limit));
  }

  /// The target's heading in this episode [rad].
  template <class Real>
  SKYBODY_INLINE Real yaw(const EnvView<Real>& env) const {
    return target_(env, 3);
  }

 private:
  RealParameter yaw_max_;
};

}  // namespace skybody::task_kit
