// Land on a deck that may move: softly, level, and within its edges.
#include <skybody/task_kit.h>

#include "tasks/landing/deck.h"

namespace skybody {
namespace {

using namespace task_kit;
using landing::OverDeck;

class Landing : public Task {
 public:
  template <class Real>
  struct State {
    Real distance;  ///< from the landing point, after the previous action [m]
    Real speed;     ///< relative to the deck, after the previous action [m/s]
  };

  void configure(const Setup& setup) override {
    const int pad = setup.robot(pad_.value());
    const int robot = robot_of(setup, pad);
    const RobotInfo& info = setup.robots()[robot];
    body_ = info.first_body;
    action_ = ActionPart(info, "landing");
    step_time_ = setup.dt() * setup.action_repeat();
    hull_.configure(setup, robot);
    deck_.configure(setup, pad);
    check_limits();
    const double(&place)[3] = setup.robots()[pad].position;
    require_within(Vec3<double>{place[0], place[1], place[2]}, "the pad `" + pad_.value() + "`",
                   limits_.bound());
    declare(setup, robot);
    setup.goal(robot, body_);
  }

  template <class Real>
  void evaluate(const EnvView<Real>& env, State<Real>& state, Evaluation<Real>& out) const {
    const BodyMotion<Real> body = env.body(body_);
    const OverDeck<Real> at = hull_.over(deck_, env);
    const Real speed = norm(at.velocity);
    const Real distance = norm(at.position.x, at.position.y, max(at.height, Real(0.0)));
    observe(env, body, at, out.observation);
    if (out.wants_info()) {
      distance_info_.set(out.info, distance);
      speed_info_.set(out.info, speed);
      tilt_info_.set(out.info, tilt(at.rotation));
    }
    const auto stepped = env.step() > Word<Real>(0);
    const Touch<Real> touch = judge_touch(at, speed, select(stepped, state.speed, speed));
    const MaskOf<Real> outside =
        logical_or(at.position.z<0.0, norm(at.position)> distance_max_.value());
    const Real time = to_real(env.step()) * step_time_;
    const MaskOf<Real> late =
        logical_and(MaskOf<Real>(time_max_.value() > 0.0), time >= time_max_.value());
    Verdict<Real> verdict(out);
    limits_.judge(verdict, limits_.passed(body));
    verdict.fail(crash_failure_, touch.crash);
    verdict.fail(outside_failure_, outside);
    const MaskOf<Real> landed = logical_and(touch.landed, logical_not(verdict.failed()));
    verdict.fail(time_failure_, logical_and(late, logical_not(landed)));
    verdict.finish(success_, landed);
    out.set_reward(reward(env, body, distance, speed, state) +
                   select(landed, Real(landing_reward_.value()), Real(0.0)) +
                   select(verdict.failed(), Real(failure_reward_.value()), Real(0.0)));
    state.speed = speed;
  }

  /// Goal: over the deck's centre, sinking slowly, but not below a cone while the robot is off the
  /// axis.
  template <class Real>
  void goal(const EnvView<Real>& env, const State<Real>&, Values<Real> goal) const {
    const OverDeck<Real> at = hull_.over(deck_, env);
    const Vec3<Real> place{Real(0.0), Real(0.0), at.position.z - min(room(at), Real(0.0))};
    const Quat<Real> turn = deck_.rotation(env);
    goal.set(0, deck_.middle(env) + rotate(turn, place));
    goal.set(3, yaw(turn));
  }

  template <class Real>
  void goal_motion(const EnvView<Real>& env, const State<Real>&, Values<Real> motion) const {
    const OverDeck<Real> at = hull_.over(deck_, env);
    const Real down = descent_.value() * clamp(room(at) / kRoom, Real(0.0), Real(1.0));
    motion.set(0, deck_.velocity(env, env.body(body_).position) -
                      rotate(deck_.rotation(env), Vec3<Real>{Real(0.0), Real(0.0), down}));
    motion.set(3, Vec3<Real>{Real(0.0), Real(0.0), Real(0.0)});
  }

 private:
  // The cone of the baseline's descent: 2 m higher for each metre beyond 0.25 m aside.
  static constexpr double kNear = 0.25, kSteepness = 2.0, kRoom = 0.3;

  template <class Real>
  struct Touch {
    MaskOf<Real> crash, landed;
  };

  /// Whether and how the robot touches the deck. The approach speed is that of the previous action,
  /// because contact has stopped the robot since.
  template <class Real>
  SKYBODY_INLINE Touch<Real> judge_touch(const OverDeck<Real>& at, const Real& speed,
                                         const Real& speed_before) const {
    const Real upright = tilt_cosine(at.rotation);
    const MaskOf<Real> touches =
        logical_and(at.height < touch_height_.value(), deck_.is_under(at.position, 0.0));
    const MaskOf<Real> hard = speed_before > crash_speed_.value();
    const MaskOf<Real> crash = logical_and(touches, logical_or(hard, upright < crash_cosine_));
    const MaskOf<Real> rests = logical_and(speed <= rest_speed_.value(), upright >= rest_cosine_);
    return {crash,
            logical_and(logical_and(touches, rests), deck_.is_under(at.position, inset_.value()))};
  }

  template <class Real>
  SKYBODY_INLINE Real reward(const EnvView<Real>& env, const BodyMotion<Real>& body,
                             const Real& distance, const Real& speed, State<Real>& state) const {
    const Real gain = progress(env, distance, state.distance);
    const Real allowed = rest_speed_.value() + approach_rate_.value() * distance;
    return progress_reward_.value() * gain - speed_cost_.value() * max(speed - allowed, Real(0.0)) -
           rate_cost_.value() * squared_norm(body.angular_velocity);
  }

  template <class Real>
  SKYBODY_INLINE void observe(const EnvView<Real>& env, const BodyMotion<Real>& body,
                              const OverDeck<Real>& at, const Values<Real>& row) const {
    position_error_.set(row, Vec3<Real>{-at.position.x, -at.position.y, -at.height});
    velocity_.set(row, at.velocity);
    yaw_error_.set(row, -yaw(at.rotation));
    attitude_.set(row, canonical(at.rotation));
    angular_velocity_.set(row, body.angular_velocity);
    action_.set(env, row);
  }

  /// Height above the cone [m], and kRoom.
  template <class Real>
  SKYBODY_INLINE Real room(const OverDeck<Real>& at) const {
    const Real aside = norm(at.position.x, at.position.y);
    return kRoom + at.height - kSteepness * max(aside - kNear, Real(0.0));
  }

  /// The robot that lands: named, or the only one that takes actions.
  int robot_of(const Setup& setup, int pad) const {
    if (!robot_.value().empty()) {
      const int robot = setup.robot(robot_.value());
      if (robot != pad) return robot;
      refuse("`robot` and `pad` are both `", robot_.value(), "`: name another robot to land on");
    }
    int found = -1;
    for (int r = 0; r < setup.robots().size(); ++r) {
      if (setup.robots()[r].action_count == 0 || r == pad) continue;
      if (found >= 0) refuse("several robots take actions: name one by `robot`");
      found = r;
    }
    if (found >= 0) return found;
    refuse(
        "no robot but the pad takes actions, so that none can land: give one a controller, such as "
        "`rotor_speed`");
  }

  void check_limits() {
    if (rest_speed_.value() > crash_speed_.value()) {
      refuse("`rest_speed` ", rest_speed_.value(), " is above `crash_speed` ", crash_speed_.value(),
             ": swap them");
    }
    if (rest_tilt_.value() > crash_tilt_.value()) {
      refuse("`rest_tilt` ", rest_tilt_.value(), " is above `crash_tilt` ", crash_tilt_.value(),
             ": swap them");
    }
    const double half = min(deck_.half_x(), deck_.half_y());
    if (inset_.value() >= half) {
      refuse("`inset` ", inset_.value(), " leaves nothing of the deck; allowed: less than ", half);
    }
    crash_cosine_ = tilt_cosine_limit(crash_tilt_.value());
    rest_cosine_ = tilt_cosine_limit(rest_tilt_.value());
  }

  void declare(const Setup& setup, int robot) {
    const RobotParts part(setup, observation_, robot);
    position_error_ = part(
        "position_error", "m", 3,
        "x, y: deck's centre - position; z: its top face - the robot's lowest point; deck axes");
    velocity_ = part("velocity", "m/s", 3, "velocity relative to the deck, deck axes");
    yaw_error_ = part("yaw_error", "rad", 1, "the deck's yaw - own yaw", kPi);
    attitude_ = part("attitude", "", 4, "quaternion w x y z, deck from B, with w >= 0", 1.0);
    angular_velocity_ = part("angular_velocity", "rad/s", 3, "angular velocity of the base, B");
    action_.declare(part);
    distance_info_ = infos_.add(setup, "position_error", "m",
                                "distance of the robot's lowest point from the deck's centre");
    speed_info_ = infos_.add(setup, "speed", "m/s", "speed relative to the deck");
    tilt_info_ = infos_.add(setup, "tilt", "rad", "tilt relative to the deck, 0 .. pi");
    limits_.configure(setup, infos_);
    crash_failure_ = declare_failure(setup, infos_, "crash",
                                     "touchdown faster than `crash_speed` or beyond `crash_tilt`");
    outside_failure_ = declare_failure(setup, infos_, "outside",
                                       "below the deck's top face, or beyond `distance_max`");
    time_failure_ = declare_failure(setup, infos_, "time", "not landed after `time_max`");
    success_ = declare_success(setup, infos_,
                               "on the deck, slow, level, within its edges; ends the episode");
  }

  TextParameter robot_{this,
                       word("robot", "", "name of the robot; optional if only one takes actions")};
  TextParameter pad_{this, word("pad", "pad", "robot whose base is the box to land on")};
  RealParameter touch_height_{
      this, real("touch_height", "m", 0.005, between(0.0, 1.0),
                 "the robot touches the deck if its lowest point is less than this above it")};
  RealParameter rest_speed_{this, real("rest_speed", "m/s", 0.2, at_least(0.0),
                                       "landed: largest speed relative to the deck")};
  RealParameter rest_tilt_{this, real("rest_tilt", "rad", 0.2, between(0.0, kPi),
                                      "landed: largest tilt relative to the deck")};
  RealParameter inset_{this, real("inset", "m", 0.1, at_least(0.0),
                                  "landed: least distance of the base from the deck's edges")};
  RealParameter crash_speed_{this, real("crash_speed", "m/s", 1.0, at_least(0.0),
                                        "a touch after a faster approach is a crash")};
  RealParameter crash_tilt_{this,
                            real("crash_tilt", "rad", 0.5, between(0.0, kPi),
                                 "a touch with a larger tilt relative to the deck is a crash")};
  RealParameter distance_max_{this, real("distance_max", "m", 5.0, at_least(0.0),
                                         "a robot fails farther than this from the deck's centre")};
  RealParameter time_max_{this,
                          real("time_max", "s", 0.0, at_least(0.0),
                               "a robot fails if it has not landed after this time; 0: never")};
  FlightLimits limits_{this};
  RealParameter progress_reward_{
      this, real("progress_reward", "1/m", 5.0, at_least(0.0), "reward per metre of approach")};
  RealParameter approach_rate_{
      this, real("approach_rate", "1/s", 1.0, at_least(0.0),
                 "the speed `rest_speed` + `approach_rate` * distance costs nothing")};
  RealParameter speed_cost_{
      this, real("speed_cost", "s/m", 0.05, at_least(0.0),
                 "cost per step of the speed above `rest_speed` + `approach_rate` * distance")};
  RealParameter rate_cost_{this, real("rate_cost", "s^2/rad^2", 0.001, at_least(0.0),
                                      "cost per squared angular velocity")};
  RealParameter landing_reward_{
      this, real("landing_reward", "", 20.0, at_least(0.0), "reward of a landing")};
  RealParameter failure_reward_{
      this, real("failure_reward", "", -10.0, at_most(0.0), "reward of a failure")};
  RealParameter descent_{
      this, real("descent", "m/s", 0.4, between(0.01, 100.0),
                 "speed at which the goal sinks to the deck, for the baseline `hold`")};

  ObservationParts observation_;
  InfoParts infos_;
  Part position_error_, velocity_, yaw_error_, attitude_, angular_velocity_;
  ActionPart action_;
  Part distance_info_, speed_info_, tilt_info_;
  Part crash_failure_, outside_failure_, time_failure_, success_;
  landing::Deck deck_;
  landing::TouchdownPoints hull_;
  int body_ = 0;
  double step_time_ = 0.0;  ///< duration of an action [s]
  double crash_cosine_ = -2.0, rest_cosine_ = -2.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Landing, "landing", "1.0.0",
               "Land on a deck that may move: softly, level, and within its edges.");
