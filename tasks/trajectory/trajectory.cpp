// The paper's trajectory tracking: fly along a path that is known a moment ahead.
#include "controllers/common/flatness.h"
#include "controllers/common/path_check.h"
#include "tasks/trajectory/limits.h"
#include "tasks/trajectory/observed.h"

namespace skybody {
namespace {

using namespace task_kit;
using reference::derivative;
using reference::Moment;
using reference::PathNumbers;

class Trajectory : public Task {
 public:
  static constexpr bool kSmooth = true;

  template <class Real>
  struct State {
    reference::PathStart<Real> path;
    Real error_sum;  ///< sum of the distances after `settle` [m]
    Real counted;    ///< number of steps in the sum
  };

  void configure(const Setup& setup) override {
    robot_.configure(setup, "trajectory");
    const int robot = robot_.index();
    dt_ = setup.dt();
    step_ = dt_ * setup.action_repeat();
    gravity_ = {setup.gravity()[0], setup.gravity()[1], setup.gravity()[2]};
    window_ = {static_cast<int>(moments_.value()), spacing_.value()};
    observed_.configure(setup, {.history = static_cast<int>(entries_.value()),
                                .window = window_.count,
                                .matrices = matrices_.value(),
                                .body_axes = axes_.value() == "body",
                                .past_actions = past_actions_.value(),
                                .robot = robot,
                                .actions = robot_.action.count()});
    require_memory(setup);
    require_path(setup, robot);
    distance_info_ =
        infos_.add(setup, "position_error", "m", "distance from the path's present position");
    yaw_info_ = infos_.add(setup, "yaw_error", "rad", "magnitude of the yaw error, 0 .. pi");
    speed_info_ = infos_.add(setup, "speed", "m/s", "speed of the base's frame");
    mean_info_ = infos_.add(setup, "mean_error", "m",
                            "mean of `position_error` since `settle`; before, its present value");
    limits_.configure(setup, infos_);
    success_ = declare_success(setup, infos_,
                               "`settle` is over and `mean_error` is below `success_distance`");
    setup.goal(robot, robot_.body());
  }

  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state, Values<Real>) const {
    state.path = path_start(path_parameters_, path_, env, env.body(robot_.body()).position);
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>& state, Evaluation<Real>& out,
                Values<Real> buffer) const {
    const PathNumbers<Real> numbers = path_numbers(path_parameters_, env, state.path);
    const tracking::Flight<Real> flight = observed_.flight(env.body(robot_.body()));
    const Values<Real>& row = out.observation;
    observed_.past(
        env, flight, [&](int k) { return robot_.action.value(env, k); }, buffer, row);
    const Real now = time(env);
    const Moment<Real, 3> moment = path_.at<3>(numbers, now);
    look_ahead(numbers, now, moment, flight, row);
    const Vec3<Real> error = derivative(moment.point, 0) - flight.body.position;
    const Vec3<Real> slip = derivative(moment.point, 1) - flight.body.velocity;
    const Real yaw_error = wrap_angle(moment.yaw.c[0] - heading(flight.body.rotation));
    observed_.present(flight, yaw_error, row);

    const Real distance = norm(error);
    const Real mean = count(env, now, distance, state);
    if (out.wants_info()) {
      distance_info_.set(out.info, distance);
      yaw_info_.set(out.info, abs(yaw_error));
      speed_info_.set(out.info, norm(flight.body.velocity));
      mean_info_.set(out.info, mean);
    }
    Verdict<Real> verdict(out);
    limits_.judge(verdict, flight.body);
    out.set_reward(select(verdict.failed(), Real(failure_reward_.value()),
                          reward(env, flight.body, error, slip, distance, yaw_error)));
    verdict.succeed(success_, logical_and(state.counted > 0.0, mean < success_distance_.value()));
  }

  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>& state, Values<Real> goal) const {
    const auto moment = path_.at<2>(path_numbers(path_parameters_, env, state.path), time(env));
    goal.set(0, derivative(moment.point, 0));
    goal.set(3, wrap_angle(moment.yaw.c[0]));
  }

  template <class Real>
  void goal_motion(const EnvView<Real>& env, const State<Real>& state, Values<Real> motion) const {
    const auto moment = path_.at<3>(path_numbers(path_parameters_, env, state.path), time(env));
    motion.set(0, derivative(moment.point, 1));
    motion.set(3, derivative(moment.point, 2));
  }

 private:
  // Weights of the reference's reward, gzdrl's task `trajectory`.
  static constexpr double kSideWeight = 0.1, kHeightWeight = 2.0;            // [1/m^2]
  static constexpr double kSideSlipWeight = 0.002, kClimbSlipWeight = 0.04;  // [s^2/m^2]
  static constexpr double kRateWeight = 0.01;                                // [s^2]
  static constexpr double kActionWeight = 0.01;
  // Weights of the optional terms.
  static constexpr double kPrecisionWeight = 5.0;  // 1 / 0.2 m
  static constexpr double kHeadingWeight = 4.0;    // (1 / 0.5 rad)^2

  void require_memory(const Setup& setup) const {
    require_within_horizon(setup, static_cast<int>(entries_.value()), "history");
    const double episode = setup.horizon() * step_;
    const double ahead = (window_.count - 1) * window_.spacing;
    if (episode <= 0.0 || ahead < episode) return;
    refuse("`window` and `spacing` look ahead by ", ahead, " s, and an episode ends after ",
           episode, " s: look less far");
  }

  void require_path(const Setup& setup, int robot) {
    path_ = path_parameters_.path();
    control::PathCheck::require_length(path_parameters_, path_);
    const PathNumbers<double> numbers = nominal_numbers(path_parameters_, path_);
    limits_.require_within(numbers, path_, setup.horizon() * step_);
    check_.require_flyable_path(setup, robot, path_parameters_, path_);
  }

  /// Time since the reset [s].
  template <class Real>
  SKYBODY_INLINE Real time(const EnvView<Real>& env) const {
    return to_real(env.physics_step()) * dt_;
  }
  /// Yaw as in the controllers: the heading, followed by the shortest tilting rotation [rad].
  template <class Real>
  static SKYBODY_INLINE Real heading(const Quat<Real>& q) {
    return wrap_angle(2.0 * atan2(q.z, q.w));
  }

  template <class Real>
  SKYBODY_INLINE void look_ahead(const PathNumbers<Real>& numbers, const Real& now,
                                 const Moment<Real, 3>& first, const tracking::Flight<Real>& flight,
                                 const Values<Real>& row) const {
    for (int i = 0; i < window_.count; ++i) {
      const Moment<Real, 3> moment = i == 0 ? first : path_.at<3>(numbers, window_.time(now, i));
      observed_.ahead(i, flight, ahead(moment), row);
    }
  }

  template <class Real>
  SKYBODY_INLINE tracking::Ahead<Real> ahead(const Moment<Real, 3>& moment) const {
    tracking::Ahead<Real> out{derivative(moment.point, 0), derivative(moment.point, 1),
                              Quat<Real>::identity()};
    if (observed_.has_matrices()) {
      const Vec3<Real> push = derivative(moment.point, 2) - control::lift<Real>(gravity_);
      out.rotation = control::flat_attitude(push, moment.yaw.c[0]).rotation;
    }
    return out;
  }

  /// Adds a step to the mean error. @returns the mean so far [m]
  template <class Real>
  SKYBODY_INLINE Real count(const EnvView<Real>& env, const Real& now, const Real& distance,
                            State<Real>& state) const {
    const auto counts = logical_and(env.step() > Word<Real>(0), now > settle_.value());
    state.error_sum = select(counts, state.error_sum + distance, state.error_sum);
    state.counted = select(counts, state.counted + 1.0, state.counted);
    return select(state.counted > 0.0, state.error_sum / max(state.counted, Real(1.0)), distance);
  }

  /// The reference's reward, with optional shaping terms of the scenario.
  template <class Real>
  SKYBODY_INLINE Real reward(const EnvView<Real>& env, const BodyMotion<Real>& body,
                             const Vec3<Real>& error, const Vec3<Real>& slip, const Real& distance,
                             const Real& yaw_error) const {
    Real action(0.0);
    for (int k = 0; k < robot_.action.count(); ++k) {
      const Real value = robot_.action.value(env, k);
      action += value * value;
    }
    const Real cost = kSideWeight * (error.x * error.x + error.y * error.y) +
                      kHeightWeight * (error.z * error.z) +
                      kSideSlipWeight * (slip.x * slip.x + slip.y * slip.y) +
                      kClimbSlipWeight * (slip.z * slip.z) +
                      kRateWeight * squared_norm(body.angular_velocity) + kActionWeight * action;
    return closeness(cost, 1.0) +
           precision_reward_.value() * closeness(distance, kPrecisionWeight) +
           heading_reward_.value() * closeness(yaw_error * yaw_error, kHeadingWeight);
  }

  OneRobot robot_{this};
  IntegerParameter entries_{
      this, integer("history", "", 20, between(1, 256), "number of observed past steps")};
  IntegerParameter moments_{this,
                            integer("window", "", 20, between(1, 256),
                                    "number of observed moments of the path, the first is now")};
  RealParameter spacing_{
      this, real("spacing", "s", 0.01, between(1e-6, 1e3), "time between two of these moments")};
  BooleanParameter matrices_{
      this,
      boolean(
          "matrices", true,
          "observe past and future rotation matrices; false: the present attitude and yaw error")};
  TextParameter axes_{
      this, choice("axes", "world", {"world", "body"}, "axes of observed velocities and errors")};
  BooleanParameter past_actions_{
      this,
      boolean(
          "past_actions", true,
          "the history contains the actions; false: a policy that needs them must have memory")};
  reference::PathParameters path_parameters_{this};
  control::PathCheck check_{this};
  tracking::PathLimits limits_{this};

  RealParameter failure_reward_{this, real("failure_reward", "", -50.0, at_most(0.0),
                                           "reward of the step in which the robot fails")};
  RealParameter precision_reward_{
      this, real("precision_reward", "", 0.0, at_least(0.0),
                 "weight of 1 / (1 + |e| / 0.2 m) in the reward: a gradient close to the path")};
  RealParameter heading_reward_{this,
                                real("heading_reward", "", 0.0, at_least(0.0),
                                     "weight of 1 / (1 + (e_psi / 0.5 rad)^2) in the reward")};
  RealParameter settle_{
      this,
      real("settle", "s", 3.0, at_least(0.0),
           "time after a reset in which errors do not count; a shorter episode is no success")};
  RealParameter success_distance_{this, real("success_distance", "m", 0.1, at_least(0.0),
                                             "a mean error below this is a success")};

  tracking::Observed observed_;
  InfoParts infos_;
  Part distance_info_, yaw_info_, speed_info_, mean_info_, success_;
  Window window_;
  reference::Path path_;
  Vec3<double> gravity_{};
  double dt_ = 0.0, step_ = 0.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Trajectory, "trajectory", "1.0.0",
               "Fly along a path that is known a moment ahead.");
