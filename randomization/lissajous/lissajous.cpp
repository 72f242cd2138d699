// The paper's family of Lissajous figures: draws all path parameters of a controller `reference` or
// a task together, and optionally places a robot near the figure's beginning.
#include <skybody/plugin.h>

#include <stdexcept>
#include <vector>

#include "randomization/common/schedule.h"

namespace skybody {
namespace {

using randomization::Schedule;

class LissajousFamily : public Randomizer {
 public:
  template <class Real>
  struct State {
    Schedule<Real> schedule;
  };

  void configure(const Setup& setup) override {
    amplitude_ = announce(setup, "amplitude");
    centre_ = announce(setup, "centre[2]");
    middle_ = setup.find_params(reference_.value() + ".centre")[0];
    cycles_ = announce(setup, "cycles");
    phase_ = announce(setup, "phase[0]");
    speed_ = announce(setup, "peak_speed");
    along_ = announce(setup, "along");
    if (!robot_.value().empty()) {
      const int robot = setup.robot(robot_.value());
      require_free(setup.robots()[robot]);
      start_ = announce_all(setup, "robots." + robot_.value() + ".start.position");
    } else if (start_within_.is_given()) {
      refuse("`start_within` is given without `robot`: say who starts there");
    }
    require_order(side_, "amplitude_side");
    require_order(height_swing_, "amplitude_height");
    if (side_.value(1) <= 0.0 && height_swing_.value(1) <= 0.0) {
      refuse(
          "`amplitude_side` and `amplitude_height` are 0, so that no figure has a length: raise "
          "one, or leave this randomizer out and take `kind: hold`");
    }
    require_order(height_, "height");
    require_order(phases_, "phase");
    require_order(speeds_, "peak_speed");
    if (ratios_.count() % 3 != 0 || ratios_.count() == 0) {
      refuse("`ratios` has ", ratios_.count(),
             " values; allowed: three for each ratio, such as 2, 1, 1");
    }
    for (int k = 0; k < ratios_.count(); k += 3) {
      if (ratios_.value(k) != 0.0 || ratios_.value(k + 1) != 0.0 || ratios_.value(k + 2) != 0.0) {
        continue;
      }
      refuse("`ratios` has 0, 0, 0, by which nothing swings: leave these out");
    }
  }

  template <class Real>
  void randomize(const EnvView<Real>& env, State<Real>& state, Start<Real>& start) const {
    const auto due = randomization::is_due(state.schedule, start.requested);
    Random<Real> draw = random(env);
    const auto within = [&](const RealsParameter& range) {
      return draw.uniform(Real(range.value(0)), Real(range.value(1)));
    };
    const auto put = [&](int param, const Real& value) {
      randomization::put(start, param, due, value);
    };
    put(amplitude_, within(side_));
    put(amplitude_ + 1, within(side_));
    put(amplitude_ + 2, within(height_swing_));
    put(centre_, within(height_));
    put(phase_, within(phases_));
    put(speed_, within(speeds_));
    const int count = ratios_.count() / 3;
    const Real picked = draw.uniform(Real(0.0), Real(static_cast<double>(count)));
    for (int axis = 0; axis < 3; ++axis) {
      Real cycles(ratios_.value(axis));
      for (int k = 1; k < count; ++k) {
        cycles =
            select(picked >= static_cast<double>(k), Real(ratios_.value(3 * k + axis)), cycles);
      }
      put(cycles_ + axis, cycles);
    }
    const auto looks_ahead = draw.uniform(Real(0.0), Real(1.0)) < along_share_.value();
    put(along_, select(looks_ahead, Real(1.0), Real(0.0)));
    if (start_ >= 0) place(draw, start);
    randomization::count_reset(state.schedule, start.requested, every_.value());
  }

 private:
  /// The first EnvParam of a parameter.
  int announce(const Setup& setup, const std::string& name) const {
    return announce_all(setup, reference_.value() + "." + name);
  }
  static int announce_all(const Setup& setup, const std::string& path) {
    const std::vector<int> params = setup.find_params(path);
    for (const int param : params) setup.writes(param);
    return params[0];
  }

  static void require_free(const RobotInfo& robot) {
    if (robot.fixed_base == 0) return;
    refuse("robot `", robot.name,
           "` has a fixed base, which cannot start elsewhere: leave `robot` out");
  }

  /// Places the robot near the figure's beginning, in every episode: the figure may last for
  /// several.
  template <class Real>
  SKYBODY_INLINE void place(Random<Real>& draw, Start<Real>& start) const {
    for (int axis = 0; axis < 3; ++axis) {
      const Real angle = start.params[phase_ + axis];
      const Real beginning =
          start.params[middle_ + axis] + start.params[amplitude_ + axis] * sincos(angle).sin;
      const Real most(start_within_.value(axis));
      start.params.set(start_ + axis, beginning + draw.uniform(-most, most));
    }
  }

  static void require_order(const RealsParameter& range, const std::string& name) {
    if (range.value(0) <= range.value(1)) return;
    refuse("`", name, "` is ", range.value(0), " to ", range.value(1), ": swap them");
  }

  TextParameter reference_{
      this,
      word("reference", "robot.controllers.reference",
           "path of a controller `reference`, or `task`, of kind lissajous with `yaw: drawn`")};
  RealsParameter side_{this, reals("amplitude_side", "m", {1.35, 1.75}, at_least(0.0),
                                   "smallest and largest amplitude along x, and along y")};
  RealsParameter height_swing_{
      this, reals("amplitude_height", "m", {0.3, 0.4}, at_least(0.0), "the same along z")};
  RealsParameter height_{this, reals("height", "m", {0.7, 1.0}, kAny,
                                     "smallest and largest height of the figure's centre")};
  RealsParameter phases_{
      this, reals("phase", "rad", {70.0 * kPi / 180.0, 110.0 * kPi / 180.0}, between(-1e3, 1e3),
                  "smallest and largest phase lead of x over y")};
  RealsParameter speeds_{this, reals("peak_speed", "m/s", {1.0, 1.5}, between(1e-3, 1e3),
                                     "smallest and largest peak speed on the figure")};
  RealsParameter ratios_{
      this, list("ratios", "", {1, 1, 1, 2, 2, 1, 1, 1, 2, 2, 1, 1, 1, 2, 1}, between(0.0, 16.0),
                 "cycles of x, y, z, three for each figure; equally likely")};
  RealParameter along_share_{
      this, real("along", "", 0.5, between(0.0, 1.0),
                 "share of the episodes with the heading along the path; else it is fixed")};
  IntegerParameter every_{this, randomization::every_spec()};
  TextParameter robot_{
      this,
      word("robot", "", "robot that starts near the figure's beginning; empty: none is moved")};
  RealsParameter start_within_{
      this, reals("start_within", "m", {0.5, 0.5, 0.25}, at_least(0.0),
                  "largest distance of `robot` from the figure's beginning, along each axis of W")};

  int amplitude_ = 0, centre_ = 0, cycles_ = 0, phase_ = 0, speed_ = 0, along_ = 0;
  int middle_ = 0;  ///< centre[0]
  int start_ = -1;  ///< of the robot's position at a reset; -1: no robot is moved
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::LissajousFamily, "lissajous", "1.0.0",
               "Draws the paper's family of Lissajous references: size, shape, speed and heading.");
