// Limits of a flight with a common load: failures that end it.
#pragma once

#include <skybody/task_kit.h>

namespace skybody {

/// Limits violated by the load or by any robot.
template <class Real>
struct PassedByTeam {
  MaskOf<Real> tilt{false}, load_tilt{false}, bound{false}, separation{false}, dropped{false};

  SKYBODY_INLINE MaskOf<Real> any() const {
    return logical_or(logical_or(logical_or(tilt, load_tilt), logical_or(bound, separation)),
                      dropped);
  }
  SKYBODY_INLINE void add(const PassedByTeam& other) {
    tilt = logical_or(tilt, other.tilt);
    load_tilt = logical_or(load_tilt, other.load_tilt);
    bound = logical_or(bound, other.bound);
    separation = logical_or(separation, other.separation);
    dropped = logical_or(dropped, other.dropped);
  }
};

/// The limits and their parameters; a member of the task.
class CarriedLimits {
 public:
  explicit CarriedLimits(Plugin* owner) : owner_(owner) {}

  /// Declares the infos about failures.
  void configure(const Setup& setup, task_kit::InfoParts& infos) {
    using task_kit::declare_failure;
    tilt_cosine_ = task_kit::tilt_cosine_limit(tilt_max_.value());
    load_tilt_cosine_ = task_kit::tilt_cosine_limit(load_tilt_max_.value());
    tilt_ = declare_failure(setup, infos, "tilt", "a robot beyond `tilt_max`");
    load_tilt_ = declare_failure(setup, infos, "load_tilt", "the load beyond `load_tilt_max`");
    bound_ = declare_failure(setup, infos, "bound",
                             "a coordinate of a robot or of the load beyond `bound`");
    separation_ =
        declare_failure(setup, infos, "separation", "two robots closer than `separation_min`");
    dropped_ = declare_failure(setup, infos, "dropped", "the load below `height_min`");
  }

  double bound() const {
    return bound_max_.value();
  }                                                          ///< limit of each coordinate's
                                                             ///< magnitude [m]
  double height_min() const { return height_min_.value(); }  ///< least height of the load [m]

  template <class Real>
  SKYBODY_INLINE PassedByTeam<Real> by_load(const BodyMotion<Real>& load) const {
    PassedByTeam<Real> passed;
    passed.load_tilt = tilt_cosine(load.rotation) < load_tilt_cosine_;
    passed.bound = beyond_bound(load.position);
    passed.dropped = load.position.z < height_min_.value();
    return passed;
  }
  /// @param nearest  distance of its nearest neighbour [m]
  template <class Real>
  SKYBODY_INLINE PassedByTeam<Real> by_robot(const BodyMotion<Real>& robot,
                                             const Real& nearest) const {
    PassedByTeam<Real> passed;
    passed.tilt = tilt_cosine(robot.rotation) < tilt_cosine_;
    passed.bound = beyond_bound(robot.position);
    passed.separation = nearest < separation_min_.value();
    return passed;
  }

  template <class Real>
  SKYBODY_INLINE void judge(task_kit::Verdict<Real>& verdict,
                            const PassedByTeam<Real>& passed) const {
    verdict.fail(tilt_, passed.tilt);
    verdict.fail(load_tilt_, passed.load_tilt);
    verdict.fail(bound_, passed.bound);
    verdict.fail(separation_, passed.separation);
    verdict.fail(dropped_, passed.dropped);
  }

 private:
  template <class Real>
  SKYBODY_INLINE MaskOf<Real> beyond_bound(const Vec3<Real>& p) const {
    return max(max(abs(p.x), abs(p.y)), abs(p.z)) > bound_max_.value();
  }

  Plugin* owner_;
  RealParameter tilt_max_{owner_, real("tilt_max", "rad", 1.4, between(0.0, kPi),
                                       "the team fails if a robot tilts more; pi: never")};
  RealParameter load_tilt_max_{owner_, real("load_tilt_max", "rad", 1.0, between(0.0, kPi),
                                            "the team fails if the load tilts more; pi: never")};
  RealParameter bound_max_{owner_, real("bound", "m", 10.0, at_least(1e-3),
                                        "the team fails if a coordinate of a robot or of the load "
                                        "exceeds this in magnitude (W)")};
  RealParameter separation_min_{owner_, real("separation_min", "m", 0.5, at_least(0.0),
                                             "the team fails if two robots are closer; 0: never")};
  RealParameter height_min_{
      owner_, real("height_min", "m", 0.3, kAny,
                   "the team fails if the load is lower (W z), because it was dropped")};

  double tilt_cosine_ = -2.0, load_tilt_cosine_ = -2.0;
  task_kit::Part tilt_, load_tilt_, bound_, separation_, dropped_;
};

}  // namespace skybody
