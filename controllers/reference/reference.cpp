// Reference: a generated motion of the robot over time, without an input.
#include <skybody/plugin.h>

#include <stdexcept>

#include "controllers/common/path_check.h"
#include "controllers/common/robot.h"

namespace skybody {
namespace {

using reference::kOrders;
using reference::Moment;
using reference::PathNumbers;

class Reference : public Controller {
 public:
  static constexpr bool kSmooth = true;

  template <class Real>
  using State = reference::PathStart<Real>;

  void configure(const Setup& setup) override {
    base_ = control::base_of(setup, setup.robot());
    dt_ = setup.dt();
    path_ = parameters_.path();
    declare_output(setup);
    control::PathCheck::require_length(parameters_, path_);
    check_.require_flyable_path(setup, setup.robot(), parameters_, path_);
    setup.input(Signal::kNone, {}, {});
    setup.buffer(4);
    setup.report("position", "m", 3, 0);
    setup.report("yaw", "rad", 1, 3);
  }

  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state, Values<Real> buffer) const {
    state = path_start(parameters_, path_, env, env.body(base_).position);
    const PathNumbers<Real> numbers = path_numbers(parameters_, env, state);
    report(path_.at<kOrders>(numbers, Real(0.0)), 0.0, buffer);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>& state, ConstValues<Real>, Values<Real> output,
               Values<Real> buffer) const {
    const PathNumbers<Real> numbers = path_numbers(parameters_, env, state);
    const Real time = to_real(env.physics_step()) * dt_;
    const Moment<Real, kOrders> now = path_.at<kOrders>(numbers, time);
    write(now, output, 0);
    for (int i = 1; i < count_; ++i) {
      write(path_.at<kOrders>(numbers, time + spacing_.value() * i), output, i);
    }
    report(now, dt_, buffer);
  }

 private:
  template <class Real>
  SKYBODY_INLINE void write(const Moment<Real, kOrders>& moment, const Values<Real>& output,
                            int index) const {
    const ReferencePoint<Real> point = reference_point_of(moment);
    switch (gives_) {
      case Signal::kPosition:
        output.set(0, point.position);
        output.set(3, point.yaw);
        break;
      case Signal::kVelocityTracking:
        output.set(0, point.velocity);
        output.set(3, point.yaw_rate);
        break;
      case Signal::kAcceleration:
        output.set(0, point.acceleration);
        output.set(3, point.yaw);
        break;
      default:
        set_reference_point(output, point, index);
    }
  }

  /// Reports the reference at the end of the step to tables, pictures and learners, by the Taylor
  /// polynomial about a moment. Over a physics step it is exact to rounding, except for a step's
  /// jump, which appears one physics step late.
  template <class Real>
  SKYBODY_INLINE void report(const Moment<Real, kOrders>& moment, double later,
                             const Values<Real>& buffer) const {
    const auto at = [&](const Jet<Real, kOrders>& part) {
      Real sum = part.c[kOrders - 1];
      for (int k = kOrders - 2; k >= 0; --k) sum = sum * later + part.c[k];
      return sum;
    };
    buffer.set(0, Vec3<Real>{at(moment.point.x), at(moment.point.y), at(moment.point.z)});
    buffer.set(3, wrap_angle(moment.yaw.c[0] + moment.yaw.c[1] * later));
  }

  void declare_output(const Setup& setup) {
    const std::string& level = gives_name_.value();
    const bool is_trajectory = level == "trajectory";
    count_ = static_cast<int>(points_.value());
    if (!is_trajectory && count_ > 1) {
      refuse("`points` is ", count_, ", but `", level, "` is of one moment; allowed with it: 1");
    }
    gives_ = level == "position"            ? Signal::kPosition
             : level == "velocity_tracking" ? Signal::kVelocityTracking
             : level == "acceleration"      ? Signal::kAcceleration
                                            : Signal::kTrajectory;
    setup.output(gives_, is_trajectory ? kReferencePointSize * count_ : 4);
  }

  reference::PathParameters parameters_{this};
  TextParameter gives_name_{
      this,
      choice("gives", "trajectory", {"trajectory", "position", "velocity_tracking", "acceleration"},
             "output signal")};
  IntegerParameter points_{
      this, integer("points", "", 1, between(1, 256),
                    "number of points of a trajectory ahead in time, the first for now")};
  RealParameter spacing_{this,
                         real("spacing", "s", 0.05, between(1e-6, 1e3), "time between two points")};

  control::PathCheck check_{this};
  reference::Path path_;
  Signal gives_ = Signal::kTrajectory;
  int base_ = 0;
  int count_ = 1;
  double dt_ = 0.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Reference, "reference", "1.0.0",
               "Generates a reference motion over time: figure, waypoints or table; no input.");
