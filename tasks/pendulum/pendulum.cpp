// The paper's inverted pendulum: bring a bob that stands on the robot to a point, upright.
#include <skybody/task_kit.h>

#include <vector>

namespace skybody {
namespace {

using namespace task_kit;

/// Not kSmooth: accelerations use the motion of the previous physics step, which has no tangents.
class Pendulum : public Task {
 public:
  void configure(const Setup& setup) override {
    robot_.configure(setup, "pendulum");
    const int robot = robot_.index();
    find_bodies(setup, robot);
    dt_ = setup.dt();
    require_within_horizon(setup, steps_.value(), "history");
    require_within(target_, "target", limits_.bound());
    require_above(target_, "target", height_min_.value());
    if (is_privileged_.value()) setup.need_bodies_before();
    declare_states(setup, robot);
    if (is_privileged_.value()) declare_privileged(setup, robot);
    error_info_ = infos_.add(setup, "position_error", "m", "distance of the bob from the target");
    upright_info_ =
        infos_.add(setup, "upright", "", "z of the unit vector from the base to the bob");
    tilt_info_ = infos_.add(setup, "tilt", "rad", "tilt of the base, 0 .. pi");
    limits_.configure(setup, infos_);
    low_failure_ = declare_failure(setup, infos_, "low", "the base below `height_min`");
    fallen_failure_ =
        declare_failure(setup, infos_, "fallen", "the pendulum less upright than `upright_min`");
    success_ = declare_success(setup, infos_, "the bob within `success_distance` of the target");
    setup.buffer(memory_.size());
    setup.goal(robot, bob_.body, bob_.point);
  }

  template <class Real>
  struct State {
    Real distance;  ///< distance of the bob from the target, one step ago [m]
  };

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>& state, Evaluation<Real>& out,
                Values<Real> buffer) const {
    const BodyMotion<Real> base = env.body(robot_.body()), bob = bob_.at(env.body(bob_.body));
    const Vec3<Real> error = bob.position - target_.vec3(env);
    const Vec3<Real> offset = bob.position - base.position;
    remember(env, base, bob, error, offset, buffer);
    observe(env, buffer, out.observation);

    const Real distance = norm(error), upright = offset.z / norm(offset);
    const PassedLimits<Real> passed = limits_.passed(base);
    const MaskOf<Real> low = base.position.z < height_min_.value();
    const MaskOf<Real> fallen = upright < upright_min_.value();
    out.set_reward(kProgressReward * progress(env, distance, state.distance) + kAliveReward +
                   upright + shaping_.reward(distance, yaw(base.rotation)) -
                   shaping_.cost(base.rotation) +
                   failure_reward_.value() * count(passed, low, fallen));
    Verdict<Real> verdict(out);
    limits_.judge(verdict, passed);
    verdict.fail(low_failure_, low);
    verdict.fail(fallen_failure_, fallen);
    verdict.succeed(success_, distance < success_distance_.value());
    if (!out.wants_info()) return;
    error_info_.set(out.info, distance);
    upright_info_.set(out.info, upright);
    tilt_info_.set(out.info, tilt(base.rotation));
  }

  /// Goal pose of the bob's body, in its present orientation.
  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>&, Values<Real> goal) const {
    goal.set(0, target_.vec3(env) - rotate(env.body(bob_.body).rotation, bob_.lever<Real>()));
    goal.set(3, Real(0.0));
  }

 private:
  static constexpr double kProgressReward = 2.0;  // [1/m]
  static constexpr double kAliveReward = 0.01;

  /// A quantity over the last steps: its history, and its place in the observation.
  struct Track {
    History history;
    Part part;
  };
  struct Observed {
    Track bob_error, bob_offset, bob_velocity, bob_rates, velocity, attitude, rates, past_actions;
  };

  void find_bodies(const Setup& setup, int robot) {
    const RobotInfo& info = setup.robots()[robot];
    const LinkInfo& link = setup.link(robot, link_.value());
    bob_ = {link.body, {link.com[0], link.com[1], link.com[2]}};
    if (bob_.body == robot_.body()) {
      refuse("link `", link_.value(), "` is fixed to the base of robot `", info.name,
             "`: name one that stands on a joint, or put a joint between them");
    }
    base_param_ = setup.bodies()[robot_.body()].first_param;
    for (const RotorInfo& rotor : setup.rotors_of(robot))
      rotor_params_.push_back(rotor.first_param);
  }

  Track track(const Setup& setup, int robot, const char* name, const char* unit, int width,
              const char* doc, double bound = kInfinity, bool privileged = false) {
    const int steps = steps_.value();
    Track made;
    made.history = History(memory_, steps, width);
    made.part =
        parts_.add(setup, {name, unit, steps * width, doc, -bound, bound, robot, privileged});
    return made;
  }

  void declare_states(const Setup& setup, int robot) {
    seen_.bob_error = track(setup, robot, "bob_error", "m", 3, "bob - target, W");
    seen_.bob_offset = track(setup, robot, "bob_offset", "m", 3, "bob - position of the base, W");
    seen_.bob_velocity =
        track(setup, robot, "bob_velocity", "m/s", 3, "velocity of the bob's centre of mass, W");
    seen_.bob_rates = track(setup, robot, "bob_angular_velocity", "rad/s", 3,
                            "angular velocity of the bob, in its axes");
    seen_.velocity = track(setup, robot, "velocity", "m/s", 3, "velocity of the base's frame, W");
    seen_.attitude = track(setup, robot, "attitude", "", 4,
                           "quaternion w x y z of the base, W from B, with w >= 0", 1.0);
    seen_.rates =
        track(setup, robot, "angular_velocity", "rad/s", 3, "angular velocity of the base, B");
    seen_.past_actions = track(setup, robot, "actions", "", robot_.action.count(),
                               "actions in [-1, 1]; -1 before the first", 1.0);
  }

  void declare_privileged(const Setup& setup, int robot) {
    const char* doc =
        "rates of change of position (W), velocity (W), quaternion, angular velocity (own axes); "
        "the second and the last over one physics step, 0 at a reset";
    base_change_ = track(setup, robot, "base_derivative", "SI", kDerivatives, doc, kInfinity, true);
    bob_change_ = track(setup, robot, "bob_derivative", "SI", kDerivatives, doc, kInfinity, true);
    const auto constant = [&](const char* name, const char* unit, int count, const char* what) {
      return parts_.add(setup, {name, unit, count, what, -kInfinity, kInfinity, robot, true});
    };
    mass_ = constant("mass", "kg", 1, "mass of the base, as drawn");
    inertia_ = constant("inertia", "kg m^2", 3, "inertia xx yy zz of the base, as drawn");
    lags_ = constant("lags", "s", 2, "tau_up and tau_down as drawn, means over the rotors");
  }

  template <class Real>
  SKYBODY_INLINE void remember(const EnvView<Real>& env, const BodyMotion<Real>& base,
                               const BodyMotion<Real>& bob, const Vec3<Real>& error,
                               const Vec3<Real>& offset, const Values<Real>& buffer) const {
    const MaskOf<Real> stepped = History::has_stepped(env);
    note<Real>(stepped, buffer, seen_.bob_error, error);
    note<Real>(stepped, buffer, seen_.bob_offset, offset);
    note<Real>(stepped, buffer, seen_.bob_velocity, bob.velocity);
    note<Real>(stepped, buffer, seen_.bob_rates, bob.angular_velocity);
    note<Real>(stepped, buffer, seen_.velocity, base.velocity);
    const Quat<Real> q = canonical(base.rotation);
    const Real attitude[4] = {q.w, q.x, q.y, q.z};
    seen_.attitude.history.note<Real>(stepped, buffer, [&](int k) { return attitude[k]; });
    note<Real>(stepped, buffer, seen_.rates, base.angular_velocity);
    seen_.past_actions.history.note<Real>(stepped, buffer, [&](int k) {
      return select(stepped, robot_.action.value(env, k), Real(-1.0));
    });
    if (!is_privileged_.value()) return;
    note_change<Real>(stepped, buffer, base_change_, base, env.body_before(robot_.body()));
    note_change<Real>(stepped, buffer, bob_change_, bob, bob_.at(env.body_before(bob_.body)));
  }

  template <class Real>
  static SKYBODY_INLINE void note(const MaskOf<Real>& stepped, const Values<Real>& buffer,
                                  const Track& track, const Vec3<Real>& value) {
    const Real values[3] = {value.x, value.y, value.z};
    track.history.note<Real>(stepped, buffer, [&](int k) { return values[k]; });
  }

  template <class Real>
  SKYBODY_INLINE void note_change(const MaskOf<Real>& stepped, const Values<Real>& buffer,
                                  const Track& track, const BodyMotion<Real>& now,
                                  const BodyMotion<Real>& before) const {
    const Vec3<Real>& w = now.angular_velocity;
    const Quat<Real> turn = canonical(now.rotation) * Quat<Real>{Real(0.0), w.x, w.y, w.z};
    const Vec3<Real> none{Real(0.0), Real(0.0), Real(0.0)};
    const Vec3<Real> a = select(stepped, (now.velocity - before.velocity) / dt_, none);
    const Vec3<Real> alpha =
        select(stepped, (now.angular_velocity - before.angular_velocity) / dt_, none);
    const Vec3<Real>& v = now.velocity;
    const Real values[kDerivatives] = {
        v.x,          v.y,          v.z,          a.x,     a.y,     a.z,    0.5 * turn.w,
        0.5 * turn.x, 0.5 * turn.y, 0.5 * turn.z, alpha.x, alpha.y, alpha.z};
    track.history.note<Real>(stepped, buffer, [&](int k) { return values[k]; });
  }

  template <class Real>
  SKYBODY_INLINE void observe(const EnvView<Real>& env, const Values<Real>& buffer,
                              const Values<Real>& row) const {
    for (const Track* track :
         {&seen_.bob_error, &seen_.bob_offset, &seen_.bob_velocity, &seen_.bob_rates,
          &seen_.velocity, &seen_.attitude, &seen_.rates, &seen_.past_actions}) {
      track->history.observe(buffer, track->part, row);
    }
    if (!is_privileged_.value()) return;
    base_change_.history.observe(buffer, base_change_.part, row);
    bob_change_.history.observe(buffer, bob_change_.part, row);
    mass_.set(row, env.param(base_param_ + SKYBODY_BODY_MASS));
    for (int k = 0; k < 3; ++k)
      inertia_.set(row, env.param(base_param_ + SKYBODY_BODY_INERTIA + k), k);
    lags_.set(row, mean_lag(env, SKYBODY_ROTOR_TAU_UP), 0);
    lags_.set(row, mean_lag(env, SKYBODY_ROTOR_TAU_DOWN), 1);
  }

  template <class Real>
  SKYBODY_INLINE Real mean_lag(const EnvView<Real>& env, int constant) const {
    Real sum(0.0);
    for (const int first : rotor_params_) sum += env.param(first + constant);
    return sum / static_cast<double>(rotor_params_.size());
  }

  /// Number of violated limits.
  template <class Real>
  static SKYBODY_INLINE Real count(const PassedLimits<Real>& passed, const MaskOf<Real>& low,
                                   const MaskOf<Real>& fallen) {
    const auto one = [](const MaskOf<Real>& mask) { return select(mask, Real(1.0), Real(0.0)); };
    return one(passed.tilt) + one(passed.heading) + one(passed.bound) + one(low) + one(fallen);
  }

  static constexpr int kDerivatives = 13;  ///< 3 + 3 + 4 + 3

  OneRobot robot_{this};
  TextParameter link_{this, word("bob_link", "bob", "link whose centre of mass is the bob")};
  RealsParameter target_{
      this, randomizable(reals("target", "m", {0.0, 0.0, 2.0}, kAny, "target of the bob (W)"))};
  IntegerParameter steps_{this,
                          integer("history", "", 10, between(1, 100), "number of observed steps")};
  BooleanParameter is_privileged_{
      this,
      boolean("privileged", true, "give a critic derivatives, mass, inertia and lags as well")};
  FlightLimits limits_{this, {.tilt_max = 1.57, .yaw_max = 4.0, .bound = 10.0}};
  RealParameter height_min_{
      this, real("height_min", "m", 0.3, kAny, "a robot fails below this height (W z)")};
  RealParameter upright_min_{
      this, real("upright_min", "", 0.2, between(-1.0, 1.0),
                 "a robot fails if the unit vector from the base to the bob has a smaller z (W)")};
  RealParameter failure_reward_{
      this, real("failure_reward", "", -5.0, at_most(0.0), "added for every violated limit")};
  GoalShaping shaping_{this};
  RealParameter success_distance_{
      this, real("success_distance", "m", 0.3, at_least(0.0),
                 "the bob has arrived if closer than this to the target (info `success`)")};

  ObservationParts parts_;
  InfoParts infos_;
  BufferPlan memory_;
  Observed seen_;
  Track base_change_, bob_change_;
  Part mass_, inertia_, lags_;
  Part error_info_, upright_info_, tilt_info_, low_failure_, fallen_failure_, success_;
  BodyPoint bob_;  ///< the centre of mass of the bob
  int base_param_ = 0;
  std::vector<int> rotor_params_;  ///< first EnvParam of each rotor
  double dt_ = 0.0;                ///< [s]
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Pendulum, "pendulum", "1.0.0", "Balance a pendulum above a robot.");
