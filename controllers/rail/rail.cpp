// Rail: moves a robot's base along a path over time, without an input.
#include <vector>

#include "controllers/common/robot.h"

namespace skybody {
namespace {

class Rail : public Controller {
 public:
  static constexpr bool kSmooth = true;

  template <class Real>
  struct State {
    Vec3<Real> position;  ///< of the base at the reset, W [m]
    Quat<Real> rotation;
  };

  void configure(const Setup& setup) override {
    control::require_floating_base(setup, setup.robot(), "`rail` cannot move");
    base_ = control::base_of(setup, setup.robot());
    dt_ = setup.dt();
    check_times();
    check_count("positions", positions_.count(), false);
    check_count("rpy", rpy_.count(), true);
    read_stations();
    check_start();
    if (repeat_.value()) check_loop();
    setup.input(Signal::kNone, {}, {});
    setup.output(Signal::kPose, 7);
  }

  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state) const {
    const BodyMotion<Real> base = env.body(base_);
    state.position = base.position;
    state.rotation = base.rotation;
  }

  /// The pose at the end of the present physics step.
  template <class Real>
  void control(const EnvView<Real>& env, State<Real>& state, ConstValues<Real>,
               Values<Real> output) const {
    Real time = (to_real(env.physics_step()) + 1.0) * dt_;
    const double last = stations_.back().time;
    if (repeat_.value()) time = time - last * floor(time * (1.0 / last));
    Vec3<Real> shift = control::lift<Real>(stations_[0].position),
               turn = control::lift<Real>(stations_[0].rpy);
    for (std::size_t i = 1; i < stations_.size(); ++i) {
      const Station &from = stations_[i - 1], &to = stations_[i];
      const Real share = clamp((time - from.time) * (1.0 / (to.time - from.time)), 0.0, 1.0);
      const Real way = smooth(share);
      shift += control::lift<Real>(to.position - from.position) * way;
      turn += control::lift<Real>(to.rpy - from.rpy) * way;
    }
    output.set(0, state.position + shift);
    output.set(3, from_rpy(turn.x, turn.y, turn.z) * state.rotation);
  }

 private:
  struct Station {
    double time;
    Vec3<double> position, rpy;
  };

  /// Minimum-jerk curve from 0 to 1: velocity and acceleration are 0 at both ends.
  template <class Real>
  static SKYBODY_INLINE Real smooth(const Real& share) {
    return share * share * share * (10.0 + share * (6.0 * share - 15.0));
  }

  void check_times() const {
    if (times_.count() < 2 || times_.value(0) != 0.0) {
      refuse(
          "`times` has ", times_.count(), " values",
          (times_.count() > 0 ? ", the first " + to_text(times_.value(0)) + " s" : std::string()),
          ": allowed are two or more, from 0 s on; give a time for each of `positions`");
    }
    for (int i = 1; i < times_.count(); ++i) {
      if (times_.value(i) - times_.value(i - 1) >= dt_) continue;
      refuse("`times[", i, "]` is ", times_.value(i),
             " s, less than a physics step after the one before: let times grow");
    }
  }

  void check_count(const std::string& name, int count, bool may_be_left_out) const {
    const int needed = 3 * times_.count();
    if (count == needed || (may_be_left_out && count == 0)) return;
    refuse("`", name, "` has ", count, " values; allowed: ", needed, ", three for each of `times`");
  }

  void read_stations() {
    stations_.clear();
    for (int i = 0; i < times_.count(); ++i) {
      Station station{times_.value(i), {}, {0.0, 0.0, 0.0}};
      const auto at = [i](const RealsParameter& values) {
        return Vec3<double>{values.value(3 * i), values.value(3 * i + 1), values.value(3 * i + 2)};
      };
      station.position = at(positions_);
      if (rpy_.count() > 0) station.rpy = at(rpy_);
      stations_.push_back(station);
    }
  }

  /// Positions count from the reset: a first position other than 0 would be a jump.
  void check_start() const {
    if (norm(stations_[0].position) == 0.0 && norm(stations_[0].rpy) == 0.0) return;
    refuse(
        "the first of `positions` and `rpy` are not 0, but the base is where it is at the reset: "
        "begin with 0, 0, 0 and move the robot's `pose`");
  }

  /// A loop that does not close would jump.
  void check_loop() const {
    const Station &first = stations_.front(), &last = stations_.back();
    if (norm(first.position - last.position) <= 1e-9 && norm(first.rpy - last.rpy) <= 1e-9) return;
    refuse(
        "`repeat` is true, but the last of `positions` and `rpy` are not the first: end where it "
        "begins, or leave `repeat` out");
  }

  RealsParameter times_{this, required(list("times", "s", {}, at_least(0.0),
                                            "time of each station; the first is 0, the reset"))};
  RealsParameter positions_{
      this,
      required(
          list("positions", "m", {}, kAny,
               "x, y, z of each station relative to the base's position at the reset, axes of W"))};
  RealsParameter rpy_{this, list("rpy", "rad", {}, kAny,
                                 "roll, pitch, yaw of each station about W's axes, relative to the "
                                 "reset; none: no rotation")};
  BooleanParameter repeat_{this, boolean("repeat", false, "start again after the last station")};

  int base_ = 0;
  double dt_ = 0.0;
  std::vector<Station> stations_;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Rail, "rail", "1.0.0", "Moves the base along a path over time; no input.");
